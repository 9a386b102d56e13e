#include "codec/quantization/quantize.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "codec/coded/frame.hpp"
#include "codec/coded/places.hpp"
#include "codec/coded/renumber.hpp"
#include "codec/quantization/lost.hpp"
#include "codec/quantization/pinches.hpp"
#include "codec/quantization/polylines.hpp"
#include "core/error.hpp"

namespace colossus::codec::quantization {
namespace {

using mesh::Triangle;

std::uint32_t find_root(std::vector<std::uint32_t>& parents, std::uint32_t i) {
  while (parents[i] != i) i = parents[i] = parents[parents[i]];
  return i;
}

bool has_equal_corners(const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

// Merges vertices that fall together within a triangle, and moves what that makes degenerate to `lost`.
// Returns the vertex that each has become.
std::vector<std::uint32_t> merge_fallen_together(std::vector<Triangle>& triangles,
                                                 const std::vector<coded::Weights>& weights,
                                                 std::vector<Triangle>& lost) {
  std::vector<std::uint32_t> parents(weights.size());
  for (std::uint32_t i = 0; i < parents.size(); ++i) parents[i] = i;
  for (const Triangle& t : triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = find_root(parents, t[k]);
      const std::uint32_t b = find_root(parents, t[(k + 1) % 3]);
      if (a != b && weights[a] == weights[b]) parents[std::max(a, b)] = std::min(a, b);
    }
  for (Triangle& t : triangles)
    for (auto& v : t) v = find_root(parents, v);
  for (const Triangle& t : triangles)
    if (has_equal_corners(t)) lost.push_back(t);
  std::erase_if(triangles, has_equal_corners);
  for (std::uint32_t v = 0; v < parents.size(); ++v) parents[v] = find_root(parents, v);
  return parents;
}

double moved_by(const coded::Weights& weights, const geometry::Point& from,
                const hierarchy::Tetrahedron& tetrahedron, double scale) {
  const coded::ScaledPosition to = coded::scaled_position(weights, tetrahedron);
  const double x = static_cast<double>(to[0]) * scale - from.x;
  const double y = static_cast<double>(to[1]) * scale - from.y;
  const double z = static_cast<double>(to[2]) * scale - from.z;
  return std::sqrt(x * x + y * y + z * z);
}

double unit_of(int position_bits) { return 1.0 / static_cast<double>(std::int64_t{1} << position_bits); }

// What has become of a mesh in which vertices fell together.
struct Mended {
  std::vector<std::uint32_t> roots;  // the vertex that each has become, new ones themselves
  double displacement = 0.0;         // of vertices for which copies stand
  double beyond = 0.0;               // what pairs that were taken out add to any displacement
};

// The greatest displacement of a vertex to a copy that stands for it. `copied`: the originals of the last
// vertices.
double displacement_of_copies(const std::vector<std::uint32_t>& copied,
                              const std::vector<std::uint32_t>& welded,
                              const std::vector<mesh::Vertex>& vertices,
                              const std::vector<coded::Weights>& weights,
                              const hierarchy::Tetrahedron& tetrahedron, double scale) {
  const auto first = static_cast<std::uint32_t>(vertices.size() - copied.size());
  // A copy stands for all that had come to its original's place.
  std::multimap<std::uint32_t, std::uint32_t> copies;
  for (std::uint32_t i = 0; i < copied.size(); ++i) copies.emplace(welded[copied[i]], first + i);
  double greatest = 0.0;
  for (std::size_t v = 0; v < welded.size() && !copies.empty(); ++v)
    for (auto [copy, end] = copies.equal_range(welded[v]); copy != end; ++copy)
      greatest =
          std::max(greatest, moved_by(weights[copy->second], vertices[v].position, tetrahedron, scale));
  return greatest;
}

// `welded`: the first vertex at each one's place.
Mended mend_shared_places(mesh::Mesh& mesh, std::vector<coded::Weights>& weights,
                          const std::vector<std::uint32_t>& welded, const hierarchy::Tetrahedron& tetrahedron,
                          int position_bits) {
  std::vector<mesh::Vertex>& vertices = mesh.vertices;
  std::vector<Triangle>& triangles = mesh.triangles;
  Mended mended;
  std::vector<Triangle> lost;
  mended.roots = merge_fallen_together(triangles, weights, lost);
  // Before fins go: what lies on one of these is no farther from the rest than the fin.
  std::vector<Triangle> to_revive = uncovered(lost, welded, triangles);
  mended.beyond = take_out_pairs(tetrahedron, position_bits, weights, triangles, to_revive);
  separate_edges(triangles, weights);
  std::vector<bool> is_merged(vertices.size(), false);
  for (std::uint32_t v = 0; v < mended.roots.size(); ++v)
    if (mended.roots[v] != v) is_merged[mended.roots[v]] = true;
  split_edges(vertices, triangles, weights, is_merged);
  const std::vector<std::uint32_t> copied = revive(to_revive, vertices, triangles, weights);
  mended.displacement =
      displacement_of_copies(copied, welded, vertices, weights, tetrahedron, unit_of(position_bits));
  for (auto v = static_cast<std::uint32_t>(mended.roots.size()); v < vertices.size(); ++v)
    mended.roots.push_back(v);
  return mended;
}

}  // namespace

Barycentric::Barycentric(const hierarchy::Tetrahedron& tetrahedron) {
  for (int i = 0; i < 4; ++i) {
    const auto k = static_cast<std::size_t>(i);
    planes_[k] = tetrahedron.face_plane(i);
    heights_[k] = planes_[k].side(tetrahedron.corners[k]);
    greatest_height_ = std::max(greatest_height_, heights_[k]);
  }
  for (const std::int64_t height : heights_) COLOSSUS_CHECK(greatest_height_ % height == 0);
}

coded::Weights Barycentric::weights(const geometry::Point& p, int bits) const {
  coded::Weights weights{};
  std::array<std::int64_t, 4> fractions{};
  std::int64_t left = std::int64_t{1} << bits;
  for (std::size_t i = 0; i < 4; ++i) {
    const std::int64_t side = planes_[i].side(p);
    COLOSSUS_CHECK(side >= 0, "a vertex at {} {} {} lies outside its tetrahedron", p.x, p.y, p.z);
    const std::int64_t scaled = side << bits;
    weights[i] = static_cast<std::uint32_t>(scaled / heights_[i]);
    fractions[i] = scaled % heights_[i] * (greatest_height_ / heights_[i]);
    left -= weights[i];
  }
  for (; left > 0; --left) {
    const auto greatest = std::max_element(fractions.begin(), fractions.end());
    ++weights[static_cast<std::size_t>(greatest - fractions.begin())];
    *greatest = -1;
  }
  for (std::size_t i = 0; i < 4; ++i)
    if (weights[i] == 0 && planes_[i].side(p) > 0) {
      --*std::max_element(weights.begin(), weights.end());
      weights[i] = 1;
    }
  return weights;
}

Quantized quantize(mesh::Mesh mesh, const hierarchy::Tetrahedron& tetrahedron, std::uint8_t place,
                   const QuantizeOptions& options) {
  const Barycentric barycentric(tetrahedron);
  const double scale = unit_of(options.position_bits);
  Quantized result;
  std::vector<coded::Weights> weights;
  weights.reserve(mesh.vertices.size());
  for (const mesh::Vertex& vertex : mesh.vertices)
    weights.push_back(barycentric.weights(vertex.position, options.position_bits));
  settle_polylines(mesh, weights);
  Mended mended;
  mended.roots.resize(mesh.vertices.size());
  std::iota(mended.roots.begin(), mended.roots.end(), 0U);
  const std::vector<std::uint32_t> welded = coded::first_at_place(weights);
  result.has_shared_places = welded != mended.roots;
  if (result.has_shared_places)
    mended = mend_shared_places(mesh, weights, welded, tetrahedron, options.position_bits);
  result.displacement = mended.displacement;
  for (std::size_t v = 0; v < weights.size(); ++v)
    result.displacement =
        std::max(result.displacement,
                 moved_by(weights[mended.roots[v]], mesh.vertices[v].position, tetrahedron, scale));
  result.displacement += mended.beyond;
  coded::CodedPart& out = result.tetrahedron;
  out.place = place;
  out.frame = coded::frame_of(tetrahedron);
  const std::vector<std::uint32_t> before =
      coded::renumber_by_first_use(mesh.triangles, mesh.vertices.size());
  const std::size_t used = coded::used_vertices(mesh.triangles, mesh.vertices.size());
  for (std::size_t i = 0; i < used; ++i) {
    const std::uint32_t v = before[i];
    out.positions.push_back(weights[v]);
    if (options.normals) out.normals.push_back(geometry::encode_octahedral(mesh.vertices[v].normal));
    if (options.colors) out.colors.push_back(mesh.vertices[v].color);
  }
  out.triangles = std::move(mesh.triangles);
  return result;
}

}  // namespace colossus::codec::quantization
