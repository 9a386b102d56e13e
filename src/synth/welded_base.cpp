#include "synth/welded_base.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "synth/surface.hpp"

namespace colossus::synth {
namespace {

using namespace synth_points;
using Triangle = std::array<std::uint32_t, 3>;

void check_base(const BaseMesh& base) {
  using core::Status;
  if (base.triangles.empty()) core::fail(Status::kBadData, "{}: no triangles to subdivide", base.name);
  if (base.positions.size() >= kMaxSynthVertices || base.triangles.size() >= kMaxSynthVertices)
    core::fail(Status::kBadData,
               "{}: {} vertices and {} triangles; a base mesh may have less than 2^31 of each", base.name,
               base.positions.size(), base.triangles.size());
  if (!base.colors.empty() && base.colors.size() != base.positions.size())
    core::fail(Status::kBadData, "{}: {} colors for {} vertices", base.name, base.colors.size(),
               base.positions.size());
  for (std::size_t i = 0; i < base.positions.size(); ++i)
    for (const double c : base.positions[i])
      if (!std::isfinite(c))
        core::fail(Status::kBadData, "{}: vertex {}: a coordinate is {}", base.name, i, c);
  for (std::size_t i = 0; i < base.triangles.size(); ++i)
    for (const std::uint32_t v : base.triangles[i])
      if (v >= base.positions.size())
        core::fail(Status::kBadData, "{}: face {}: vertex index {}, but there are {} vertices", base.name, i,
                   v, base.positions.size());
}

// For each vertex, the first one at the same position; -0 and 0 are the same.
std::vector<std::uint32_t> first_at_position(const std::vector<Point>& positions) {
  std::vector<std::uint32_t> order(positions.size()), first(positions.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<std::uint32_t>(i);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return positions[a] != positions[b] ? positions[a] < positions[b] : a < b;
  });
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && positions[order[i]] == positions[order[i - 1]];
    first[order[i]] = same ? first[order[i - 1]] : order[i];
  }
  return first;
}

void weld(const BaseMesh& base, WeldedBase& mesh) {
  constexpr std::uint32_t kUnused = 0xffffffffU;
  const std::vector<std::uint32_t> first = first_at_position(base.positions);
  std::vector<std::uint32_t> number(base.positions.size(), kUnused);
  for (const Triangle& corners : base.triangles) {
    Triangle triangle = {first[corners[0]], first[corners[1]], first[corners[2]]};
    if (triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0]) continue;
    for (std::uint32_t& v : triangle) {
      if (number[v] == kUnused) {
        number[v] = static_cast<std::uint32_t>(mesh.positions.size());
        mesh.positions.push_back(base.positions[v]);
        if (!base.colors.empty()) mesh.colors.push_back(base.colors[v]);
      }
      v = number[v];
    }
    mesh.triangles.push_back(triangle);
  }
  if (mesh.triangles.empty())
    core::fail(core::Status::kBadData, "{}: all triangles are degenerate", base.name);
}

// Numbers the edges. Returns for each whether it has other than two triangles of opposite directions.
std::vector<bool> number_edges(WeldedBase& mesh) {
  struct Side {
    std::uint32_t low, high;
    std::uint64_t corner;  // 3 * triangle + i
    bool reversed;
  };
  std::vector<Side> sides;
  sides.reserve(3 * mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = mesh.triangles[t][i], b = mesh.triangles[t][(i + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), 3 * t + i, a > b});
    }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    if (a.low != b.low) return a.low < b.low;
    return a.high != b.high ? a.high < b.high : a.corner < b.corner;
  });
  // The first side of an edge stands for it until the edges are numbered in the order of these.
  std::vector<std::uint64_t> leader(sides.size());
  std::vector<bool> special_side(sides.size());
  for (std::size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
    std::size_t reversed = 0;
    for (; end < sides.size() && sides[end].low == sides[begin].low && sides[end].high == sides[begin].high;
         ++end) {
      leader[sides[end].corner] = sides[begin].corner;
      reversed += sides[end].reversed;
    }
    special_side[sides[begin].corner] = end - begin != 2 || reversed != 1;
  }
  std::vector<bool> special;
  mesh.triangle_edges.resize(mesh.triangles.size());
  for (std::size_t corner = 0; corner < leader.size(); ++corner) {
    const std::size_t t = corner / 3, i = corner % 3;
    if (leader[corner] != corner) {
      mesh.triangle_edges[t][i] = mesh.triangle_edges[leader[corner] / 3][leader[corner] % 3];
      continue;
    }
    const std::uint32_t a = mesh.triangles[t][i], b = mesh.triangles[t][(i + 1) % 3];
    mesh.triangle_edges[t][i] = static_cast<std::uint32_t>(mesh.edges.size());
    mesh.edges.push_back({std::min(a, b), std::max(a, b)});
    special.push_back(special_side[corner]);
  }
  return special;
}

// Area-weighted unit normals; zero at the ends of special edges and where triangles cancel out.
void compute_normals(WeldedBase& mesh, const std::vector<bool>& special) {
  mesh.normals.assign(mesh.positions.size(), Point{});
  for (const Triangle& t : mesh.triangles) {
    const Point& a = mesh.positions[t[0]];
    const Point area = cross(mesh.positions[t[1]] - a, mesh.positions[t[2]] - a);
    for (const std::uint32_t v : t) mesh.normals[v] = mesh.normals[v] + area;
  }
  for (Point& normal : mesh.normals) {
    const double length = std::sqrt(dot(normal, normal));
    normal = length > 0 && std::isfinite(length) ? normal * (1 / length) : Point{};
  }
  for (std::size_t e = 0; e < mesh.edges.size(); ++e)
    if (special[e])
      for (const std::uint32_t v : mesh.edges[e]) mesh.normals[v] = Point{};
}

}  // namespace

WeldedBase weld_base(const BaseMesh& base) {
  check_base(base);
  WeldedBase mesh;
  weld(base, mesh);
  compute_normals(mesh, number_edges(mesh));
  return mesh;
}

}  // namespace colossus::synth
