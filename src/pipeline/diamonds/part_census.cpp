#include "pipeline/diamonds/part_census.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "codec/coded/places.hpp"
#include "core/hash.hpp"
#include "mesh/topology.hpp"

namespace colossus::pipeline::diamonds {
namespace {

using mesh::Triangle;

using Marks = std::vector<std::uint8_t>;  // marks_of() the vertices

// Of the triangles with three places, the edges one by one.
PartCensus count_all(const codec::coded::CodedPart& part, const Marks& marks) {
  const std::vector<std::uint32_t> welded = codec::coded::first_at_place(part.positions);
  std::vector<Triangle> triangles;
  triangles.reserve(part.triangles.size());
  for (const Triangle& t : part.triangles) {
    const Triangle w{welded[t[0]], welded[t[1]], welded[t[2]]};
    if (w[0] != w[1] && w[1] != w[2] && w[2] != w[0]) triangles.push_back(w);
  }
  PartCensus census;
  for (const mesh::Edge& edge : mesh::edges(triangles)) {
    if (edge.count() == 2) {
      census.inconsistent_edges += edge.forward != edge.backward ? 1 : 0;
      continue;
    }
    if ((marks[edge.a] & marks[edge.b]) != 0) continue;
    ++(edge.is_border() ? census.border_edges : census.nonmanifold_edges);
  }
  return census;
}

// Edges within faces are few; they are counted here, and do not cancel.
std::uint64_t inconsistent_in_faces(std::vector<Triangle>& sides) {
  std::uint64_t count = 0;
  std::sort(sides.begin(), sides.end());
  for (std::size_t i = 0; i < sides.size();) {
    std::size_t end = i;
    std::uint32_t forward = 0;
    for (; end < sides.size() && sides[end][0] == sides[i][0] && sides[end][1] == sides[i][1]; ++end)
      forward += sides[end][2];
    count += end - i == 2 && forward != 1 ? 1 : 0;
    i = end;
  }
  return count;
}

// Whether an edge that lies in no face has two triangles in the same direction.
bool has_repeated_edges(const codec::coded::CodedPart& part, const Marks& marks) {
  constexpr std::uint64_t kFree = ~std::uint64_t{0};
  std::vector<std::uint64_t> table(std::bit_ceil(6 * part.triangles.size() + 1), kFree);
  const std::uint64_t mask = table.size() - 1;
  for (const Triangle& t : part.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k], b = t[k == 2 ? 0 : k + 1];
      if ((marks[a] & marks[b]) != 0) continue;
      const std::uint64_t edge = std::uint64_t{a} << 32 | b;
      std::uint64_t i = core::mix64(edge) & mask;
      for (; table[i] != kFree; i = (i + 1) & mask)
        if (table[i] == edge) return true;
      table[i] = edge;
    }
  return false;
}

}  // namespace

PartCensus take_census(const codec::quantization::Quantized& stored, bool is_finest) {
  const codec::coded::CodedPart& part = stored.tetrahedron;
  const Marks marks = codec::coded::marks_of(part.positions);
  if (stored.has_shared_places) return count_all(part, marks);
  std::vector<std::uint64_t> random(part.positions.size());
  for (std::size_t v = 0; v < random.size(); ++v) random[v] = core::mix64(v + 0x9e3779b97f4a7c15ULL);
  unsigned __int128 sum = 0;
  std::vector<Triangle> in_faces;  // lesser end, greater end, 1 if the triangle has them in this order
  for (const Triangle& t : part.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k], b = t[k == 2 ? 0 : k + 1];
      if ((marks[a] & marks[b]) != 0) {
        in_faces.push_back({std::min(a, b), std::max(a, b), a < b ? 1U : 0U});
        continue;
      }
      const auto weight = static_cast<unsigned __int128>(random[a]) * random[b];
      sum = a < b ? sum + weight : sum - weight;
    }
  if (sum != 0 || (is_finest && has_repeated_edges(part, marks))) return count_all(part, marks);
  return {inconsistent_in_faces(in_faces), 0, 0};
}

double area_of(const codec::coded::CodedPart& part, const hierarchy::Tetrahedron& tetrahedron,
               int position_bits) {
  std::vector<std::array<double, 3>> points;
  points.reserve(part.positions.size());
  for (const codec::coded::Weights& weights : part.positions) {
    const codec::coded::ScaledPosition p = codec::coded::scaled_position(weights, tetrahedron);
    points.push_back({static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])});
  }
  double doubled = 0.0;
  for (const Triangle& t : part.triangles) {
    const auto &p = points[t[0]], &q = points[t[1]], &r = points[t[2]];
    const std::array<double, 3> a{q[0] - p[0], q[1] - p[1], q[2] - p[2]};
    const std::array<double, 3> b{r[0] - p[0], r[1] - p[1], r[2] - p[2]};
    const double x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2], z = a[0] * b[1] - a[1] * b[0];
    doubled += std::sqrt(x * x + y * y + z * z);
  }
  return 0.5 * std::ldexp(doubled, -2 * position_bits);
}

}  // namespace colossus::pipeline::diamonds
