#include "verify/measure/input_check.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/error.hpp"
#include "core/hash.hpp"
#include "geometry/lattice.hpp"
#include "reader/access/parallel.hpp"
#include "verify/measure/finest.hpp"

namespace colossus::verify::measure {
namespace {

constexpr std::size_t kSamplesPerTask = std::size_t{1} << 12;
constexpr double kAreaShare = 1e-3;  // by which areas may differ in any case

double root_side(const container::LatticeInfo& lattice) {
  return std::ldexp(lattice.step, lattice.root_bits);
}

// The larger of the root cube and the input, since a foreign input may be anything. What no triangle uses,
// such as a marker at 1e300, must not make all that is used vanish.
Scale scale_for(const reader::access::Statue& statue, const Surface& raw) {
  geometry::Bounds bounds;
  for (const mesh::Triangle& t : raw.triangles)
    for (const auto v : t) bounds.add(raw.points[v]);
  double half = root_side(statue.metadata().lattice) / 2.0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    half = std::max(half, bounds.high[axis] / 2.0 - bounds.low[axis] / 2.0);
  return Scale(half);
}

std::vector<WorldPoint> scaled_points(const Scale& scale, std::span<const WorldPoint> points) {
  std::vector<WorldPoint> result;
  result.reserve(points.size());
  for (const WorldPoint& p : points) result.push_back(scale.scaled(p));
  return result;
}

double length(const WorldPoint& a, const WorldPoint& b) {
  return std::sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) +
                   (a[2] - b[2]) * (a[2] - b[2]));
}

double triangle_area(const WorldPoint& a, const WorldPoint& b, const WorldPoint& c) {
  const WorldPoint u{b[0] - a[0], b[1] - a[1], b[2] - a[2]};
  const WorldPoint v{c[0] - a[0], c[1] - a[1], c[2] - a[2]};
  const double x = u[1] * v[2] - u[2] * v[1];
  const double y = u[2] * v[0] - u[0] * v[2];
  const double z = u[0] * v[1] - u[1] * v[0];
  return std::sqrt(x * x + y * y + z * z) / 2.0;
}

// The middle of each triangle, of a hole that is farthest from the border; and half as many others, of which
// half are vertices, where spikes end.
std::vector<WorldPoint> finest_samples(const Surface& surface, std::size_t least, std::uint64_t seed) {
  std::vector<WorldPoint> samples;
  samples.reserve(surface.triangles.size());
  for (const mesh::Triangle& t : surface.triangles) {
    WorldPoint p{};
    for (std::size_t axis = 0; axis < 3; ++axis)
      p[axis] = (surface.points[t[0]][axis] + surface.points[t[1]][axis] + surface.points[t[2]][axis]) / 3.0;
    samples.push_back(p);
  }
  const std::vector<WorldPoint> others =
      sample_surface(surface, std::max(least, surface.triangles.size() / 2), seed);
  samples.insert(samples.end(), others.begin(), others.end());
  return samples;
}

struct MeasuredSample {
  WorldPoint at{};  // in the world
  double distance = 0.0;
  reader::access::RowIndex nearest = reader::access::kNoRow;
  HeldError held;
  bool is_exact = false;  // else the distance is a larger one where the error allows it
};

// The samples for which the error of one node holds and is exceeded.
struct Excess {
  std::uint64_t samples = 0;
  double distance = 0.0;  // the greatest
  WorldPoint farthest{};
  void add(const Excess& other) {
    samples += other.samples;
    if (!(other.distance > distance)) return;
    distance = other.distance;
    farthest = other.farthest;
  }
};

// Of some of the samples of a level, or of all.
struct TaskResult {
  double greatest_ratio = 0.0;
  std::map<reader::access::RowIndex, double>
      distances;  // the greatest from what a node stands for, or is nearest to
  std::map<reader::access::RowIndex, Excess> excesses;

  void add(const reader::access::Statue& statue, const MeasuredSample& sample) {
    const double error = sample.held.error;
    const bool exceeds = !is_within(statue, sample.distance, error);
    if (sample.is_exact)
      for (const reader::access::RowIndex row : {sample.nearest, sample.held.row})
        if (row != reader::access::kNoRow) distances[row] = std::max(distances[row], sample.distance);
    if (!sample.held.is_known) return;
    if (error > 0.0 && (sample.is_exact || exceeds))
      greatest_ratio = std::max(greatest_ratio, sample.distance / error);
    if (exceeds) excesses[sample.held.row].add({1, sample.distance, sample.at});
  }
  void add(const TaskResult& other) {
    greatest_ratio = std::max(greatest_ratio, other.greatest_ratio);
    for (const auto& [row, distance] : other.distances) {
      double& of_row = distances[row];
      of_row = std::max(of_row, distance);
    }
    for (const auto& [row, excess] : other.excesses) excesses[row].add(excess);
  }
};

Finding finding_of(const reader::access::Statue& statue, std::uint32_t level, reader::access::RowIndex row,
                   const Excess& excess) {
  const std::string node = row == reader::access::kNoRow
                               ? "no node stands for"
                               : fmt::format("the node at {} stands for, which stores an error of {}",
                                             statue.name(row), statue.rows()[row].error);
  const WorldPoint& p = excess.farthest;
  return {
      FindingKind::kInputDistance,
      fmt::format("level {}: {} samples of the input are too far from it, the farthest at {} {} {} by {}: "
                  "of a part that {}",
                  level, excess.samples, p[0], p[1], p[2], excess.distance, node)};
}

}  // namespace

Input::Input(const reader::access::Statue& statue, const Surface& raw)
    : statue_(statue),
      raw_(raw),
      scale_(scale_for(statue, raw)),
      points_(scaled_points(scale_, raw.points)),
      index_({points_, raw.triangles}) {
  const auto is_degenerate = [&](const mesh::Triangle& t) {
    return raw_.points[t[0]] == raw_.points[t[1]] || raw_.points[t[1]] == raw_.points[t[2]] ||
           raw_.points[t[2]] == raw_.points[t[0]];
  };
  has_degenerate_ = std::any_of(raw_.triangles.begin(), raw_.triangles.end(), is_degenerate);
  if (has_degenerate_)
    std::remove_copy_if(raw_.triangles.begin(), raw_.triangles.end(), std::back_inserter(kept_),
                        is_degenerate);
}

// Of kept(): the first of those with the same three corners, in whatever order.
std::vector<std::uint32_t> Input::distinct_triangles() const {
  const std::span<const mesh::Triangle> triangles = kept().triangles;
  std::vector<std::pair<core::Hash128, std::uint32_t>> keys;
  keys.reserve(triangles.size());
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    std::array<WorldPoint, 3> corners{};
    for (std::size_t k = 0; k < 3; ++k) {
      corners[k] = raw_.points[triangles[i][k]];
      for (double& c : corners[k]) c += 0.0;  // turns a negative zero into a positive one
    }
    std::sort(corners.begin(), corners.end());
    keys.emplace_back(core::hash128(std::as_bytes(std::span(corners))), i);
  }
  std::sort(keys.begin(), keys.end());
  std::vector<std::uint32_t> distinct;
  for (std::size_t i = 0; i < keys.size(); ++i)
    if (i == 0 || keys[i].first != keys[i - 1].first) distinct.push_back(keys[i].second);
  std::sort(distinct.begin(), distinct.end());
  return distinct;
}

void Input::compare(FindingLog& log) const {
  compare_counts(log);
  compare_bounds(log);
  compare_area(log);
}

void Input::compare_counts(FindingLog& log) const {
  const auto check = [&](const char* name, std::size_t found) {
    if (const auto stored = statue_.count_of(name); stored && *stored != found)
      log.add({FindingKind::kCount,
               fmt::format("the container was built of {} {}, the input has {}", *stored, name, found)});
  };
  check("vertices", raw_.points.size());
  check("triangles", raw_.triangles.size());
}

void Input::compare_bounds(FindingLog& log) const {
  const auto stored = stored_bounds(statue_);
  if (!stored) return;
  const auto bounds_of = [&](std::span<const mesh::Triangle> triangles) {
    geometry::Bounds bounds;
    for (const mesh::Triangle& t : triangles)
      for (const std::uint32_t v : t) bounds.add(raw_.points[v]);
    return bounds;
  };
  // A vertex that only degenerate triangles use may count or not.
  const geometry::Bounds bounds = bounds_of(raw_.triangles);
  const geometry::Bounds kept = has_degenerate_ ? bounds_of(kept_) : bounds;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const bool is_low = stored->low[axis] == bounds.low[axis] || stored->low[axis] == kept.low[axis];
    const bool is_high = stored->high[axis] == bounds.high[axis] || stored->high[axis] == kept.high[axis];
    if (is_low && is_high) continue;
    log.add({FindingKind::kBounds,
             fmt::format("the container was built of a statue from {} to {} on axis {}, the input reaches "
                         "from {} to {}",
                         stored->low[axis], stored->high[axis], "xyz"[axis], bounds.low[axis],
                         bounds.high[axis])});
  }
}

void Input::compare_area(FindingLog& log) const {
  const auto stored = statue_.measure_of("input_area");
  if (!stored) return;
  const container::LatticeInfo& lattice = statue_.metadata().lattice;
  // To the builder's lattice, and from there to the container's.
  const double moved = scale_.scaled(statue_.lattice_error()) +
                       scale_.scaled(std::ldexp(geometry::Lattice{{}, lattice.step}.input_error(),
                                                lattice.root_bits - geometry::kRootBits));
  double area = 0.0;
  double allowed = 0.0;
  const Surface surface = kept();
  for (const std::uint32_t i : distinct_triangles()) {
    const mesh::Triangle& t = surface.triangles[i];
    const WorldPoint& a = points_[t[0]];
    const WorldPoint& b = points_[t[1]];
    const WorldPoint& c = points_[t[2]];
    area += triangle_area(a, b, c);
    // No triangle's area changes by more when its corners move so far.
    allowed += moved * (length(a, b) + length(b, c) + length(c, a)) / 2.0 + 3.0 * moved * moved;
  }
  const double step = scale_.scaled(lattice.step);
  const double expected = *stored * step * step;
  if (std::abs(area - expected) <= std::max(allowed, kAreaShare * area)) return;
  log.add({FindingKind::kArea,
           fmt::format("the container was built of a surface of {} times that of the input, which differs by "
                       "more than the lattice explains",
                       expected / area)});
}

SurfaceIndex::Nearest world_distance(const Scale& scale, const SurfaceIndex& index, const WorldPoint& p,
                                     std::uint32_t near, double enough) {
  SurfaceIndex::Nearest found = index.nearest(p, near, scale.scaled(enough));
  found.distance = scale.world(found.distance);
  return found;
}

void measure_from_input(const reader::access::Statue& statue, const Input& input, const LevelSurface& level,
                        const LevelMeasure& measure, const std::function<HeldError(const WorldPoint&)>& held,
                        FindingLog& log, std::vector<double>& greatest) {
  if (level.is_empty()) {
    if (!measure.has_damage)
      log.add({FindingKind::kInputDistance, fmt::format("level {} has no triangles", measure.level)});
    return;
  }
  const SurfaceIndex index(level.surface());
  const std::size_t triangles = level.surface().triangles.size();
  const std::vector<WorldPoint> samples =
      measure.is_finest
          ? finest_samples(input.kept(), measure.exact_samples, measure.seed)
          : sample_surface(input.kept(), std::max(measure.exact_samples, triangles), measure.seed);
  const std::size_t stride =
      std::max<std::size_t>(1, samples.size() / std::max<std::size_t>(1, measure.exact_samples));
  std::vector<TaskResult> results((samples.size() + kSamplesPerTask - 1) / kSamplesPerTask);
  reader::access::parallel_for(results.size(), [&](std::size_t task) {
    TaskResult& result = results[task];
    std::uint32_t near = 0;
    const std::size_t end = std::min(samples.size(), (task + 1) * kSamplesPerTask);
    for (std::size_t i = task * kSamplesPerTask; i < end; ++i) {
      const WorldPoint p = input.scale().world(samples[i]);
      const HeldError at = held(p);
      const bool is_exact =
          i % stride == 0 || (at.row != reader::access::kNoRow && at.error > kLooseFactor * greatest[at.row]);
      const auto nearest = world_distance(input.scale(), index, samples[i], near, is_exact ? 0.0 : at.error);
      near = nearest.triangle;
      result.add(statue,
                 {p, nearest.distance, is_exact ? level.row_of(near) : reader::access::kNoRow, at, is_exact});
    }
  });
  TaskResult all;
  for (const TaskResult& result : results) all.add(result);
  for (const auto& [row, distance] : all.distances) greatest[row] = std::max(greatest[row], distance);
  log.add_input_measure(samples.size(), all.greatest_ratio);
  for (const auto& [row, excess] : all.excesses) log.add(finding_of(statue, measure.level, row, excess));
}

std::uint64_t seed_of(const container::NodeRow& row, std::uint64_t seed) {
  return seed ^ geometry::PointHash{}({row.center[0], row.center[1], row.center[2]});
}

PartMeasure measure_part(const Input& input, const Surface& part, std::size_t samples, std::uint64_t seed) {
  PartMeasure measured;
  std::uint32_t near = 0;
  for (const WorldPoint& p : sample_surface(part, samples, seed)) {
    const auto found = world_distance(input.scale(), input.index(), p, near);
    near = found.triangle;
    ++measured.samples;
    if (!(found.distance > measured.greatest)) continue;
    measured.greatest = found.distance;
    measured.farthest = input.scale().world(p);
  }
  return measured;
}

void count_loose(
    const reader::access::Statue& statue, std::vector<double>& greatest, const std::vector<bool>& is_damaged,
    const std::function<std::vector<reader::access::RowIndex>(reader::access::RowIndex)>& parents,
    const std::function<double(reader::access::RowIndex)>& resolution, VerifyReport& report,
    FindingLog& log) {
  std::vector<bool> is_unknown = is_damaged;
  for (auto row = static_cast<reader::access::RowIndex>(greatest.size()); row-- > 0;) {
    for (const reader::access::RowIndex parent : parents(row)) {
      greatest[parent] = std::max(greatest[parent], greatest[row]);
      is_unknown[parent] = is_unknown[parent] || is_unknown[row];
    }
    const double error = statue.rows()[row].error;
    if (!(error > statue.lattice_error()) || is_unknown[row]) continue;
    ++report.measured_nodes;
    if (error > kLooseFactor * std::max(greatest[row], resolution(row))) ++report.loose_nodes;
  }
  log.check_looseness();
}

}  // namespace colossus::verify::measure
