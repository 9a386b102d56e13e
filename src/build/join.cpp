#include "build/join.hpp"

#include <algorithm>
#include <bit>

#include "build/phase.hpp"
#include "build/radix_sort.hpp"

namespace colossus::build {
namespace {

using core::ByteReader;
using core::Bytes;
using core::ByteWriter;

// A task for each group and for each range: enough of them for some dozens of ranks, and small enough that
// the largest, a group of a shuffled mesh, takes 100 MB.
constexpr std::uint64_t kTasks = 64;
constexpr std::uint64_t kLeastGroup = std::uint64_t{1} << 17;
constexpr std::uint64_t kMostGroup = std::uint64_t{1} << 19;
constexpr std::uint64_t kLeastRange = std::uint64_t{1} << 17;
constexpr std::uint64_t kMostRange = std::uint64_t{1} << 20;

// A corner's number within its group, in the low bits of a sort key.
constexpr int kCornerBits = 21;
static_assert(3 * (kMostGroup + input::kBlockElements) <= std::uint64_t{1} << kCornerBits);

std::uint64_t range_size(const Catalog& catalog) {
  return std::clamp(std::bit_ceil(catalog.counts.vertices / kTasks + 1), kLeastRange, kMostRange);
}

// The triangle blocks of each group: from begins[i] up to begins[i + 1].
std::vector<std::size_t> group_begins(const Catalog& catalog) {
  const std::uint64_t least = std::clamp(catalog.counts.triangles / kTasks, kLeastGroup, kMostGroup);
  std::vector<std::size_t> begins{0};
  std::uint64_t count = 0;
  for (std::size_t i = 0; i < catalog.triangle_blocks.size(); ++i) {
    count += catalog.triangle_blocks[i].count;
    if (count < least && i + 1 < catalog.triangle_blocks.size()) continue;
    begins.push_back(i + 1);
    count = 0;
  }
  return begins;
}

struct GroupTask {
  std::uint64_t begin = 0;  // of the triangle blocks
  std::uint64_t end = 0;
};

TriangleGroup read_group(std::span<const std::byte> bytes) {
  ByteReader reader(bytes);
  TriangleGroup group;
  group.triangle_count = reader.get<std::uint64_t>();
  group.triangles = reader.get<scratch::RecordRef>();
  group.slices = reader.get_array<VertexSlice>(reader.remaining() / sizeof(VertexSlice));
  COLOSSUS_CHECK(!reader.failed());
  return group;
}

class Joiner {
 public:
  Joiner(const Workspace& workspace, const Catalog& catalog)
      : workspace_(workspace), catalog_(catalog), range_size_(range_size(catalog)) {}

  std::vector<TriangleGroup> run() {
    request();
    answer();
    return std::move(groups_);
  }

 private:
  void request() {
    const std::vector<std::size_t> begins = group_begins(catalog_);
    groups_.resize(workspace_.ranks.is_root() ? begins.size() - 1 : 0);
    run_phase(
        workspace_, "requests", begins.size() - 1,
        [&](std::size_t i) {
          ByteWriter writer;
          writer.put(GroupTask{begins[i], begins[i + 1]});
          return writer.take();
        },
        [&](std::span<const std::byte> task) {
          return group_task(make_group(ByteReader(task).get<GroupTask>()));
        },
        [&](std::size_t i, const Bytes& result) { groups_[i] = read_group(result); });
  }

  // The corners of all triangles, sorted by the vertices that they name.
  std::vector<std::uint64_t> sorted_corners(const GroupTask& task, std::uint64_t& first_number) const {
    std::size_t count = 0;
    for (std::uint64_t i = task.begin; i < task.end; ++i) count += catalog_.triangle_blocks[i].count;
    std::vector<std::uint64_t> keys;
    keys.reserve(3 * count);
    for (std::uint64_t i = task.begin; i < task.end; ++i) {
      const TriangleBlockRef& block = catalog_.triangle_blocks[i];
      const Bytes bytes = workspace_.reader.read(block.record);
      for (const mesh::Triangle& t : ByteReader(bytes).get_array<mesh::Triangle>(block.count))
        for (const auto v : t) keys.push_back(block.first_vertex + v);
    }
    const auto [least, most] = std::minmax_element(keys.begin(), keys.end());
    first_number = *least;
    const auto bits = static_cast<int>(std::bit_width(*most - *least));
    COLOSSUS_CHECK(bits + kCornerBits <= 64, "{} vertices", catalog_.counts.vertices);
    for (std::size_t corner = 0; corner < keys.size(); ++corner)
      keys[corner] = (keys[corner] - first_number) << kCornerBits | corner;
    radix_sort(keys, kCornerBits, kCornerBits + bits);
    return keys;
  }

  TriangleGroup make_group(const GroupTask& task) const {
    std::uint64_t first_number = 0;
    const std::vector<std::uint64_t> corners = sorted_corners(task, first_number);
    std::vector<mesh::Triangle> triangles(corners.size() / 3);
    TriangleGroup group;
    std::vector<std::uint32_t> offsets;  // of the range at hand
    const auto finish_range = [&] {
      if (offsets.empty()) return;
      group.slices.back().count = static_cast<std::uint32_t>(offsets.size());
      group.slices.back().record =
          workspace_.writer.append(static_cast<std::uint32_t>(RecordKind::kRequest), core::as_bytes(offsets));
      offsets.clear();
    };
    std::uint32_t index = 0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const std::uint64_t number = first_number + (corners[i] >> kCornerBits);
      if (i == 0 || corners[i] >> kCornerBits != corners[i - 1] >> kCornerBits) {
        if (i > 0) ++index;
        const auto range = static_cast<std::uint32_t>(number / range_size_);
        if (group.slices.empty() || group.slices.back().range != range) {
          finish_range();
          group.slices.push_back({range, 0, {}});
        }
        offsets.push_back(static_cast<std::uint32_t>(number % range_size_));
      }
      const std::uint64_t corner = corners[i] & ((std::uint64_t{1} << kCornerBits) - 1);
      triangles[corner / 3][corner % 3] = index;
    }
    finish_range();
    group.triangle_count = triangles.size();
    workspace_.reporter.add_triangles(group.triangle_count);
    group.triangles = workspace_.writer.append(static_cast<std::uint32_t>(RecordKind::kGroupTriangles),
                                               core::as_bytes(triangles));
    return group;
  }

  // One task per range that is asked for.
  void answer() {
    struct Asker {
      std::uint32_t group;
      std::uint32_t slice;
    };
    std::vector<std::vector<Asker>> askers(catalog_.counts.vertices / range_size_ + 1);
    for (std::uint32_t g = 0; g < groups_.size(); ++g)
      for (std::uint32_t s = 0; s < groups_[g].slices.size(); ++s)
        askers[groups_[g].slices[s].range].push_back({g, s});
    std::vector<std::uint64_t> ranges;
    for (std::uint64_t r = 0; r < askers.size(); ++r)
      if (!askers[r].empty()) ranges.push_back(r);
    run_phase(
        workspace_, "answers", ranges.size(),
        [&](std::size_t i) {
          ByteWriter writer;
          writer.put(ranges[i]);
          for (const Asker& asker : askers[ranges[i]]) writer.put(groups_[asker.group].slices[asker.slice]);
          return writer.take();
        },
        [&](std::span<const std::byte> task) { return answer_range(task); },
        [&](std::size_t i, const Bytes& result) {
          ByteReader reader(result);
          for (const Asker& asker : askers[ranges[i]])
            groups_[asker.group].slices[asker.slice].record = reader.get<scratch::RecordRef>();
          COLOSSUS_CHECK(!reader.failed());
        });
  }

  Bytes answer_range(std::span<const std::byte> task) const {
    ByteReader reader(task);
    const auto range = reader.get<std::uint64_t>();
    const std::vector<mesh::Vertex> vertices = load_range(range);
    ByteWriter answers;
    while (reader.remaining() > 0) {
      const auto slice = reader.get<VertexSlice>();
      COLOSSUS_CHECK(!reader.failed());
      const Bytes offsets = workspace_.reader.read(slice.record);
      PackedVertices packed(catalog_, slice.count);
      for (const auto offset : ByteReader(offsets).get_array<std::uint32_t>(slice.count))
        packed.add(vertices.at(offset));
      answers.put(workspace_.writer.append(static_cast<std::uint32_t>(RecordKind::kAnswer),
                                           {offsets, packed.positions(), packed.normals(), packed.colors()}));
    }
    return answers.take();
  }

  std::vector<mesh::Vertex> load_range(std::uint64_t range) const {
    const std::uint64_t begin = range * range_size_;
    const std::uint64_t end = std::min(begin + range_size_, catalog_.counts.vertices);
    std::vector<mesh::Vertex> vertices;
    vertices.reserve(end - begin);
    const auto& blocks = catalog_.vertex_blocks;
    auto block = std::partition_point(blocks.begin(), blocks.end(),
                                      [&](const VertexBlockRef& b) { return b.first + b.count <= begin; });
    for (; block != blocks.end() && block->first < end; ++block) append_block(*block, begin, end, vertices);
    return vertices;
  }

  void append_block(const VertexBlockRef& block, std::uint64_t begin, std::uint64_t end,
                    std::vector<mesh::Vertex>& vertices) const {
    const Bytes raw = workspace_.reader.read(block.record);
    ByteReader reader(raw);
    const auto present = reader.get<std::array<std::uint64_t, 2>>();
    const auto positions = reader.get_array<std::array<double, 3>>(block.count);
    const auto normals = reader.get_array<std::array<float, 3>>(present[0] != 0 ? block.count : 0);
    const auto colors = reader.get_array<mesh::Color>(present[1] != 0 ? block.count : 0);
    COLOSSUS_CHECK(!reader.failed(), "a checked scratch record has the wrong size");
    const std::size_t last = std::min<std::uint64_t>(block.count, end - block.first);
    for (std::size_t i = begin > block.first ? begin - block.first : 0; i < last; ++i) {
      mesh::Vertex v;
      v.position = catalog_.lattice.input_vertex(positions[i]);
      v.normal = {0, 0, 0};
      if (!normals.empty() && (normals[i][0] != 0.0F || normals[i][1] != 0.0F || normals[i][2] != 0.0F))
        v.normal = geometry::to_normal16(normals[i][0], normals[i][1], normals[i][2]);
      if (!colors.empty()) v.color = colors[i];
      vertices.push_back(v);
    }
  }

  const Workspace& workspace_;
  const Catalog& catalog_;
  std::uint64_t range_size_;
  std::vector<TriangleGroup> groups_;  // on rank 0
};

}  // namespace

std::vector<TriangleGroup> join_vertices(const Workspace& workspace, const Catalog& catalog) {
  return Joiner(workspace, catalog).run();
}

Bytes group_task(const TriangleGroup& group) {
  ByteWriter writer;
  writer.put(group.triangle_count);
  writer.put(group.triangles);
  writer.put_array<VertexSlice>(group.slices);
  return writer.take();
}

Piece load_group(const Workspace& workspace, const Catalog& catalog, std::span<const std::byte> task) {
  const TriangleGroup group = read_group(task);
  const std::uint64_t size = range_size(catalog);
  Piece piece;
  std::size_t count = 0;
  for (const VertexSlice& slice : group.slices) count += slice.count;
  piece.numbers.reserve(count);
  piece.vertices.reserve(count);
  for (const VertexSlice& slice : group.slices) {
    const Bytes bytes = workspace.reader.read(slice.record);
    ByteReader answer(bytes);
    for (const auto offset : answer.get_array<std::uint32_t>(slice.count))
      piece.numbers.push_back(slice.range * size + offset);
    PackedVertices::read(catalog, answer, slice.count, piece.vertices);
  }
  const Bytes bytes = workspace.reader.read(group.triangles);
  piece.triangles = ByteReader(bytes).get_array<mesh::Triangle>(group.triangle_count);
  workspace.reporter.add_triangles(group.triangle_count);
  return piece;
}

}  // namespace colossus::build
