#include "verify/measure/level_surface.hpp"

#include <algorithm>
#include <iterator>

namespace colossus::verify::measure {

void LevelSurface::Parts::add(reader::access::RowIndex row, std::span<const WorldPoint> more,
                              std::span<const mesh::Triangle> of_more) {
  if (of_more.empty()) return;
  const auto base = static_cast<std::uint32_t>(points.size());
  parts.push_back({triangles.size(), row});
  points.insert(points.end(), more.begin(), more.end());
  for (const mesh::Triangle& t : of_more) triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
}

void LevelSurface::add(reader::access::RowIndex row, std::span<const WorldPoint> points,
                       std::span<const mesh::Triangle> triangles, bool is_leaf) {
  (is_leaf ? whole_ : passing_).add(row, points, triangles);
}

void LevelSurface::finish() {
  staying_points_ = whole_.points.size();
  staying_triangles_ = whole_.triangles.size();
  staying_parts_ = whole_.parts.size();
  const auto base = static_cast<std::uint32_t>(staying_points_);
  whole_.points.insert(whole_.points.end(), passing_.points.begin(), passing_.points.end());
  for (const mesh::Triangle& t : passing_.triangles)
    whole_.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
  for (const Part& part : passing_.parts)
    whole_.parts.push_back({part.first_triangle + staying_triangles_, part.row});
  passing_ = {};
}

void LevelSurface::start_next() {
  whole_.points.resize(staying_points_);
  whole_.triangles.resize(staying_triangles_);
  whole_.parts.resize(staying_parts_);
}

Surface LevelSurface::surface(std::size_t part) const {
  const std::size_t first = whole_.parts[part].first_triangle;
  const std::size_t last =
      part + 1 < whole_.parts.size() ? whole_.parts[part + 1].first_triangle : whole_.triangles.size();
  return {whole_.points, std::span(whole_.triangles).subspan(first, last - first)};
}

reader::access::RowIndex LevelSurface::row_of(std::uint32_t triangle) const {
  const auto after =
      std::upper_bound(whole_.parts.begin(), whole_.parts.end(), std::size_t{triangle},
                       [](std::size_t t, const Part& part) { return t < part.first_triangle; });
  return std::prev(after)->row;
}

}  // namespace colossus::verify::measure
