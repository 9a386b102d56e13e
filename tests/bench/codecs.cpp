// codecs CONTAINER [NODES]: what the nodes of a container take by each codec, and how fast each is, beside
// Draco and meshoptimizer; leaves and inner nodes apart. At most so many nodes, spread evenly, are looked at.
//
// Encoding runs from triangles in any order to the bytes of a chunk, decoding back to triangles with integer
// attributes, in CPU time of one thread. Bits count the chunk's whole frame; what is not of a component is
// head, checksum and frame.
//
// Draco gets positions on a grid of equal steps, as integers, whose root-mean-square error is that of ours;
// its level 7 of 10, normals of 8 bits. meshoptimizer gets our integers, interleaved, and zstd behind it.

#include <cmath>
#include <ctime>
#include <optional>

#include "codec/coded/renumber.hpp"
#include "codec/payload.hpp"
#include "container/chunk.hpp"
#include "container/reader.hpp"
#include "rivals.hpp"

namespace {

using namespace colossus;
using bench::Rival;

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Result {
  codec::coded::PerComponent<std::uint64_t> component_bytes{};
  std::uint64_t bytes = 0;
  double encode_seconds = 0.0;
  double decode_seconds = 0.0;
};

struct Group {
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
  std::vector<Result> results;  // codecs, then rivals
};

// Caches of the processor are as warm as a reader's would be that decodes node after node: the best of few.
constexpr int kRounds = 3;

template <typename Work>
double best_seconds(Work work) {
  double best = 1e300;
  for (int round = 0; round < kRounds; ++round) {
    const double start = cpu_seconds();
    work();
    best = std::min(best, cpu_seconds() - start);
  }
  return best;
}

codec::coded::CodedNode in_order(codec::coded::CodedNode node, const codec::Codec& codec) {
  for (codec::coded::CodedPart& part : node.parts) {
    codec.order(part.triangles, part.positions.size());
    const auto before = codec::coded::renumber_by_first_use(part.triangles, part.positions.size());
    codec::coded::permute(part.positions, before);
    codec::coded::permute(part.normals, before);
    codec::coded::permute(part.colors, before);
    codec::coded::permute(part.parents, before);
  }
  return node;
}

void add_codec(Result& result, const codec::coded::CodedNode& node, const codec::Codec& codec) {
  container::PackedChunk chunk;
  result.encode_seconds += best_seconds([&] {
    const codec::Payload payload = codec::to_payload(in_order(node, codec), codec);
    chunk = container::pack_chunk(payload.bytes, {codec.zstd_level, payload.cuts});
  });
  result.decode_seconds += best_seconds([&] {
    const auto payload = container::unpack_chunk(chunk.frame, chunk.payload_bytes);
    const auto decoded = codec::from_payload(payload.value(), {~std::uint64_t{0}, ~std::uint64_t{0}});
    if (!decoded) core::fail(core::Status::kBadData, "{}: {}", codec.name, decoded.defect().message);
  });
  result.bytes += chunk.frame.size();
  for (std::size_t i = 0; i < codec::coded::kComponentCount; ++i)
    result.component_bytes[i] += chunk.piece_bytes[i + 1];
}

void add_rival(Result& result, const codec::coded::CodedNode& node, const Rival& rival) {
  for (const codec::coded::CodedPart& part : node.parts) {
    if (part.triangles.empty()) continue;
    bench::RivalBytes bytes;
    result.encode_seconds += best_seconds([&] { bytes = rival.encode(node, part); });
    result.decode_seconds += best_seconds([&] { rival.decode(node, part, bytes); });
    result.bytes += bytes.size();
    result.component_bytes[0] += bytes.indices.size();
  }
}

void print(const char* title, const Group& group, const std::vector<const char*>& names) {
  fmt::print("\n{}: {} vertices, {} triangles\n", title, group.vertices, group.triangles);
  fmt::print("{:15} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8}   {:>8} {:>8}\n", "bits per vertex", "topology",
             "position", "normal", "colour", "parent", "all", "enc Mt/s", "dec Mt/s");
  const double bits = 8.0 / static_cast<double>(group.vertices);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const Result& r = group.results[i];
    fmt::print("{:15}", names[i]);
    for (const std::uint64_t bytes : r.component_bytes)
      fmt::print(" {:>8}",
                 bytes == 0 ? std::string("-") : fmt::format("{:.2f}", bits * static_cast<double>(bytes)));
    fmt::print(" {:8.2f}   {:8.2f} {:8.2f}\n", bits * static_cast<double>(r.bytes),
               1e-6 * static_cast<double>(group.triangles) / r.encode_seconds,
               1e-6 * static_cast<double>(group.triangles) / r.decode_seconds);
  }
}

void run(const std::string& file, std::size_t most_nodes) {
  const container::ContainerReader container(file);
  std::vector<const char*> names;
  for (const codec::Codec& codec : codec::codecs()) names.push_back(codec.name);
  for (const Rival& rival : bench::rivals()) names.push_back(rival.name);
  std::array<Group, 3> groups;  // leaves, inner nodes, all
  for (Group& group : groups) group.results.resize(names.size());
  const std::size_t count = container.rows().size();
  const std::size_t step = std::max<std::size_t>(1, count / most_nodes);
  for (std::size_t i = 0; i < count; i += step) {
    const container::NodeRow& row = container.rows()[i];
    const auto payload = container.read_payload(i);
    if (!payload) core::fail(core::Status::kBadData, "{}", payload.defect().message);
    const auto node = codec::from_payload(payload.value(), {row.vertices, row.triangles});
    if (!node) core::fail(core::Status::kBadData, "{}", node.defect().message);
    std::vector<Result> results(names.size());
    std::size_t k = 0;
    for (const codec::Codec& codec : codec::codecs()) add_codec(results[k++], node.value(), codec);
    for (const Rival& rival : bench::rivals()) add_rival(results[k++], node.value(), rival);
    for (Group* group : {&groups[(row.flags & container::kNodeIsLeaf) != 0 ? 0 : 1], &groups[2]}) {
      group->vertices += row.vertices;
      group->triangles += row.triangles;
      for (std::size_t r = 0; r < results.size(); ++r) {
        Result& sum = group->results[r];
        for (std::size_t c = 0; c < codec::coded::kComponentCount; ++c)
          sum.component_bytes[c] += results[r].component_bytes[c];
        sum.bytes += results[r].bytes;
        sum.encode_seconds += results[r].encode_seconds;
        sum.decode_seconds += results[r].decode_seconds;
      }
    }
  }
  fmt::print("{}: position bits {}\n", file, container.metadata().position_bits);
  print("leaves", groups[0], names);
  print("inner nodes", groups[1], names);
  print("all", groups[2], names);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2 && argc != 3) {
    fmt::print(stderr, "usage: codecs CONTAINER [NODES]\n");
    return 2;
  }
  try {
    run(argv[1], argc == 3 ? std::stoul(argv[2]) : 1000);
  } catch (const core::Error& error) {
    fmt::print(stderr, "codecs: {}\n", error.what());
    return static_cast<int>(error.status());
  }
  return 0;
}
