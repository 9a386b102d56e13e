#include "geometry/polygon.hpp"

#include <algorithm>
#include <bit>
#include <utility>

namespace colossus::geometry {
namespace {

using Wide = __int128;

constexpr std::size_t kLeaf = 8;            // corners in a leaf of the tree
constexpr std::size_t kMostTries = 8;       // starts of the ear search, for polygons of up to
constexpr std::size_t kManyCorners = 1024;  // these corners; larger ones get two
constexpr int kMostSteps = 256;             // along a spike that is bent, to its foot
constexpr std::uint64_t kMostMisses = 4;    // of a degree of patience, per corner

std::int64_t cross(std::int64_t au, std::int64_t av, std::int64_t bu, std::int64_t bv) {
  return au * bv - av * bu;  // below 2^61
}

// Twice the signed area of a triangle: positive if c lies to the left of the way from a to b.
template <typename Flat>
std::int64_t orientation(const Flat& a, const Flat& b, const Flat& c) {
  return cross(b.u - a.u, b.v - a.v, c.u - a.u, c.v - a.v);
}

template <typename T>
T magnitude(T x) {
  return x < 0 ? -x : x;
}

// The axis of the greatest component; of equal ones z, then y.
template <typename T>
int greatest_axis(const std::array<T, 3>& normal) {
  int best = 2;
  for (const int axis : {1, 0})
    if (magnitude(normal[static_cast<std::size_t>(axis)]) > magnitude(normal[static_cast<std::size_t>(best)]))
      best = axis;
  return best;
}

// The two axes of the projection along `axis` in which a positive area is one that faces along the normal.
struct Axes {
  int u;
  int v;
  Axes(int axis, bool is_positive) : u((axis + 1) % 3), v((axis + 2) % 3) {
    if (!is_positive) std::swap(u, v);
  }
};

// Newell's normal: twice the polygon's areas in the three coordinate planes.
std::array<Wide, 3> newell_normal(std::span<const Point> corners) {
  std::array<Wide, 3> normal{};
  const Point origin = corners[0];
  std::array<std::int64_t, 3> before{std::int64_t{corners[1].x} - origin.x,
                                     std::int64_t{corners[1].y} - origin.y,
                                     std::int64_t{corners[1].z} - origin.z};
  for (const Point& corner : corners.subspan(2)) {
    const std::array<std::int64_t, 3> now{std::int64_t{corner.x} - origin.x,
                                          std::int64_t{corner.y} - origin.y,
                                          std::int64_t{corner.z} - origin.z};
    normal[0] += cross(before[1], before[2], now[1], now[2]);
    normal[1] += cross(before[2], before[0], now[2], now[0]);
    normal[2] += cross(before[0], before[1], now[0], now[1]);
    before = now;
  }
  return normal;
}

// Only left turns, and once around: the direction's half-plane changes twice. A turn on the spot is none of
// them.
bool is_convex(std::span<const Point> corners, const Axes& axes) {
  const auto is_upper = [](std::int64_t u, std::int64_t v) { return v > 0 || (v == 0 && u > 0); };
  std::int64_t last_u = 0;
  std::int64_t last_v = 0;
  for (std::size_t i = corners.size(); i-- > 0 && last_u == 0 && last_v == 0;) {
    const Point& to = corners[i + 1 == corners.size() ? 0 : i + 1];
    last_u = std::int64_t{to[axes.u]} - corners[i][axes.u];
    last_v = std::int64_t{to[axes.v]} - corners[i][axes.v];
  }
  int changes = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Point& to = corners[i + 1 == corners.size() ? 0 : i + 1];
    const std::int64_t u = std::int64_t{to[axes.u]} - corners[i][axes.u];
    const std::int64_t v = std::int64_t{to[axes.v]} - corners[i][axes.v];
    if (u == 0 && v == 0) continue;
    if (cross(last_u, last_v, u, v) < 0) return false;
    changes += is_upper(u, v) != is_upper(last_u, last_v);
    if (changes > 2) return false;
    last_u = u;
    last_v = v;
  }
  return changes == 2;
}

bool is_collinear(std::span<const Point> corners) {
  const Point origin = corners[0];
  std::array<std::int64_t, 3> along{};
  for (const Point& corner : corners) {
    const std::array<std::int64_t, 3> now{std::int64_t{corner.x} - origin.x,
                                          std::int64_t{corner.y} - origin.y,
                                          std::int64_t{corner.z} - origin.z};
    if (along == std::array<std::int64_t, 3>{}) along = now;
    if (cross(along[1], along[2], now[1], now[2]) != 0 || cross(along[2], along[0], now[2], now[0]) != 0 ||
        cross(along[0], along[1], now[0], now[1]) != 0)
      return false;
  }
  return true;
}

// Half of the way between the corners that are farthest off along the normal, against the twentieth. The
// normal is first scaled by a power of two to at most 26 bits, which turns it by less than 2^-25; then all
// fits into 127 bits: heights are below 3 * 2^56, the way below 2^59.
template <typename T>
bool is_warped(std::span<const Point> corners, const std::array<T, 3>& normal) {
  const auto greatest =
      static_cast<unsigned __int128>(magnitude(normal[static_cast<std::size_t>(greatest_axis(normal))]));
  const auto upper = static_cast<std::uint64_t>(greatest >> 64);
  const auto bits = upper != 0 ? 64 + static_cast<int>(std::bit_width(upper))
                               : static_cast<int>(std::bit_width(static_cast<std::uint64_t>(greatest)));
  const int shift = std::max(0, bits - 26);
  std::array<std::int64_t, 3> scaled{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto shifted = static_cast<std::int64_t>(magnitude(normal[axis]) >> shift);
    scaled[axis] = normal[axis] < 0 ? -shifted : shifted;
  }
  const Point origin = corners[0];
  std::int64_t lowest = 0;
  std::int64_t highest = 0;
  Point low = origin;
  Point high = origin;
  for (const Point& corner : corners.subspan(1)) {
    const std::int64_t height = scaled[0] * (std::int64_t{corner.x} - origin.x) +
                                scaled[1] * (std::int64_t{corner.y} - origin.y) +
                                scaled[2] * (std::int64_t{corner.z} - origin.z);
    lowest = std::min(lowest, height);
    highest = std::max(highest, height);
    low = {std::min(low.x, corner.x), std::min(low.y, corner.y), std::min(low.z, corner.z)};
    high = {std::max(high.x, corner.x), std::max(high.y, corner.y), std::max(high.z, corner.z)};
  }
  const Wide way = highest - lowest;
  if (way == 0) return false;
  const Wide length = Wide{scaled[0]} * scaled[0] + Wide{scaled[1]} * scaled[1] + Wide{scaled[2]} * scaled[2];
  const Wide side =
      std::max({std::int64_t{high.x} - low.x, std::int64_t{high.y} - low.y, std::int64_t{high.z} - low.z});
  constexpr Wide kHalf = kWarpedFraction / 2;
  return kHalf * kHalf * way * way > side * side * length &&
         way * way > 4 * kWarpedUnits * kWarpedUnits * length;
}

// The bits of x at the even places of the result.
std::uint64_t spread_bits(std::uint64_t x) {
  x = (x | x << 16) & 0x0000ffff0000ffffULL;
  x = (x | x << 8) & 0x00ff00ff00ff00ffULL;
  x = (x | x << 4) & 0x0f0f0f0f0f0f0f0fULL;
  x = (x | x << 2) & 0x3333333333333333ULL;
  return (x | x << 1) & 0x5555555555555555ULL;
}

}  // namespace

PolygonTriangles PolygonTriangulator::triangulate(std::span<const Point> corners) {
  triangles_.clear();
  PolygonKind kind = PolygonKind::kConvex;
  if (corners.size() == 3)
    make_fan(0, 3);
  else if (corners.size() == 4)
    kind = triangulate_quad(corners);
  else if (corners.size() > 4)
    kind = triangulate_any(corners);
  return {kind, triangles_};
}

void PolygonTriangulator::make_fan(std::uint32_t first, std::uint32_t count) {
  const auto index = [&](std::uint32_t i) { return first + i < count ? first + i : first + i - count; };
  for (std::uint32_t i = 1; i + 1 < count; ++i) triangles_.push_back({first, index(i), index(i + 1)});
}

// A diagonal is right if the triangles at both of its sides are not turned over; both are in a convex quad,
// one in a concave one, none in one that crosses itself.
PolygonKind PolygonTriangulator::triangulate_quad(std::span<const Point> corners) {
  const auto [ax, ay, az] =
      std::array{std::int64_t{corners[2].x} - corners[0].x, std::int64_t{corners[2].y} - corners[0].y,
                 std::int64_t{corners[2].z} - corners[0].z};
  const auto [bx, by, bz] =
      std::array{std::int64_t{corners[3].x} - corners[1].x, std::int64_t{corners[3].y} - corners[1].y,
                 std::int64_t{corners[3].z} - corners[1].z};
  const std::array normal{cross(ay, az, by, bz), cross(az, ax, bz, bx), cross(ax, ay, bx, by)};
  const int axis = greatest_axis(normal);
  const std::int64_t area = normal[static_cast<std::size_t>(axis)];
  if (area == 0) return triangulate_any(corners);
  const Axes axes(axis, area > 0);
  std::array<Flat, 4> flat;
  for (std::size_t i = 0; i < 4; ++i) flat[i] = {corners[i][axes.u], corners[i][axes.v]};
  const std::int64_t turn_1 = orientation(flat[0], flat[1], flat[2]);
  const std::int64_t turn_3 = orientation(flat[2], flat[3], flat[0]);
  if (turn_1 >= 0 && turn_3 >= 0) {
    make_fan(0, 4);
    if (is_warped(corners, normal)) return PolygonKind::kWarped;
    const bool is_convex =
        orientation(flat[3], flat[0], flat[1]) >= 0 && orientation(flat[1], flat[2], flat[3]) >= 0;
    return is_convex ? PolygonKind::kConvex : PolygonKind::kConcave;
  }
  if (orientation(flat[3], flat[0], flat[1]) < 0 || orientation(flat[1], flat[2], flat[3]) < 0)
    return triangulate_any(corners);
  make_fan(turn_1 < 0 ? 1 : 3, 4);
  return is_warped(corners, normal) ? PolygonKind::kWarped : PolygonKind::kConcave;
}

PolygonKind PolygonTriangulator::triangulate_any(std::span<const Point> corners) {
  const auto count = static_cast<std::uint32_t>(corners.size());
  const std::array<Wide, 3> normal = newell_normal(corners);
  const int axis = greatest_axis(normal);
  const Wide area = normal[static_cast<std::size_t>(axis)];
  if (area == 0 ? is_collinear(corners) : is_convex(corners, Axes(axis, area > 0))) {
    make_fan(0, count);
    return is_warped(corners, normal) ? PolygonKind::kWarped : PolygonKind::kConvex;
  }
  return cut_ears(corners, normal);
}

// Along the axis of the greatest area first. Another one is tried where the area is not much less, since a
// polygon that is far from flat may be simple there; it counts only if it succeeds.
PolygonKind PolygonTriangulator::cut_ears(std::span<const Point> corners, const std::array<Wide, 3>& normal) {
  const auto count = static_cast<std::uint32_t>(corners.size());
  std::array<Wide, 3> areas = normal;
  if (areas == std::array<Wide, 3>{}) {  // a figure of eight: where its box is greatest
    Point low = corners[0];
    Point high = corners[0];
    for (const Point& corner : corners)
      for (int k = 0; k < 3; ++k) {
        low[k] = std::min(low[k], corner[k]);
        high[k] = std::max(high[k], corner[k]);
      }
    for (int k = 0; k < 3; ++k) {
      const int u = (k + 1) % 3;
      const int v = (k + 2) % 3;
      areas[static_cast<std::size_t>(k)] = (Wide{high[u]} - low[u] + 1) * (Wide{high[v]} - low[v] + 1);
    }
  }
  const auto area_along = [&](int axis) { return areas[static_cast<std::size_t>(axis)]; };
  const auto kind = [&] { return is_warped(corners, normal) ? PolygonKind::kWarped : PolygonKind::kConcave; };
  const int main_axis = greatest_axis(areas);

  project(corners, main_axis, area_along(main_axis) > 0);
  const std::size_t tries = count <= kManyCorners ? std::min<std::size_t>(kMostTries, count) : 2;
  Wide least = 0;
  for (std::size_t k = 0; k < tries; ++k) {
    cuts_slits_ = k % 2 != 0;
    const Wide turned_over = search(static_cast<std::uint32_t>(k / 2 * count / tries));
    if (turned_over == 0) return kind();
    if (k == 0 || turned_over < least) {
      least = turned_over;
      best_.swap(triangles_);
    }
  }
  if (turned_over_in_fan() <= least) {
    best_.clear();
    best_.swap(triangles_);
    triangles_.clear();
    make_fan(0, count);
    best_.swap(triangles_);
  }
  cuts_slits_ = false;
  for (int step = 1; step < 3; ++step) {
    const int axis = (main_axis + step) % 3;
    if (8 * magnitude(area_along(axis)) < magnitude(area_along(main_axis))) continue;
    project(corners, axis, area_along(axis) > 0);
    if (search(0) == 0) return kind();
  }
  triangles_.swap(best_);
  return PolygonKind::kCrossing;
}

void PolygonTriangulator::project(std::span<const Point> corners, int axis, bool is_positive) {
  const Axes axes(axis, is_positive);
  corners_.assign(corners.size(), {});
  for (std::size_t i = 0; i < corners.size(); ++i) corners_[i].at = {corners[i][axes.u], corners[i][axes.v]};
  plant_tree();
}

// A complete binary tree over the corners in Morton order, so that what is near each other has a small common
// box however unevenly the corners lie.
void PolygonTriangulator::plant_tree() {
  const std::size_t count = corners_.size();
  order_.resize(count);
  for (std::size_t i = 0; i < count; ++i) order_[i] = static_cast<std::uint32_t>(i);
  if (count > kLeaf) {
    keys_.resize(count);
    for (std::size_t i = 0; i < count; ++i)
      keys_[i] = spread_bits(static_cast<std::uint64_t>(corners_[i].at.u)) |
                 spread_bits(static_cast<std::uint64_t>(corners_[i].at.v)) << 1;
    std::sort(order_.begin(), order_.end(), [&](std::uint32_t a, std::uint32_t b) {
      return std::pair(keys_[a], a) < std::pair(keys_[b], b);
    });
  }
  for (std::size_t slot = 0; slot < count; ++slot)
    corners_[order_[slot]].slot = static_cast<std::uint32_t>(slot);
  first_leaf_ = std::bit_ceil((count + kLeaf - 1) / kLeaf);
  tree_.assign(2 * first_leaf_, {{kRootSide, kRootSide}, {0, 0}, 0});  // empty
  const auto grow = [](Box& box, const Flat& low, const Flat& high) {
    box.low = {std::min(box.low.u, low.u), std::min(box.low.v, low.v)};
    box.high = {std::max(box.high.u, high.u), std::max(box.high.v, high.v)};
  };
  for (std::size_t slot = 0; slot < count; ++slot) {
    const Flat& at = corners_[order_[slot]].at;
    grow(tree_[first_leaf_ + slot / kLeaf], at, at);
  }
  for (std::size_t node = first_leaf_; node-- > 1;)
    for (const std::size_t child : {2 * node, 2 * node + 1})
      grow(tree_[node], tree_[child].low, tree_[child].high);
}

std::int64_t PolygonTriangulator::turn_at(std::uint32_t corner) const {
  const Corner& b = corners_[corner];
  return orientation(corners_[b.previous].at, b.at, corners_[b.next].at);
}

void PolygonTriangulator::set_obstacle(std::uint32_t corner, bool is_obstacle) {
  Corner& c = corners_[corner];
  if (c.is_obstacle == is_obstacle) return;
  c.is_obstacle = is_obstacle;
  for (std::size_t node = first_leaf_ + c.slot / kLeaf; node > 0; node /= 2)
    is_obstacle ? ++tree_[node].obstacles : --tree_[node].obstacles;
}

// After something has changed at a corner. If it is in the queue already, it goes to the end.
void PolygonTriangulator::look_at(std::uint32_t corner) {
  set_obstacle(corner, turn_at(corner) <= 0);
  corners_[corner].ticket = queue_.size();
  queue_.push_back(corner);
}

void PolygonTriangulator::begin_search(std::uint32_t start) {
  const auto count = static_cast<std::uint32_t>(corners_.size());
  triangles_.clear();
  for (Box& box : tree_) box.obstacles = 0;
  queue_.clear();
  served_ = 0;
  left_ = count;
  turned_over_ = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    Corner& corner = corners_[i];
    corner.previous = i == 0 ? count - 1 : i - 1;
    corner.next = i + 1 == count ? 0 : i + 1;
    corner.is_cut = corner.is_obstacle = false;
  }
  for (std::uint32_t i = 0; i < count; ++i) look_at(start + i < count ? start + i : start + i - count);
}

void PolygonTriangulator::take_triangle(std::uint32_t corner) {
  triangles_.push_back({corners_[corner].previous, corner, corners_[corner].next});
  turned_over_ += std::max<std::int64_t>(0, -turn_at(corner));
}

// Returns the corner before it.
std::uint32_t PolygonTriangulator::cut(std::uint32_t corner) {
  const auto [a, c] = std::pair(corners_[corner].previous, corners_[corner].next);
  take_triangle(corner);
  corners_[corner].is_cut = true;
  set_obstacle(corner, false);
  corners_[a].next = c;
  corners_[c].previous = a;
  --left_;
  const bool a_waits = corners_[a].ticket >= served_;
  const bool c_waits = corners_[c].ticket >= served_;
  const auto [first, second] = c_waits && !a_waits ? std::pair(c, a) : std::pair(a, c);
  look_at(first);
  look_at(second);
  return a;
}

void PolygonTriangulator::serve_queue() {
  while (left_ > 3 && served_ < queue_.size()) {
    const std::size_t ticket = served_++;
    const std::uint32_t corner = queue_[ticket];
    const bool is_due = corners_[corner].ticket == ticket && !corners_[corner].is_cut;
    if (is_due && is_acceptable(corner, Patience::kEar)) cut(corner);
  }
}

// Cuts ears until a triangle is left, and returns twice the area of the triangles that are turned over: 0 is
// success.
//
// First in, first out, and a corner beside a cut has to wait, longer than the other if it has waited less:
// ears are cut all around and a strip from both its sides, rather than one behind the other, which would give
// long fans of slivers. In a simple polygon the queue runs dry only when all is done. Otherwise a second
// search goes round and has more and more patience, the longer it finds nothing; whenever it does, the queue
// is next.
__int128 PolygonTriangulator::search(std::uint32_t start) {
  begin_search(start);
  auto patience = Patience::kTouchedEar;
  std::uint32_t cursor = start;
  std::uint32_t misses = 0;
  std::uint64_t all_misses = 0;
  for (serve_queue(); left_ > 3; serve_queue()) {
    while (corners_[cursor].is_cut) cursor = corners_[cursor].next;
    if (is_acceptable(cursor, patience)) {
      cursor = cut(cursor);
      misses = 0;
      continue;
    }
    cursor = corners_[cursor].next;
    ++all_misses;
    if (++misses < left_ && all_misses < kMostMisses * corners_.size()) continue;
    patience = static_cast<Patience>(static_cast<int>(patience) + 1);
    misses = 0;
    all_misses = 0;
  }
  while (corners_[cursor].is_cut) cursor = corners_[cursor].next;
  take_triangle(cursor);
  return turned_over_;
}

__int128 PolygonTriangulator::turned_over_in_fan() const {
  Wide turned_over = 0;
  for (std::size_t i = 1; i + 1 < corners_.size(); ++i)
    turned_over +=
        std::max<std::int64_t>(0, -orientation(corners_[0].at, corners_[i].at, corners_[i + 1].at));
  return turned_over;
}

bool PolygonTriangulator::is_acceptable(std::uint32_t corner, Patience patience) const {
  const std::int64_t turn = turn_at(corner);
  const auto [a, c] = std::pair(corners_[corner].previous, corners_[corner].next);
  if (turn > 0 && is_free(a, corner, c, patience != Patience::kEar)) return true;
  if (turn == 0 && (patience >= Patience::kCollinear || is_needless(corner))) return true;
  if (turn < 0 && patience >= Patience::kEitherSide && is_free(c, corner, a, true)) return true;
  return patience == Patience::kAnything;
}

// A corner that lies on one of its neighbours, or is the tip of a spike that sticks out: its triangle is
// collinear in every triangulation. The tip of a slit looks the same but for what is beside the foot, where
// both sides part: going round from the tip against the clock, a slit has the side from which the way comes
// before the one to which it goes.
bool PolygonTriangulator::is_needless(std::uint32_t corner) const {
  Flat tip = corners_[corner].at;
  std::uint32_t a = corners_[corner].previous;
  std::uint32_t c = corners_[corner].next;
  if (corners_[a].at == tip || corners_[c].at == tip) return true;
  const auto dot = [](const Flat& origin, const Flat& p, const Flat& q) {
    return (p.u - origin.u) * (q.u - origin.u) + (p.v - origin.v) * (q.v - origin.v);
  };
  if (dot(tip, corners_[a].at, corners_[c].at) < 0) return false;  // flat
  if (cuts_slits_) return true;
  const auto distance = [&](const Flat& p) {
    return std::max(magnitude(p.u - tip.u), magnitude(p.v - tip.v));
  };
  for (int step = 0; step < kMostSteps; ++step) {
    // a and c lie on one ray from the tip.
    if (a == c || corners_[c].next == a) return true;
    const std::int64_t distance_a = distance(corners_[a].at);
    const std::int64_t distance_c = distance(corners_[c].at);
    const Flat foot = distance_a < distance_c ? corners_[a].at : corners_[c].at;
    if (distance_a <= distance_c) a = corners_[a].previous;
    if (distance_c <= distance_a) c = corners_[c].next;
    const Flat from = corners_[a].at;
    const Flat to = corners_[c].at;
    if (from == foot || to == foot) return true;
    const auto quarter = [&](const Flat& p) {  // 0: as the tip, 1: to the left, 2: opposite, 3: to the right
      const std::int64_t side = orientation(foot, tip, p);
      return side > 0 ? 1 : side < 0 ? 3 : dot(foot, tip, p) > 0 ? 0 : 2;
    };
    const int from_quarter = quarter(from);
    const int to_quarter = quarter(to);
    if (from_quarter == 0 || to_quarter == 0) return true;
    if (from_quarter != to_quarter) return to_quarter < from_quarter;
    const std::int64_t side = orientation(foot, from, to);
    if (side != 0) return side < 0;
    tip = foot;
  }
  return false;
}

// Whether the triangle, which turns to the left, holds nothing of the rest of the polygon. `may_touch`: a
// corner may lie on its third side.
bool PolygonTriangulator::is_free(std::uint32_t a, std::uint32_t b, std::uint32_t c, bool may_touch) const {
  const std::array<Flat, 3> ear{corners_[a].at, corners_[b].at, corners_[c].at};
  // The edges beyond a and c must not go into the ear either.
  for (const std::uint32_t end : {a, c})
    if (is_blocked_by(ear, end, true)) return false;
  const Flat low{std::min({ear[0].u, ear[1].u, ear[2].u}), std::min({ear[0].v, ear[1].v, ear[2].v})};
  const Flat high{std::max({ear[0].u, ear[1].u, ear[2].u}), std::max({ear[0].v, ear[1].v, ear[2].v})};
  const auto is_apart = [&](const Box& box) {
    if (box.low.u > high.u || box.high.u < low.u || box.low.v > high.v || box.high.v < low.v) return true;
    for (std::size_t k = 0; k < 3; ++k) {  // the whole box to the right of a side
      const Flat& from = ear[k];
      const Flat& to = ear[k == 2 ? 0 : k + 1];
      const Flat leftmost{to.v >= from.v ? box.low.u : box.high.u, to.u >= from.u ? box.high.v : box.low.v};
      if (orientation(from, to, leftmost) < 0) return true;
    }
    return false;
  };
  std::array<std::size_t, 64> stack;  // one waits on each level of the tree
  std::size_t depth = 0;
  stack[depth++] = 1;
  while (depth > 0) {
    const std::size_t node = stack[--depth];
    if (tree_[node].obstacles == 0 || is_apart(tree_[node])) continue;
    if (node < first_leaf_) {
      stack[depth++] = 2 * node + 1;
      stack[depth++] = 2 * node;
      continue;
    }
    const std::size_t first = (node - first_leaf_) * kLeaf;
    for (std::size_t slot = first; slot < std::min(first + kLeaf, order_.size()); ++slot) {
      const std::uint32_t p = order_[slot];
      if (corners_[p].is_obstacle && p != a && p != b && p != c && is_blocked_by(ear, p, may_touch))
        return false;
    }
  }
  return true;
}

// Inside, or on the third side unless it may touch it, or on the border with an edge that goes inside.
bool PolygonTriangulator::is_blocked_by(const std::array<Flat, 3>& ear, std::uint32_t corner,
                                        bool may_touch) const {
  const Flat& p = corners_[corner].at;
  const std::array sides{orientation(ear[0], ear[1], p), orientation(ear[1], ear[2], p),
                         orientation(ear[2], ear[0], p)};
  if (sides[0] < 0 || sides[1] < 0 || sides[2] < 0) return false;
  if (sides[0] > 0 && sides[1] > 0 && (sides[2] > 0 || !may_touch)) return true;
  for (const std::uint32_t other : {corners_[corner].previous, corners_[corner].next}) {
    bool goes_inside = true;
    for (std::size_t k = 0; k < 3 && goes_inside; ++k)
      goes_inside = sides[k] != 0 || orientation(ear[k], ear[k == 2 ? 0 : k + 1], corners_[other].at) > 0;
    if (goes_inside) return true;
  }
  return false;
}

}  // namespace colossus::geometry
