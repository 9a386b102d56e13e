#include "hierarchy/diamond.hpp"

#include <algorithm>
#include <bit>

#include "core/error.hpp"

namespace colossus::hierarchy {
namespace {

using geometry::kRootBits;
using geometry::kRootSide;
using Vector = std::array<std::int64_t, 3>;

Point offset(const Point& p, const Vector& v) {
  return {static_cast<std::int32_t>(p.x + v[0]), static_cast<std::int32_t>(p.y + v[1]),
          static_cast<std::int32_t>(p.z + v[2])};
}

int trailing_zeros(std::int32_t value) {
  return value == 0 ? kRootBits + 1 : std::countr_zero(static_cast<std::uint32_t>(value));
}

void add(Diamond& diamond, std::array<Point, 4> corners) {
  std::sort(corners.begin(), corners.end());
  // Inserted in order: places are numbered by the concatenated corners.
  std::size_t slot = static_cast<std::size_t>(diamond.place_count++);
  for (; slot > 0 && corners < diamond.tetrahedra[slot - 1].corners; --slot)
    diamond.tetrahedra[slot] = diamond.tetrahedra[slot - 1];
  diamond.tetrahedra[slot] = {corners};
}

// +1 or -1: the direction, on this axis, of the diagonals within the cubes of side h whose index is even or
// odd.
std::int64_t diagonal_sign(std::int32_t coordinate, std::int64_t h) {
  return (coordinate / h) % 2 == 0 ? 1 : -1;
}

void fill_cube(Diamond& diamond, std::int64_t h) {
  const Point& c = diamond.center;
  const Vector s{diagonal_sign(c.x, h), diagonal_sign(c.y, h), diagonal_sign(c.z, h)};
  const Point p0 = offset(c, {-s[0] * h / 2, -s[1] * h / 2, -s[2] * h / 2});
  const Point p1 = offset(c, {s[0] * h / 2, s[1] * h / 2, s[2] * h / 2});
  diamond.ends = {p0, p1};
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t b = 0; b < 3; ++b) {
      if (a == b) continue;
      Vector first{};
      first[a] = s[a] * h;
      Vector second = first;
      second[b] = s[b] * h;
      add(diamond, {p0, offset(p0, first), offset(p0, second), p1});
    }
}

void fill_square(Diamond& diamond, std::int64_t h, std::size_t normal_axis) {
  const Point& c = diamond.center;
  const std::size_t u = (normal_axis + 1) % 3;
  const std::size_t v = (normal_axis + 2) % 3;
  const std::int64_t su = diagonal_sign(c[static_cast<int>(u)], h);
  const std::int64_t sv = diagonal_sign(c[static_cast<int>(v)], h);
  const auto in_plane = [&](std::int64_t du, std::int64_t dv) {
    Vector d{};
    d[u] = du * h / 2;
    d[v] = dv * h / 2;
    return offset(c, d);
  };
  diamond.ends = {in_plane(-su, -sv), in_plane(su, sv)};
  for (const std::int64_t side : {-1, 1}) {
    Vector up{};
    up[normal_axis] = side * h / 2;
    const Point cube = offset(c, up);
    for (const Point& corner : {in_plane(-su, sv), in_plane(su, -sv)})
      add(diamond, {diamond.ends[0], diamond.ends[1], corner, cube});
  }
}

void fill_edge(Diamond& diamond, std::int64_t h, std::size_t axis) {
  const Point& c = diamond.center;
  Vector along{};
  along[axis] = h / 2;
  diamond.ends = {offset(c, {-along[0], -along[1], -along[2]}), offset(c, along)};
  const std::size_t u = (axis + 1) % 3;
  const std::size_t v = (axis + 2) % 3;
  for (const std::int64_t du : {-1, 1})
    for (const std::int64_t dv : {-1, 1}) {
      Vector to_cube{};
      to_cube[u] = du * h / 2;
      to_cube[v] = dv * h / 2;
      for (const std::size_t face_axis : {u, v}) {
        Vector to_face{};
        to_face[face_axis] = to_cube[face_axis];
        add(diamond, {diamond.ends[0], diamond.ends[1], offset(c, to_cube), offset(c, to_face)});
      }
    }
}

}  // namespace

std::array<int, 2> Tetrahedron::long_edge() const {
  std::array<int, 2> best{0, 1};
  std::int64_t best_length = -1;
  for (int i = 0; i < 4; ++i)
    for (int j = i + 1; j < 4; ++j) {
      const std::int64_t length =
          squared_distance(corners[static_cast<std::size_t>(i)], corners[static_cast<std::size_t>(j)]);
      if (length > best_length) {
        best_length = length;
        best = {i, j};
      }
    }
  return best;
}

Point Tetrahedron::center() const {
  const auto edge = long_edge();
  return midpoint(corners[static_cast<std::size_t>(edge[0])], corners[static_cast<std::size_t>(edge[1])]);
}

Plane Tetrahedron::face_plane(int i) const {
  const auto corner = [&](int k) { return corners[static_cast<std::size_t>((i + k) % 4)]; };
  return geometry::plane_through(corner(1), corner(2), corner(3), corner(0));
}

Plane Tetrahedron::bisector() const {
  const auto edge = long_edge();
  std::array<Point, 2> others;
  std::size_t count = 0;
  for (int i = 0; i < 4; ++i)
    if (i != edge[0] && i != edge[1]) others[count++] = corners[static_cast<std::size_t>(i)];
  return geometry::plane_through(center(), others[0], others[1], corners[static_cast<std::size_t>(edge[0])]);
}

Tetrahedron Tetrahedron::child(int end) const {
  const auto edge = long_edge();
  Tetrahedron half = *this;
  half.corners[static_cast<std::size_t>(edge[static_cast<std::size_t>(1 - end)])] = center();
  std::sort(half.corners.begin(), half.corners.end());
  return half;
}

bool Tetrahedron::is_inside_root() const {
  return std::all_of(corners.begin(), corners.end(), [](const Point& p) {
    return p.x >= 0 && p.y >= 0 && p.z >= 0 && p.x <= kRootSide && p.y <= kRootSide && p.z <= kRootSide;
  });
}

bool Tetrahedron::contains(const Point& p) const {
  for (int i = 0; i < 4; ++i)
    if (face_plane(i).side(p) < 0) return false;
  return true;
}

int level_of(const Point& center) {
  const std::array<int, 3> zeros{trailing_zeros(center.x), trailing_zeros(center.y),
                                 trailing_zeros(center.z)};
  const int least = *std::min_element(zeros.begin(), zeros.end());
  const auto odd = std::count(zeros.begin(), zeros.end(), least);
  return 3 * (kRootBits - 1 - least) + (3 - static_cast<int>(odd));
}

Diamond Diamond::at(const Point& center) {
  Diamond diamond;
  diamond.center = center;
  diamond.level = level_of(center);
  COLOSSUS_CHECK(diamond.level >= 0 && diamond.level <= kMaxLevel, "no diamond at level {}", diamond.level);
  const std::int64_t h = std::int64_t{kRootSide} >> (diamond.level / 3);
  const auto is_odd = [&](int axis) { return (center[axis] / (h / 2)) % 2 != 0; };
  switch (diamond.level % 3) {
    case 0:
      fill_cube(diamond, h);
      break;
    case 1:
      fill_square(diamond, h, !is_odd(0) ? 0 : !is_odd(1) ? 1 : 2);
      break;
    default:
      fill_edge(diamond, h, is_odd(0) ? 0 : is_odd(1) ? 1 : 2);
      break;
  }
  const auto count = static_cast<std::size_t>(diamond.place_count);
  std::sort(diamond.ends.begin(), diamond.ends.end());
  for (std::size_t i = 0; i < count; ++i) diamond.is_inside[i] = diamond.tetrahedra[i].is_inside_root();
  return diamond;
}

int Diamond::place_of(const Tetrahedron& tetrahedron) const {
  for (int i = 0; i < place_count; ++i)
    if (tetrahedra[static_cast<std::size_t>(i)] == tetrahedron) return i;
  COLOSSUS_CHECK(false, "the tetrahedron is not of this diamond");
  return -1;
}

std::vector<Point> Diamond::parents() const {
  std::vector<Point> found;
  for (int i = 0; i < place_count; ++i) {
    if (!is_inside[static_cast<std::size_t>(i)]) continue;
    for (const Point& corner : tetrahedra[static_cast<std::size_t>(i)].corners)
      // A tetrahedron's newest corner is the centre of the diamond whose split made it.
      if (level > 0 && level_of(corner) == level - 1) found.push_back(corner);
  }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

TetrahedronId id_of(const Tetrahedron& tetrahedron) {
  const Diamond diamond = Diamond::at(tetrahedron.center());
  return {diamond.center, static_cast<std::uint32_t>(diamond.place_of(tetrahedron))};
}

Tetrahedron tetrahedron_of(const TetrahedronId& id) {
  const Diamond diamond = Diamond::at(id.center);
  COLOSSUS_CHECK(static_cast<int>(id.place) < diamond.place_count);
  return diamond.tetrahedra[id.place];
}

std::array<Plane, 3> root_planes() {
  return {Plane{{1, -1, 0}, 0}, Plane{{0, 1, -1}, 0}, Plane{{1, 0, -1}, 0}};
}

}  // namespace colossus::hierarchy
