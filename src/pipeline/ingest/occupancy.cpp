#include "pipeline/ingest/occupancy.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "pipeline/run/phase.hpp"

namespace colossus::pipeline::ingest {
namespace {

using core::ByteReader;
using core::Bytes;
using core::ByteWriter;
using Cell = Occupancy::Cell;

constexpr std::uint64_t kTaskVertices = std::uint64_t{1} << 20;

std::uint32_t key_of(const std::array<std::uint8_t, 3>& at) {
  return std::uint32_t{at[0]} << 16 | std::uint32_t{at[1]} << 8 | at[2];
}

struct Count {
  std::uint32_t key = 0;
  std::uint32_t vertices = 0;
};

struct Counter {
  std::unordered_map<std::uint32_t, std::uint32_t> counts;

  void add(const facts::VertexBlockRef& block, const run::Workspace& workspace,
           const geometry::Lattice& lattice, const geometry::Bounds& bounds) {
    const Bytes raw = workspace.reader.read(block.record);
    ByteReader reader(raw);
    reader.get<facts::RawVerticesHeader>();
    std::uint32_t last_key = 0;
    std::uint32_t* last = nullptr;
    for (const auto& position : reader.get_array<std::array<double, 3>>(block.count)) {
      // Only vertices that no triangle uses lie outside, or nowhere.
      if (!bounds.contains(position)) continue;
      const geometry::Point p = lattice.input_vertex(position);
      std::array<std::uint8_t, 3> at;
      for (std::size_t axis = 0; axis < 3; ++axis)
        at[axis] =
            static_cast<std::uint8_t>(p[static_cast<int>(axis)] >> (geometry::kRootBits - Occupancy::kLevel));
      // The next vertex is most often in the same cell.
      if (last == nullptr || key_of(at) != last_key) {
        last_key = key_of(at);
        last = &counts[last_key];
      }
      ++*last;
    }
  }
};

std::vector<std::size_t> task_begins(const std::vector<facts::VertexBlockRef>& blocks) {
  std::vector<std::size_t> begins{0};
  std::uint64_t count = 0;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    count += blocks[i].count;
    if (count < kTaskVertices && i + 1 < blocks.size()) continue;
    begins.push_back(i + 1);
    count = 0;
  }
  return begins;
}

}  // namespace

double Occupancy::cubes_at(int level) const {
  const int shift = std::max(kLevel - level, 0);
  std::vector<std::uint32_t> keys;
  for (const Cell& cell : cells)
    keys.push_back(static_cast<std::uint32_t>(cell.at[0] >> shift) << 16 |
                   static_cast<std::uint32_t>(cell.at[1] >> shift) << 8 |
                   static_cast<std::uint32_t>(cell.at[2] >> shift));
  std::sort(keys.begin(), keys.end());
  const auto count = std::unique(keys.begin(), keys.end()) - keys.begin();
  return std::ldexp(static_cast<double>(count), 2 * std::max(level - kLevel, 0));
}

Occupancy count_occupancy(const run::Workspace& workspace, const facts::Catalog& catalog) {
  const std::vector<std::size_t> begins = task_begins(catalog.vertex_blocks);
  Counter all;
  run_phase(
      workspace, "occupancy", begins.size() - 1,
      [&](std::size_t i) {
        ByteWriter writer;
        writer.put<std::uint64_t>(begins[i]);
        writer.put<std::uint64_t>(begins[i + 1]);
        return writer.take();
      },
      [&](std::span<const std::byte> task) {
        ByteReader reader(task);
        const auto begin = reader.get<std::uint64_t>();
        const auto end = reader.get<std::uint64_t>();
        Counter counter;
        for (std::uint64_t i = begin; i < end; ++i)
          counter.add(catalog.vertex_blocks[i], workspace, catalog.lattice, catalog.bounds);
        ByteWriter writer;
        for (const auto& [key, vertices] : counter.counts) writer.put(Count{key, vertices});
        return writer.take();
      },
      [&](std::size_t, const Bytes& result) {
        ByteReader reader(result);
        for (const Count& count : reader.get_array<Count>(result.size() / sizeof(Count)))
          all.counts[count.key] += count.vertices;
      });
  Occupancy occupancy;
  for (const auto& [key, count] : all.counts)
    occupancy.cells.push_back({{static_cast<std::uint8_t>(key >> 16), static_cast<std::uint8_t>(key >> 8),
                                static_cast<std::uint8_t>(key)},
                               0,
                               count});
  return occupancy;
}

}  // namespace colossus::pipeline::ingest
