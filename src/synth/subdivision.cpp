#include "synth/subdivision.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "core/hash.hpp"
#include "synth/surface.hpp"

namespace colossus::synth {
namespace {

using namespace synth_points;
using Triangle = std::array<std::uint32_t, 3>;

std::uint32_t narrow(std::uint64_t value) { return static_cast<std::uint32_t>(value); }

// The largest integer whose square is at most `value`, for values up to 2^50.
std::uint64_t integer_root(std::uint64_t value) {
  auto root = static_cast<std::uint64_t>(std::sqrt(static_cast<double>(value)));
  while (root * root > value) --root;
  while ((root + 1) * (root + 1) <= value) ++root;
  return root;
}

// Row r of a triangle of rows of 1, 2, 3... begins at number r * (r + 1) / 2.
std::uint64_t row_begin(std::uint64_t row) { return row * (row + 1) / 2; }

std::uint64_t inside_count(std::uint64_t segments) { return segments > 2 ? row_begin(segments - 2) : 0; }

// The i with begins[i] <= value < begins[i + 1], for ascending `begins` of which several may be equal. Costs
// the logarithm of the distance, if it lies after `near`.
std::uint32_t find_range(const std::vector<std::uint32_t>& begins, std::uint32_t value, std::size_t near) {
  std::size_t low = begins[near] <= value ? near : 0, stride = 1;
  for (; low + stride < begins.size() && begins[low + stride] <= value; stride *= 2) low += stride;
  const auto from = begins.begin() + static_cast<std::ptrdiff_t>(low),
             end = begins.begin() + static_cast<std::ptrdiff_t>(std::min(low + stride, begins.size()));
  return narrow(std::upper_bound(from, end, value) - begins.begin() - 1);
}

// The triangles, largest first. Being cut finer, the largest come nearer to the others, so that edges become
// more even in length, where triangles taken from all sizes would spread them. Scans have large triangles all
// over, so the fine ones are too; where all are of one size, the hash spreads them as well.
std::vector<std::uint32_t> largest_first(const WeldedBase& mesh) {
  std::vector<std::uint32_t> order(mesh.triangles.size());
  std::vector<double> areas(order.size());
  for (std::uint32_t t = 0; t < order.size(); ++t) {
    const Triangle& corners = mesh.triangles[t];
    const Point& a = mesh.positions[corners[0]];
    const Point area = cross(mesh.positions[corners[1]] - a, mesh.positions[corners[2]] - a);
    const double squared = dot(area, area);
    areas[t] = std::isfinite(squared) ? squared : std::numeric_limits<double>::infinity();
    order[t] = t;
  }
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return areas[a] != areas[b] ? areas[a] > areas[b] : core::mix64(a) < core::mix64(b);
  });
  return order;
}

// A place in a grid by row from the first corner and column from the side of the second.
struct GridPlace {
  std::uint64_t row, column;
};

// The corners of a part of a grid of triangles. Row r has 2 r + 1 parts and begins at part r * r.
std::array<GridPlace, 3> grid_part(std::uint64_t index) {
  const std::uint64_t row = integer_root(index), across = index - row * row, column = across / 2;
  if (across % 2 == 0) return {{{row, column}, {row + 1, column}, {row + 1, column + 1}}};
  return {{{row, column}, {row + 1, column + 1}, {row, column + 1}}};
}

}  // namespace

SynthSubdivision::SynthSubdivision(const WeldedBase& mesh, std::uint64_t triangles, const std::string& name)
    : mesh_(mesh) {
  const std::uint64_t faces = mesh.triangles.size();
  k_ = std::max<std::uint64_t>(1, integer_root(triangles / faces));
  const std::uint64_t all_coarse = k_ * k_ * faces;
  number(choose(triangles > all_coarse ? triangles - all_coarse : 0), triangles, name);
}

// Each side of a long edge is a triangle more, and a fine triangle 2 k - 2 beyond its three long edges, so
// what a triangle gains by becoming fine depends on the edges that others have made long already.
SynthSubdivision::Choice SynthSubdivision::choose(std::uint64_t missing) const {
  Choice choice{std::vector<bool>(mesh_.edges.size()), std::vector<bool>(mesh_.triangles.size())};
  if (missing == 0) return choice;
  std::vector<std::uint32_t> sides(mesh_.edges.size());
  for (const Triangle& edges : mesh_.triangle_edges)
    for (const std::uint32_t e : edges) ++sides[e];
  const auto gain = [&](std::uint32_t t) {
    std::uint64_t sum = 2 * k_ - 2;
    for (const std::uint32_t e : mesh_.triangle_edges[t]) sum += choice.is_long[e] ? 0 : sides[e];
    return sum;
  };
  const auto refine = [&](std::uint32_t t) {
    choice.is_fine[t] = true;
    for (const std::uint32_t e : mesh_.triangle_edges[t]) choice.is_long[e] = true;
  };
  for (const std::uint32_t t : largest_first(mesh_)) {
    const std::uint64_t gained = gain(t);
    if (gained > missing) continue;
    missing -= gained;
    refine(t);
  }
  for (std::size_t e = 0; e < sides.size() && missing > 0; ++e) {
    if (choice.is_long[e] || sides[e] > missing) continue;
    missing -= sides[e];
    choice.is_long[e] = true;
  }
  // One too many may be nearer. Triangles that are not fine gain more than is missing, unless k is 1 and they
  // have become so by their edges.
  std::uint32_t least = 0;
  std::uint64_t least_gain = 2 * missing;
  for (std::uint32_t t = 0; t < choice.is_fine.size() && missing > 1; ++t) {
    if (choice.is_fine[t] || gain(t) <= missing || gain(t) >= least_gain) continue;
    least = t;
    least_gain = gain(t);
  }
  if (least_gain < 2 * missing) refine(least);
  return choice;
}

void SynthSubdivision::number(const Choice& choice, std::uint64_t wanted, const std::string& name) {
  const std::uint64_t k = k_, faces = mesh_.triangles.size();
  std::uint64_t fine = 0, longs = 0;
  for (const bool is_fine : choice.is_fine) fine += is_fine;
  for (const bool is_long : choice.is_long) longs += is_long;
  vertex_count_ = mesh_.positions.size() + mesh_.edges.size() * (k - 1) + longs +
                  (faces - fine) * inside_count(k) + fine * inside_count(k + 1);
  if (vertex_count_ > kMaxSynthVertices)
    core::fail(core::Status::kUsage, "synth: {} triangles on {} need {} vertices; at most {} are supported",
               wanted, name, vertex_count_, kMaxSynthVertices);
  std::uint64_t vertex = mesh_.positions.size(), part = 0;
  first_on_edge_.reserve(mesh_.edges.size() + 1);
  first_inside_.reserve(faces + 1);
  first_part_.reserve(faces + 1);
  for (const bool is_long : choice.is_long) {
    first_on_edge_.push_back(narrow(vertex));
    vertex += is_long ? k : k - 1;
  }
  first_on_edge_.push_back(narrow(vertex));
  for (std::size_t t = 0; t < faces; ++t) {
    first_inside_.push_back(narrow(vertex));
    first_part_.push_back(part);
    vertex += inside_count(choice.is_fine[t] ? k + 1 : k);
    part += choice.is_fine[t] ? (k + 1) * (k + 1) : k * k;
    if (choice.is_fine[t]) continue;
    for (const std::uint32_t e : mesh_.triangle_edges[t]) part += choice.is_long[e];
  }
  first_inside_.push_back(narrow(vertex));
  first_part_.push_back(part);
  shift_ = static_cast<unsigned>(std::bit_width(k * k)) - 1;
  triangle_of_part_.reserve((part >> shift_) + 1);
  for (std::uint32_t t = 0; t < faces; ++t)
    while (triangle_of_part_.size() << shift_ < first_part_[t + 1]) triangle_of_part_.push_back(t);
}

SynthSubdivision::OnEdge SynthSubdivision::on_edge(std::uint32_t vertex, std::uint32_t& near) const {
  near = find_range(first_on_edge_, vertex, near);
  const std::uint32_t first = first_on_edge_[near];
  return {near, vertex - first + 1, first_on_edge_[near + 1] - first + 1};
}

SynthSubdivision::Inside SynthSubdivision::inside(std::uint32_t vertex, std::uint32_t& near) const {
  near = find_range(first_inside_, vertex, near);
  const std::uint64_t first = first_inside_[near], index = vertex - first;
  const bool is_fine = first_inside_[near + 1] - first != inside_count(k_);
  const std::uint64_t row = (integer_root(8 * index + 1) - 1) / 2;
  return {near, narrow(row + 2), narrow(index - row_begin(row) + 1), narrow(is_fine ? k_ + 1 : k_)};
}

SynthSubdivision::Frame SynthSubdivision::frame_of(std::uint64_t triangle) const {
  Frame frame{};
  frame.corners = mesh_.triangles[triangle];
  for (std::size_t i = 0; i < 3; ++i) {
    const std::uint32_t e = mesh_.triangle_edges[triangle][i];
    frame.first_on_edge[i] = first_on_edge_[e];
    frame.segments[i] = first_on_edge_[e + 1] - first_on_edge_[e] + 1;
    frame.ascends[i] = frame.corners[i] < frame.corners[(i + 1) % 3];
  }
  frame.first_inside = first_inside_[triangle];
  frame.parts = first_part_[triangle + 1] - first_part_[triangle];
  return frame;
}

std::uint32_t SynthSubdivision::Frame::vertex_on_side(std::size_t side, std::uint64_t step) const {
  if (step == 0) return corners[side];
  if (step == segments[side]) return corners[(side + 1) % 3];
  return narrow(first_on_edge[side] + (ascends[side] ? step : segments[side] - step) - 1);
}

std::uint32_t SynthSubdivision::Frame::vertex_inside(std::uint64_t row, std::uint64_t column) const {
  return narrow(first_inside + row_begin(row - 2) + column - 1);
}

Triangle SynthSubdivision::part(const Frame& frame, std::uint64_t index) const {
  const std::uint64_t segments = frame.parts == k_ * k_ ? k_ : k_ + 1;
  if (frame.parts != segments * segments) return mixed_part(frame, index);
  Triangle corners{};
  const auto places = grid_part(index);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto [row, column] = places[i];
    if (column == 0)
      corners[i] = frame.vertex_on_side(0, row);
    else if (row == segments)
      corners[i] = frame.vertex_on_side(1, column);
    else if (column == row)
      corners[i] = frame.vertex_on_side(2, segments - row);
    else
      corners[i] = frame.vertex_inside(row, column);
  }
  return corners;
}

// One to three long edges around the inner vertices of k x k. The parts: the grid that the inner vertices
// span; at each corner, what it forms with its two neighbours, and these with the inner vertex next to it;
// along each side, what is left: a strip.
Triangle SynthSubdivision::mixed_part(const Frame& frame, std::uint64_t index) const {
  if (k_ < 3) return small_part(frame, index);
  const std::uint64_t inner = k_ - 3;
  if (index < inner * inner) {
    Triangle corners{};
    const auto places = grid_part(index);
    for (std::size_t i = 0; i < 3; ++i)
      corners[i] = frame.vertex_inside(places[i].row + 2, places[i].column + 1);
    return corners;
  }
  index -= inner * inner;
  if (index < 6) {
    const std::size_t corner = index % 3, before = (corner + 2) % 3;
    const std::uint32_t next = frame.vertex_on_side(corner, 1),
                        previous = frame.vertex_on_side(before, frame.segments[before] - 1);
    if (index < 3) return {frame.corners[corner], next, previous};
    const std::array<GridPlace, 3> innermost = {{{2, 1}, {k_ - 1, 1}, {k_ - 1, k_ - 2}}};
    return {next, frame.vertex_inside(innermost[corner].row, innermost[corner].column), previous};
  }
  index -= 6;
  std::size_t side = 0;
  for (; index >= frame.segments[side] - 2 + inner; ++side) index -= frame.segments[side] - 2 + inner;
  return strip_part(frame, side, index);
}

// A strip between k - 2 or k - 1 segments of a side and the k - 3 of the inner vertices next to it, of
// triangles that stand on the side and on the inner segments in turn; the surplus one of a long edge stands
// on the middle. Whatever the lengths of the segments, a strip between two lines has no fold.
Triangle SynthSubdivision::strip_part(const Frame& frame, std::size_t side, std::uint64_t index) const {
  const std::uint64_t surplus_at = 2 * ((k_ - 3) / 2) + 1;
  const bool is_long = frame.segments[side] > k_, is_surplus = is_long && index == surplus_at;
  const std::uint64_t shift = is_long && index >= surplus_at ? 1 : 0;
  const std::uint64_t turn = index - shift;  // as if the surplus one were not there
  const std::uint64_t outer = (turn + 1) / 2 + shift, inner = turn / 2;
  const auto inner_vertex = [&](std::uint64_t step) {
    std::array<std::uint64_t, 3> weights{};
    weights[side] = k_ - 2 - step;
    weights[(side + 1) % 3] = 1 + step;
    weights[(side + 2) % 3] = 1;
    return frame.vertex_inside(k_ - weights[0], weights[2]);
  };
  const std::uint32_t begin = frame.vertex_on_side(side, outer + 1);
  if (is_surplus || turn % 2 == 0) return {begin, frame.vertex_on_side(side, outer + 2), inner_vertex(inner)};
  return {begin, inner_vertex(inner + 1), inner_vertex(inner)};
}

// Without inner vertices, k being 1 or 2: a fan around the first vertex on the first long edge. With k = 2
// the corners are cut off before, which leaves better angles.
Triangle SynthSubdivision::small_part(const Frame& frame, std::uint64_t index) const {
  if (k_ == 2 && index < 3) {
    const std::size_t before = (index + 2) % 3;
    return {frame.corners[index], frame.vertex_on_side(index, 1),
            frame.vertex_on_side(before, frame.segments[before] - 1)};
  }
  if (k_ == 2) index -= 3;
  std::array<std::uint32_t, 6> around{};
  std::size_t size = 0, first_side = 0;
  while (frame.segments[first_side] == k_) ++first_side;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t side = (first_side + i) % 3;
    for (std::uint64_t step = 1; step < frame.segments[side]; ++step)
      around[size++] = frame.vertex_on_side(side, step);
    if (k_ == 1) around[size++] = frame.corners[(side + 1) % 3];
  }
  return {around[0], around[index + 1], around[index + 2]};
}

std::uint64_t SynthSubdivision::triangle_of(std::uint64_t part) const {
  const std::uint64_t triangle = triangle_of_part_[part >> shift_];
  return first_part_[triangle + 1] <= part ? triangle + 1 : triangle;
}

void SynthSubdivision::triangles(std::uint64_t first, std::span<Triangle> corners) const {
  if (corners.empty()) return;
  std::uint64_t triangle = triangle_of(first);
  Frame frame = frame_of(triangle);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (first + i == first_part_[triangle + 1]) frame = frame_of(++triangle);
    corners[i] = part(frame, first + i - first_part_[triangle]);
  }
}

void SynthSubdivision::triangles_at(std::span<const std::uint64_t> numbers,
                                    std::span<Triangle> corners) const {
  Frame frame{};
  std::uint64_t first = 0;  // part of the frame's triangle, which has none at the beginning
  for (std::size_t i = 0; i < corners.size(); ++i) {
    // Wraps around where the number is below the first.
    if (numbers[i] - first >= frame.parts) {
      const std::uint64_t triangle = triangle_of(numbers[i]);
      frame = frame_of(triangle);
      first = first_part_[triangle];
    }
    corners[i] = part(frame, numbers[i] - first);
  }
}

}  // namespace colossus::synth
