// The built-in statue: a draped figure on a plinth.
//
// Topology: the surface of a box of n x n x m cells, hence closed and manifold at every size. Geometry:
// horizontal sections between an ellipse and a rounded square, whose measures follow a profile from the
// middle of the bottom, over the plinth, the robe and the head, to the crown. A vertex is numbered by its
// cell: bottom grid, rings upward, top grid.
#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "synth/surface.hpp"

namespace colossus::synth {
namespace {

// Measures of a horizontal section in millimetres: height, half width, half depths to the front (-y) and to
// the back, centre, and 0 for an ellipse to 1 for a rounded square.
enum Measure : std::size_t { kHeight, kWidth, kFront, kBack, kCenterX, kCenterY, kSquare, kMeasureCount };
using Measures = std::array<double, kMeasureCount>;

constexpr double kHeadHeight = 1835, kHeadRadius = 150, kCrown = 0.85;
constexpr Measures kHead = {kHeadHeight, 96, 112, 118, 0, -12, 0};

constexpr auto kProfile = std::to_array<Measures>({
    {0, 255, 255, 255, 0, 0, 1},
    {20, 255, 255, 255, 0, 0, 1},
    {95, 255, 255, 255, 0, 0, 1},
    {135, 240, 240, 240, 0, 0, 1},
    {165, 225, 225, 225, 0, 0, 1},
    {195, 230, 230, 230, 0, 0, 1},
    {220, 238, 238, 238, 0, 0, 1},
    {240, 236, 234, 234, 0, 0, 0.9},
    {265, 222, 214, 212, 0, 0, 0.5},
    {300, 208, 188, 184, 0, 0, 0.1},
    {345, 201, 178, 172, 0, 0, 0},
    {420, 194, 168, 160, 4, 0, 0},
    {700, 184, 156, 140, 10, -4, 0},
    {1000, 196, 148, 140, 18, 0, 0},
    {1110, 194, 140, 142, 16, 4, 0},
    {1250, 158, 112, 114, 6, 6, 0},
    {1360, 182, 128, 112, -4, 6, 0},
    {1450, 210, 138, 114, -8, 6, 0},
    {1540, 226, 118, 114, -8, 8, 0.1},
    {1590, 212, 98, 108, -6, 8, 0.1},
    {1625, 160, 84, 100, -4, 6, 0},
    {1655, 106, 76, 96, -2, 4, 0},
    {1685, 82, 72, 92, 0, 0, 0},
    {1708, 78, 82, 94, 0, -6, 0},
    {1735, 82, 100, 98, 0, -12, 0},
    {1785, 92, 110, 112, 0, -12, 0},
    kHead,
    {1872, 93, 109, 114.3, 0, -12, 0},
    {1914.017, 81.6, 95.2, 100.3, 0, -12, 0},
    {1942.1, 67.2, 78.4, 82.6, 0, -12,
     0},  // past the crown, where the top grid takes over: for its slope only
});
constexpr std::size_t kSegments = kProfile.size() - 2;

// A capsule of clay: raises (or carves, if negative) the surface within `radius` of the line from `from` to
// `to`.
struct Capsule {
  std::array<float, 3> from, to;
  float radius, height;
};

constexpr auto kCapsules = std::to_array<Capsule>({
    {{218, 8, 1530}, {232, 12, 1300}, 72, 42},      // right upper arm
    {{232, 12, 1290}, {70, -140, 1195}, 62, 38},    // right forearm, across the waist
    {{80, -150, 1195}, {20, -150, 1180}, 40, 20},   // right hand
    {{-226, 8, 1530}, {-214, 14, 1270}, 72, 42},    // left upper arm
    {{-214, 14, 1270}, {-206, -30, 1040}, 58, 36},  // left forearm
    {{-206, -34, 1030}, {-202, -44, 950}, 42, 24},  // left hand
    {{75, -130, 1425}, {70, -134, 1420}, 78, 22},   // chest
    {{-85, -130, 1425}, {-80, -134, 1420}, 78, 22},
    {{80, -150, 1050}, {95, -165, 640}, 130, 26},  // the leg that carries no weight, under the robe
    {{95, -175, 640}, {95, -170, 600}, 80, 16},    // its knee
    {{-40, -165, 370}, {-40, -172, 345}, 55, 10},  // feet
    {{100, -150, 370}, {100, -160, 345}, 55, 12},
    {{0, -122, 1866}, {0, -124, 1824}, 20, 17},  // nose
    {{0, -124, 1822}, {0, -126, 1816}, 17, 15},
    {{-12, -120, 1816}, {12, -120, 1816}, 11, 5},
    {{-36, -108, 1853}, {-34, -110, 1853}, 26, -11},  // eye sockets and eyes
    {{36, -108, 1853}, {34, -110, 1853}, 26, -11},
    {{-40, -106, 1852}, {-32, -108, 1852}, 13, 7},
    {{40, -106, 1852}, {32, -108, 1852}, 13, 7},
    {{-14, -112, 1874}, {-58, -96, 1873}, 13, 5},  // brows
    {{14, -112, 1874}, {58, -96, 1873}, 13, 5},
    {{-18, -118, 1789}, {18, -118, 1789}, 10, 6},  // lips
    {{-20, -118, 1781}, {20, -118, 1781}, 5, -5},
    {{-15, -117, 1773}, {15, -117, 1773}, 10, 6},
    {{0, -112, 1748}, {0, -110, 1744}, 26, 10},  // chin
    {{-70, 30, 1905}, {70, 30, 1905}, 70, 14},   // hair
    {{0, 120, 1800}, {0, 112, 1770}, 66, 40},    // a knot of hair
});

// A section as the vertices of one ring use it: measures, and their change per step along the profile.
struct Section {
  std::array<float, kMeasureCount> value;
  std::array<float, kMeasureCount> slope;
  float scale;   // of the ring: 0 in the middle of the bottom and top grids, where the ring is one vertex
  float relief;  // 0 to 1: how much of the relief
};

inline float smooth_step(float t) {
  t = std::min(std::max(t, 0.0F), 1.0F);
  return t * t * (3.0F - 2.0F * t);
}

// The sharp edge at the bottom would turn inside out under relief deeper than a triangle, so the relief fades
// there: its share at a distance along the surface.
float relief_near_edge(double distance) {
  return std::max(smooth_step(static_cast<float>(distance / 40)), 1e-3F);
}

double harmonic_mean_slope(double before, double after) {
  return before * after <= 0 ? 0 : 2 * before * after / (before + after);
}

// The profile as a curve over s in [0, kSegments]: cubic through the table's lines, without overshoot (slopes
// after Fritsch and Butland 1984), so that ledges stay ledges.
struct ProfilePoint {
  Measures value, slope;
};

double knot_distance(std::size_t knot) {
  const double rise = kProfile[knot + 1][kHeight] - kProfile[knot][kHeight];
  const double run = kProfile[knot + 1][kWidth] - kProfile[knot][kWidth];
  return std::sqrt(rise * rise + run * run);
}

ProfilePoint profile_at(double s) {
  const std::size_t knot = std::min(static_cast<std::size_t>(s), kSegments - 1);
  const double t = s - static_cast<double>(knot), length = knot_distance(knot);
  ProfilePoint point{};
  for (std::size_t i = 0; i < kMeasureCount; ++i) {
    const double a = kProfile[knot][i], b = kProfile[knot + 1][i], here = (b - a) / length;
    const double before = knot == 0 ? here : (a - kProfile[knot - 1][i]) / knot_distance(knot - 1);
    const double after = (kProfile[knot + 2][i] - b) / knot_distance(knot + 1);
    const double c = length * harmonic_mean_slope(before, here),
                 d = length * harmonic_mean_slope(here, after);
    point.value[i] = a + t * (c + t * ((3 * (b - a) - 2 * c - d) + t * (c + d - 2 * (b - a))));
    point.slope[i] = c + t * (2 * (3 * (b - a) - 2 * c - d) + 3 * t * (c + d - 2 * (b - a)));
  }
  return point;
}

// How far along the profile's length each of equally spaced parameters lies; its end is the length in
// millimetres.
constexpr std::size_t kLengthSamples = 64 * kSegments;

std::vector<double> profile_lengths() {
  std::vector<double> lengths{0};
  Measures last = kProfile[0];
  for (std::size_t i = 1; i <= kLengthSamples; ++i) {
    const Measures next = profile_at(static_cast<double>(i) * kSegments / kLengthSamples).value;
    const double rise = next[kHeight] - last[kHeight], run = next[kWidth] - last[kWidth];
    lengths.push_back(lengths.back() + std::sqrt(rise * rise + run * run));
    last = next;
  }
  return lengths;
}

Section make_section(const Measures& value, const Measures& slope, double scale, float relief) {
  Section section{};
  for (std::size_t i = 0; i < kMeasureCount; ++i) {
    section.value[i] = static_cast<float>(value[i]);
    section.slope[i] = static_cast<float>(slope[i]);
  }
  section.scale = static_cast<float>(scale);
  section.relief = relief;
  return section;
}

// Ring `ring` of the bottom grid, 0 to n from the middle outwards.
Section bottom_section(std::uint64_t ring, std::uint64_t n) {
  Measures slope{};
  slope[kWidth] = slope[kFront] = slope[kBack] = kProfile[0][kWidth];
  if (ring == n) slope[kHeight] = kProfile[0][kWidth];  // the edge looks down and out
  const double across = static_cast<double>(ring) / static_cast<double>(n);
  return make_section(kProfile[0], slope, across, relief_near_edge((1 - across) * kProfile[0][kWidth]));
}

// The same of the top grid: the upper cap of the head's ellipsoid.
Section top_section(std::uint64_t ring, std::uint64_t n) {
  const double across = static_cast<double>(ring) / static_cast<double>(n), g = kCrown * across;
  const double up = std::sqrt(1 - g * g);
  Measures value = kHead, slope{};
  value[kHeight] += kHeadRadius * up;
  for (const std::size_t i : {kWidth, kFront, kBack}) {
    value[i] *= kCrown;
    slope[i] = -value[i];
  }
  slope[kHeight] = kHeadRadius * kCrown * g / up;
  return make_section(value, slope, across, 1);
}

// Cells of the box, and the numbers that follow from them.
struct Box {
  std::uint64_t n = 1, m = 1;  // cells along a side of the square sections, and upward
  std::uint64_t grid_vertices() const { return (n + 1) * (n + 1); }
  std::uint64_t vertices() const { return 2 * grid_vertices() + (m - 1) * 4 * n; }
  std::uint64_t quads() const { return 2 * n * n + 4 * n * m; }
};

constexpr double kCellsUpPerCellAcross = 8.3;  // makes the cells of the sides nearly square on average

Box choose_box(std::uint64_t triangles) {
  const auto wanted = static_cast<double>(triangles);
  const double ideal = std::sqrt(wanted / (4 + 8 * kCellsUpPerCellAcross));
  const auto lowest = static_cast<std::uint64_t>(std::max(1.0, 0.92 * ideal - 1));
  const auto highest = static_cast<std::uint64_t>(1.08 * ideal + 2);
  Box best;
  double best_off = -1;
  for (std::uint64_t n = lowest; n <= highest; ++n) {
    const auto width = static_cast<double>(n);
    const double up = (wanted - 4 * width * width) / (8 * width);
    const Box box{n, static_cast<std::uint64_t>(std::max(1.0, up + 0.5))};
    const double off = std::abs(2 * static_cast<double>(box.quads()) - wanted);
    // The shape of the cells decides between boxes of nearly the same count.
    const double score = off / wanted + 1e-3 * std::abs(width - ideal) / ideal;
    if (best_off >= 0 && score >= best_off) continue;
    best_off = score;
    best = box;
  }
  return best;
}

struct Place {
  std::uint32_t i, j, section;
};

class StatueSurface final : public SynthSurface {
 public:
  StatueSurface(std::uint64_t triangles, std::uint64_t seed);

  std::uint64_t vertex_count() const override { return box_.vertices(); }
  std::uint64_t triangle_count() const override { return 2 * box_.quads(); }
  double extent() const override { return 2000; }
  double relief_wavelength() const override { return 160; }
  double mean_edge() const override { return mean_edge_; }
  double largest_coordinate() const override { return 2048; }
  void evaluate(std::span<const std::uint32_t> vertices, SurfaceBatch& batch) const override;
  void add_carving(const PointBatch& local, std::size_t count, Lane& height) const override;
  void triangles(std::uint64_t first, std::span<std::array<std::uint32_t, 3>> corners) const override;
  void triangles_at(std::span<const std::uint64_t> numbers,
                    std::span<std::array<std::uint32_t, 3>> corners) const override;

 private:
  Place place(std::uint32_t vertex) const;
  std::uint32_t ring_vertex(std::uint64_t level, std::uint64_t around) const;
  std::array<std::uint32_t, 4> quad(std::uint64_t index) const;
  void add_folds(const PointBatch& local, std::size_t count, Lane& height) const;

  Box box_;
  double mean_edge_ = 1;
  std::vector<Section> sections_;  // bottom rings 0..n, levels 1..m-1, top rings n..0
  NoiseOctave fold_warp_, fold_depth_;
};

StatueSurface::StatueSurface(std::uint64_t triangles, std::uint64_t seed) : box_(choose_box(triangles)) {
  if (box_.vertices() > kMaxSynthVertices)
    core::fail(core::Status::kUsage, "synth: {} triangles need {} vertices; at most {} are supported",
               triangles, box_.vertices(), kMaxSynthVertices);
  const std::uint64_t n = box_.n, m = box_.m;
  sections_.reserve(2 * n + m + 1);
  for (std::uint64_t ring = 0; ring <= n; ++ring) sections_.push_back(bottom_section(ring, n));
  const std::vector<double> lengths = profile_lengths();
  std::size_t sample = 0;
  for (std::uint64_t level = 1; level < m; ++level) {
    const double length = lengths.back() * static_cast<double>(level) / static_cast<double>(m);
    while (lengths[sample + 1] < length) ++sample;
    const double part = (length - lengths[sample]) / (lengths[sample + 1] - lengths[sample]);
    const ProfilePoint point = profile_at((static_cast<double>(sample) + part) * kSegments / kLengthSamples);
    sections_.push_back(make_section(point.value, point.slope, 1, relief_near_edge(point.value[kHeight])));
  }
  for (std::uint64_t ring = n + 1; ring-- > 0;) sections_.push_back(top_section(ring, n));
  mean_edge_ =
      std::sqrt(2.75e6 / static_cast<double>(box_.quads()));  // the shape has about 2.75 square metres
  fold_warp_ = make_octave(seed, 1000, 420, 1.6);
  fold_depth_ = make_octave(seed, 1001, 260, 1.2);
}

Place StatueSurface::place(std::uint32_t vertex) const {
  const auto n = static_cast<std::uint32_t>(box_.n), m = static_cast<std::uint32_t>(box_.m);
  const auto grid = static_cast<std::uint32_t>(box_.grid_vertices());
  const auto top = static_cast<std::uint32_t>(box_.vertices() - box_.grid_vertices());
  if (vertex < grid || vertex >= top) {
    const std::uint32_t index = vertex < grid ? vertex : vertex - top;
    const std::uint32_t i = index % (n + 1), j = index / (n + 1);
    const std::uint32_t ring =
        std::max(std::max(2 * i, n) - std::min(2 * i, n), std::max(2 * j, n) - std::min(2 * j, n));
    return {i, j, vertex < grid ? ring : 2 * n + m - ring};
  }
  const std::uint32_t level = 1 + (vertex - grid) / (4 * n), around = (vertex - grid) % (4 * n);
  const std::uint32_t section = n + level, side = around / n, along = around % n;
  if (side == 0) return {along, 0, section};
  if (side == 1) return {n, along, section};
  if (side == 2) return {n - along, n, section};
  return {0, n - along, section};
}

std::uint32_t StatueSurface::ring_vertex(std::uint64_t level, std::uint64_t around) const {
  const std::uint64_t n = box_.n;
  if (around == 4 * n) around = 0;
  if (level > 0 && level < box_.m)
    return static_cast<std::uint32_t>(box_.grid_vertices() + (level - 1) * 4 * n + around);
  const std::uint64_t side = around / n, along = around % n;
  const std::uint64_t i = side == 0 ? along : side == 1 ? n : side == 2 ? n - along : 0;
  const std::uint64_t j = side == 0 ? 0 : side == 1 ? along : side == 2 ? n : n - along;
  const std::uint64_t grid = level == 0 ? 0 : box_.vertices() - box_.grid_vertices();
  return static_cast<std::uint32_t>(grid + j * (n + 1) + i);
}

std::array<std::uint32_t, 4> StatueSurface::quad(std::uint64_t index) const {
  const std::uint64_t n = box_.n, grid_quads = n * n, side_quads = 4 * n * box_.m;
  if (index >= grid_quads && index < grid_quads + side_quads) {
    const std::uint64_t level = (index - grid_quads) / (4 * n), around = (index - grid_quads) % (4 * n);
    return {ring_vertex(level, around), ring_vertex(level, around + 1), ring_vertex(level + 1, around + 1),
            ring_vertex(level + 1, around)};
  }
  const bool bottom = index < grid_quads;
  const std::uint64_t cell = bottom ? index : index - grid_quads - side_quads;
  const std::uint64_t grid = bottom ? 0 : box_.vertices() - box_.grid_vertices();
  const std::uint64_t corner = grid + cell / n * (n + 1) + cell % n;
  const auto a = static_cast<std::uint32_t>(corner), b = static_cast<std::uint32_t>(corner + 1);
  const auto c = static_cast<std::uint32_t>(corner + n + 2), d = static_cast<std::uint32_t>(corner + n + 1);
  // The diagonal between the first and third runs outward: in the corners of the grid, three vertices in a
  // row of the outermost ring make no triangle.
  const bool rising = (2 * (cell % n) < n) == (2 * (cell / n) < n);
  if (bottom) return rising ? std::array{a, d, c, b} : std::array{d, c, b, a};
  return rising ? std::array{a, b, c, d} : std::array{b, c, d, a};
}

void StatueSurface::triangles(std::uint64_t first, std::span<std::array<std::uint32_t, 3>> corners) const {
  for (std::size_t t = 0; t < corners.size();) {
    const std::uint64_t index = (first + t) / 2;
    const auto [a, b, c, d] = quad(index);
    if ((first + t) % 2 == 0) {
      corners[t++] = {a, b, c};
      if (t == corners.size()) break;
    }
    corners[t++] = {a, c, d};
  }
}

void StatueSurface::triangles_at(std::span<const std::uint64_t> numbers,
                                 std::span<std::array<std::uint32_t, 3>> corners) const {
  for (std::size_t t = 0; t < corners.size(); ++t) {
    const auto [a, b, c, d] = quad(numbers[t] / 2);
    const bool is_second = numbers[t] % 2 == 1;
    corners[t] = {a, is_second ? c : b, is_second ? d : c};
  }
}

// About tan(pi / 4 * x): spaces the directions of equally spaced points of a square's side evenly.
inline float even_direction(float x) { return x * (0.7854F + 0.2146F * x * x); }

struct SurfacePoint {
  std::array<float, 3> position, normal;
};

// The point of a section's ring in the direction of (across, along) on the square's border.
SurfacePoint point_of_ring(const Section& section, float across, float along) {
  const auto& value = section.value;
  const auto& slope = section.slope;
  const float dx = even_direction(across), dy = even_direction(along);
  // The unit circle and the rounded square (the 8-norm's unit ball) in that direction; how the latter shrinks
  // as the direction turns.
  const float dx2 = dx * dx, dy2 = dy * dy, dx4 = dx2 * dx2, dy4 = dy2 * dy2;
  const float circle = 1.0F / std::sqrt(dx2 + dy2);
  const float square = 1.0F / std::sqrt(std::sqrt(std::sqrt(dx4 * dx4 + dy4 * dy4)));
  const float square2 = square * square, square4 = square2 * square2;
  const float shrink = (dy4 * dy2 - dx4 * dx2) * dx * dy * square4 * square4 * square;
  const float q = value[kSquare], reach = circle + q * (square - circle);
  const float rx = dx * reach, ry = dy * reach, width = value[kWidth];
  const float depth = dy < 0.0F ? value[kFront] : value[kBack];
  const float depth_slope = dy < 0.0F ? slope[kFront] : slope[kBack];
  // Tangents along the ring (u) and along the profile (v).
  const float ux = width * (-dy * reach - q * shrink * dx), uy = depth * (dx * reach - q * shrink * dy);
  const float swell = slope[kSquare] * (square - circle);
  const float vx = slope[kCenterX] + slope[kWidth] * rx + width * dx * swell;
  const float vy = slope[kCenterY] + depth_slope * ry + depth * dy * swell;
  const float vz = slope[kHeight];
  const float nx = uy * vz, ny = -ux * vz, nz = ux * vy - uy * vx;
  const float scale = section.relief / std::sqrt(nx * nx + ny * ny + nz * nz);
  return {{value[kCenterX] + section.scale * width * rx, value[kCenterY] + section.scale * depth * ry,
           value[kHeight]},
          {nx * scale, ny * scale, nz * scale}};
}

void StatueSurface::evaluate(std::span<const std::uint32_t> vertices, SurfaceBatch& batch) const {
  const auto n = static_cast<std::int32_t>(box_.n);
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const Place place = this->place(vertices[i]);
    const std::int32_t x = 2 * static_cast<std::int32_t>(place.i) - n,
                       y = 2 * static_cast<std::int32_t>(place.j) - n;
    // The one vertex in the middle of a grid lies in all directions; any will do.
    const std::int32_t side = std::max(std::abs(x), std::abs(y));
    const float across = side == 0 ? 1.0F : static_cast<float>(x) / static_cast<float>(side);
    const float along = side == 0 ? 0.0F : static_cast<float>(y) / static_cast<float>(side);
    const auto [position, normal] = point_of_ring(sections_[place.section], across, along);
    batch.local.x[i] = position[0], batch.local.y[i] = position[1], batch.local.z[i] = position[2];
    batch.normal.x[i] = normal[0], batch.normal.y[i] = normal[1], batch.normal.z[i] = normal[2];
    for (std::size_t axis = 0; axis < 3; ++axis)
      batch.position[axis][i] = static_cast<double>(position[axis]);
  }
}

// Vertical folds of the robe, bent and deepened by noise; 24 of them around, deep at the hem, shallow above
// the waist.
void StatueSurface::add_folds(const PointBatch& local, std::size_t count, Lane& height) const {
  Lane phase{}, depth{};
  add_noise(fold_warp_, local, count, phase);
  add_noise(fold_depth_, local, count, depth);
  for (std::size_t i = 0; i < count; ++i) {
    const float x = local.x[i], y = local.y[i], z = local.z[i];
    // The direction as a number in [0, 4), in proportion to |x| and |y|.
    const float slant = y / (std::abs(x) + std::abs(y) + 1e-3F);
    const float direction = x >= 0.0F ? 1.0F + slant : 3.0F - slant;
    const float turns = 64.0F + 6.0F * direction + phase[i];
    const float t = turns - static_cast<float>(static_cast<std::int32_t>(turns)) - 0.5F;
    const float wave = t * (8.0F - 16.0F * std::abs(t));
    const float skirt = smooth_step((z - 290.0F) / 60.0F) * smooth_step((1240.0F - z) / 500.0F);
    const float bodice = smooth_step((z - 1180.0F) / 120.0F) * smooth_step((1600.0F - z) / 120.0F);
    height[i] += wave * (8.0F * skirt + 2.5F * bodice) * (0.75F + depth[i]);
  }
}

void StatueSurface::add_carving(const PointBatch& local, std::size_t count, Lane& height) const {
  float lowest = local.z[0], highest = local.z[0];
  for (std::size_t i = 1; i < count; ++i) {
    lowest = std::min(lowest, local.z[i]);
    highest = std::max(highest, local.z[i]);
  }
  // What is skipped here would add nothing, so that batches do not show in the result.
  if (highest > 290.0F && lowest < 1600.0F) add_folds(local, count, height);
  for (const Capsule& capsule : kCapsules) {
    const float radius = capsule.radius;
    if (std::max(capsule.from[2], capsule.to[2]) + radius < lowest) continue;
    if (std::min(capsule.from[2], capsule.to[2]) - radius > highest) continue;
    const float ax = capsule.from[0], ay = capsule.from[1], az = capsule.from[2];
    const float ex = capsule.to[0] - ax, ey = capsule.to[1] - ay, ez = capsule.to[2] - az;
    const float per_length = 1.0F / (ex * ex + ey * ey + ez * ez), per_radius = 1.0F / (radius * radius);
    for (std::size_t i = 0; i < count; ++i) {
      const float px = local.x[i] - ax, py = local.y[i] - ay, pz = local.z[i] - az;
      const float along = std::min(std::max((px * ex + py * ey + pz * ez) * per_length, 0.0F), 1.0F);
      const float dx = px - along * ex, dy = py - along * ey, dz = pz - along * ez;
      const float inside = std::max(1.0F - (dx * dx + dy * dy + dz * dz) * per_radius, 0.0F);
      height[i] += capsule.height * inside * inside;
    }
  }
}

}  // namespace

std::unique_ptr<SynthSurface> make_statue_surface(std::uint64_t triangles, std::uint64_t seed) {
  return std::make_unique<StatueSurface>(triangles, seed);
}

}  // namespace colossus::synth
