// The kernels of a build, one node's worth of triangles at a time. Counters: "triangles" are input triangles
// per second; "rms" is the larger of the two one-sided root-mean-square distances between the result and the
// input, in mean edges of the input.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>

#include "codec/node_codec.hpp"
#include "codec/quantization/quantize.hpp"
#include "container/chunk.hpp"
#include "mesh/clip.hpp"
#include "references.hpp"
#include "simplify/collapse.hpp"
#include "torus.hpp"

namespace {

using namespace colossus;

// 4 * 64 * 64 = 16,384 triangles, two full leaf tetrahedra; and a whole diamond of eight.
constexpr std::int64_t kFewRings = 64;
constexpr std::int64_t kManyRings = 128;
// 200,704 triangles: a block.
constexpr std::int64_t kBlockRings = 224;
constexpr std::size_t kErrorSamples = 20'000;

void count_triangles(benchmark::State& state, const mesh::Mesh& mesh) {
  state.counters["triangles"] = benchmark::Counter(static_cast<double>(mesh.triangles.size()),
                                                   benchmark::Counter::kIsIterationInvariantRate);
}

bench::Simplified in_doubles(const mesh::Mesh& mesh) {
  bench::Simplified result;
  for (const mesh::Vertex& v : mesh.vertices)
    result.points.push_back({double(v.position.x), double(v.position.y), double(v.position.z)});
  result.triangles = mesh.triangles;
  return result;
}

double mean_edge(const bench::Simplified& mesh) {
  double sum = 0.0;
  for (const mesh::Triangle& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const verify::measure::WorldPoint& a = mesh.points[t[k]];
      const verify::measure::WorldPoint& b = mesh.points[t[(k + 1) % 3]];
      sum += std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
    }
  return sum / (3.0 * static_cast<double>(mesh.triangles.size()));
}

void count_error(benchmark::State& state, const mesh::Mesh& mesh, const bench::Simplified& result) {
  const bench::Simplified input = in_doubles(mesh);
  const verify::measure::SurfaceDistances d = verify::measure::surface_distances(
      {result.points, result.triangles}, {input.points, input.triangles}, kErrorSamples);
  state.counters["rms"] = std::max(d.a_to_b.rms, d.b_to_a.rms) / mean_edge(input);
  state.counters["left"] =
      static_cast<double>(result.triangles.size()) / static_cast<double>(mesh.triangles.size());
}

void simplify_to_half(benchmark::State& state) {
  const mesh::Mesh mesh = bench::torus(static_cast<std::uint32_t>(state.range(0)));
  const simplify::Region input = bench::region_of(mesh, mesh.triangles.size() / 4);
  simplify::Region region;
  for (auto _ : state) {
    state.PauseTiming();
    region = input;
    state.ResumeTiming();
    benchmark::DoNotOptimize(simplify::simplify(region, mesh.triangles.size() / 2));
  }
  count_triangles(state, mesh);
  count_error(state, mesh, in_doubles(region.mesh));
}
BENCHMARK(simplify_to_half)->Arg(kFewRings)->Arg(kManyRings)->Unit(benchmark::kMillisecond);

// As a block is simplified, by half-edge collapses; and beside it with vertices placed.
void simplify_to_quarter(benchmark::State& state) {
  const mesh::Mesh mesh = bench::torus(static_cast<std::uint32_t>(state.range(0)));
  simplify::Region input = bench::region_of(mesh, mesh.triangles.size() / 4);
  input.may_place = state.range(1) != 0;
  simplify::Region region;
  simplify::Outcome outcome;
  for (auto _ : state) {
    state.PauseTiming();
    region = input;
    state.ResumeTiming();
    outcome = simplify::simplify(region, mesh.triangles.size() / 4);
  }
  count_triangles(state, mesh);
  count_error(state, mesh, in_doubles(region.mesh));
  state.counters["passes"] = outcome.passes;
  state.counters["deviation"] = outcome.deviation / mean_edge(in_doubles(mesh));
}
BENCHMARK(simplify_to_quarter)
    ->ArgNames({"rings", "may_place"})
    ->Args({kBlockRings, 0})
    ->Args({kBlockRings, 1})
    ->Unit(benchmark::kMillisecond);

template <typename Reference>
void run_reference(benchmark::State& state, std::size_t divisor) {
  const mesh::Mesh mesh = bench::torus(static_cast<std::uint32_t>(state.range(0)));
  bench::Simplified result;
  for (auto _ : state) {
    state.PauseTiming();
    Reference reference(mesh);
    state.ResumeTiming();
    reference.run(mesh.triangles.size() / divisor);
    state.PauseTiming();
    result = reference.result();
    state.ResumeTiming();
  }
  count_triangles(state, mesh);
  count_error(state, mesh, result);
}

template <typename Reference>
void reference_to_half(benchmark::State& state) {
  run_reference<Reference>(state, 2);
}
BENCHMARK(reference_to_half<bench::OpenMeshDecimation>)
    ->Arg(kFewRings)
    ->Arg(kManyRings)
    ->Unit(benchmark::kMillisecond);
BENCHMARK(reference_to_half<bench::MeshoptSimplification>)
    ->Arg(kFewRings)
    ->Arg(kManyRings)
    ->Unit(benchmark::kMillisecond);

template <typename Reference>
void reference_to_quarter(benchmark::State& state) {
  run_reference<Reference>(state, 4);
}
BENCHMARK(reference_to_quarter<bench::OpenMeshDecimation>)->Arg(kBlockRings)->Unit(benchmark::kMillisecond);
BENCHMARK(reference_to_quarter<bench::MeshoptSimplification>)
    ->Arg(kBlockRings)
    ->Unit(benchmark::kMillisecond);

void split(benchmark::State& state) {
  const mesh::Mesh mesh = bench::torus(static_cast<std::uint32_t>(state.range(0)));
  const geometry::Plane plane = bench::cell().bisector();
  for (auto _ : state) benchmark::DoNotOptimize(mesh::split(mesh, plane));
  count_triangles(state, mesh);
}
BENCHMARK(split)->Arg(kFewRings)->Unit(benchmark::kMillisecond);

void weld(benchmark::State& state) {
  const mesh::Mesh input = bench::torus(static_cast<std::uint32_t>(state.range(0)));
  for (auto _ : state) {
    mesh::Mesh mesh = input;
    mesh::weld(mesh);
    benchmark::DoNotOptimize(mesh);
  }
  count_triangles(state, input);
}
BENCHMARK(weld)->Arg(kFewRings)->Unit(benchmark::kMillisecond);

codec::coded::CodedNode quantized(const mesh::Mesh& mesh) {
  codec::coded::CodedNode node;
  node.position_bits = codec::coded::kDefaultPositionBits;
  node.has_normals = node.has_colors = true;
  node.parts.push_back(codec::quantization::quantize(mesh, bench::cell(), 0,
                                                     {node.position_bits, node.has_normals, node.has_colors})
                           .tetrahedron);
  codec::put_in_order(node.parts[0], codec::codecs().front());
  return node;
}

void quantize(benchmark::State& state) {
  const mesh::Mesh mesh = bench::torus(static_cast<std::uint32_t>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(quantized(mesh));
  count_triangles(state, mesh);
}
BENCHMARK(quantize)->Arg(kFewRings)->Unit(benchmark::kMillisecond);

void encode(benchmark::State& state) {
  const mesh::Mesh mesh = bench::torus(static_cast<std::uint32_t>(state.range(0)));
  const codec::coded::CodedNode node = quantized(mesh);
  for (auto _ : state) benchmark::DoNotOptimize(codec::encode(node, codec::codecs().front()));
  count_triangles(state, mesh);
}
BENCHMARK(encode)->Arg(kFewRings)->Unit(benchmark::kMillisecond);

void decode(benchmark::State& state) {
  const mesh::Mesh mesh = bench::torus(static_cast<std::uint32_t>(state.range(0)));
  const core::Bytes bytes = codec::encode(quantized(mesh), codec::codecs().front()).bytes;
  for (auto _ : state) benchmark::DoNotOptimize(codec::decode_with_weights(bytes, {~0ULL, ~0ULL}));
  count_triangles(state, mesh);
}
BENCHMARK(decode)->Arg(kFewRings)->Unit(benchmark::kMillisecond);

void pack_chunk(benchmark::State& state) {
  const mesh::Mesh mesh = bench::torus(static_cast<std::uint32_t>(state.range(0)));
  const codec::coded::CodedNode node = quantized(mesh);
  const core::Bytes bytes = codec::encode(node, codec::codecs().front()).bytes;
  std::size_t packed = 0;
  for (auto _ : state) packed = container::pack_chunk(bytes).frame.size();
  count_triangles(state, mesh);
  state.counters["bits_per_vertex"] =
      8.0 * static_cast<double>(packed) / static_cast<double>(node.parts[0].positions.size());
}
BENCHMARK(pack_chunk)->Arg(kFewRings)->Unit(benchmark::kMillisecond);

void unpack_chunk(benchmark::State& state) {
  const mesh::Mesh mesh = bench::torus(static_cast<std::uint32_t>(state.range(0)));
  const core::Bytes bytes = codec::encode(quantized(mesh), codec::codecs().front()).bytes;
  const container::PackedChunk chunk = container::pack_chunk(bytes);
  for (auto _ : state) benchmark::DoNotOptimize(container::unpack_chunk(chunk.frame, bytes.size()));
  count_triangles(state, mesh);
}
BENCHMARK(unpack_chunk)->Arg(kFewRings)->Unit(benchmark::kMillisecond);

}  // namespace
