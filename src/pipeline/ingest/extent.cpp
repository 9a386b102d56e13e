#include "pipeline/ingest/extent.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>

#include "core/log.hpp"
#include "pipeline/run/phase.hpp"

namespace colossus::pipeline::ingest {
namespace {

using core::ByteReader;
using core::Bytes;
using core::ByteWriter;
using Position = std::array<double, 3>;

// Beyond this the root cube's corners, or differences of coordinates, would not be doubles any more.
constexpr double kGreatestCoordinate = 0x1p1020;
// How much finer the lattice would have to be for a corner to be called far.
constexpr double kFarFactor = 10.0;
// One vertex in so many need not be among the nearest; of fewer vertices one, if there are some at all.
constexpr std::uint64_t kFarShare = 1000;
constexpr std::uint64_t kLeastVertices = 16;
// Of each range, for the middle and for a first look.
constexpr std::size_t kSamplesPerRange = 256;
constexpr double kSampledShare = 0.9;
// Distances, and lengths of edges, are told apart by exponent and six more bits: to one or two percent.
constexpr int kKeyShift = 46;
constexpr std::uint64_t kMostSampledTriangles = std::uint64_t{1} << 20;

std::uint32_t key_of(double length) {
  return static_cast<std::uint32_t>(std::bit_cast<std::uint64_t>(length) >> kKeyShift);
}

// What the first pass says of a range.
struct RangeExtent {
  std::uint64_t count = 0;
  geometry::Bounds bounds;
  std::vector<Position> samples;
};

// File and vertex of a number over all files.
struct VertexName {
  std::uint32_t file = 0;
  std::uint64_t vertex = 0;
};
VertexName name_of(const facts::Catalog& catalog, std::uint64_t number) {
  const auto& blocks = catalog.vertex_blocks;
  const auto after =
      std::partition_point(blocks.begin(), blocks.end(),
                           [&](const facts::VertexBlockRef& block) { return block.first <= number; });
  const std::uint32_t file = (after - 1)->file;
  const auto first = std::find_if(blocks.begin(), blocks.end(),
                                  [&](const facts::VertexBlockRef& block) { return block.file == file; });
  return {file, number - first->first};
}

// A sum may overflow although the coordinates do not.
void check_finite(const facts::Catalog& catalog, std::uint64_t number, const Position& p) {
  if (std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2])) return;
  const VertexName name = name_of(catalog, number);
  input::fail_position(catalog.files[name.file].name, name.vertex, p);
}

RangeExtent look_at_range(const run::Workspace& workspace, const facts::Catalog& catalog,
                          std::span<const std::byte> task) {
  RangeExtent range;
  std::uint64_t stride = 1;
  visit_requested(workspace, catalog, task, [&](std::uint64_t number, const Position& read) {
    if (!std::isfinite(read[0] + read[1] + read[2])) check_finite(catalog, number, read);
    // + 0.0: of a negative zero and a positive one bounds would keep whichever came first, and ranges come in
    // any order.
    const Position p{read[0] + 0.0, read[1] + 0.0, read[2] + 0.0};
    range.bounds.add(p);
    if (range.count++ % stride != 0) return;
    range.samples.push_back(p);
    if (range.samples.size() < 2 * kSamplesPerRange) return;
    // Every second one, so that they stay spread evenly over what has come so far.
    for (std::size_t i = 0; 2 * i < range.samples.size(); ++i) range.samples[i] = range.samples[2 * i];
    range.samples.resize(kSamplesPerRange);
    stride *= 2;
  });
  return range;
}

// Distances from the middle in units of the extent, so that squares neither overflow nor vanish.
struct Middle {
  Position at{};
  double scale = 1.0;  // a power of two
  double distance(const Position& p) const {
    double sum = 0.0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double d = (p[axis] - at[axis]) * scale;
      sum += d * d;
    }
    return std::sqrt(sum);
  }
};

struct Sample {
  Position at{};
  double weight = 0.0;
};

// The least value up to which `share` of the weight lies. Sorts by `value`.
template <typename Value>
double quantile(std::vector<Sample>& samples, double share, const Value& value) {
  std::stable_sort(samples.begin(), samples.end(),
                   [&](const Sample& a, const Sample& b) { return value(a) < value(b); });
  double whole = 0.0, sum = 0.0;
  for (const Sample& sample : samples) whole += sample.weight;
  for (const Sample& sample : samples)
    if ((sum += sample.weight) >= share * whole) return value(sample);
  return samples.empty() ? 0.0 : value(samples.back());
}

// Vertices by their distance from the middle.
struct Shell {
  std::uint64_t count = 0;
  geometry::Bounds bounds;
};
struct Farthest {
  double distance = -1.0;
  std::uint64_t number = 0;
  Position position{};
};
struct Shells {
  std::map<std::uint32_t, Shell> by_key;
  Farthest farthest;

  void add(std::uint64_t number, const Position& p, double distance) {
    Shell& shell = by_key[key_of(distance)];
    ++shell.count;
    shell.bounds.add(p);
    if (distance > farthest.distance) farthest = {distance, number, p};
  }
  void merge(std::uint32_t key, const Shell& other) {
    Shell& shell = by_key[key];
    shell.count += other.count;
    shell.bounds.merge(other.bounds);
  }
  Bytes to_bytes() const {
    ByteWriter writer;
    writer.put(farthest);
    for (const auto& [key, shell] : by_key) {
      writer.put<std::uint64_t>(key);
      writer.put(shell);
    }
    return writer.take();
  }
};

class ExtentMeasurer {
 public:
  ExtentMeasurer(const run::Workspace& workspace, facts::Catalog& catalog,
                 const std::vector<TriangleGroup>& groups)
      : workspace_(workspace), catalog_(catalog), ranges_(catalog, groups) {}

  void run() {
    look_at_all();
    workspace_.ranks.attempt([&] {
      if (workspace_.ranks.is_root()) check_magnitude();
    });
    std::uint32_t may_be_far = workspace_.ranks.is_root() && find_middle() ? 1 : 0;
    broadcast_value(workspace_.ranks, may_be_far);
    if (may_be_far != 0) find_far_corner();
    broadcast_value(workspace_.ranks, catalog_.bounds);
    broadcast_value(workspace_.ranks, catalog_.far_corner);
  }

 private:
  void look_at_all() {
    // By task, so that the samples have one order.
    std::vector<std::vector<Sample>> samples(ranges_.size());
    run_phase(
        workspace_, "extent", ranges_.size(), [&](std::size_t i) { return ranges_.task(i); },
        [&](std::span<const std::byte> task) {
          const RangeExtent range = look_at_range(workspace_, catalog_, task);
          ByteWriter writer;
          writer.put(range.count);
          writer.put(range.bounds);
          writer.put_array<Position>(range.samples);
          return writer.take();
        },
        [&](std::size_t i, const Bytes& bytes) {
          ByteReader reader(bytes);
          const auto count = reader.get<std::uint64_t>();
          catalog_.bounds.merge(reader.get<geometry::Bounds>());
          const std::size_t sampled = reader.remaining() / sizeof(Position);
          for (const Position& p : reader.get_array<Position>(sampled))
            samples[i].push_back({p, static_cast<double>(count) / static_cast<double>(sampled)});
          used_ += count;
        });
    for (const auto& of_range : samples) samples_.insert(samples_.end(), of_range.begin(), of_range.end());
  }

  void check_magnitude() const {
    const geometry::Bounds& bounds = catalog_.bounds;
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (!(bounds.low[axis] >= -kGreatestCoordinate && bounds.high[axis] <= kGreatestCoordinate))
        core::fail(core::Status::kBadData,
                   "{}: coordinate {} ranges from {} to {}: too large, what is expected are magnitudes of at "
                   "most {}, whose differences are numbers",
                   catalog_.input_name(), "xyz"[axis], bounds.low[axis], bounds.high[axis],
                   kGreatestCoordinate);
  }

  // Whether the samples leave it open that there is a far corner.
  bool find_middle() {
    const double extent = catalog_.bounds.extent();
    if (!(extent > 0.0) || used_ < kLeastVertices) return false;
    for (std::size_t axis = 0; axis < 3; ++axis)
      middle_.at[axis] = quantile(samples_, 0.5, [axis](const Sample& s) { return s.at[axis]; });
    middle_.scale = std::ldexp(1.0, std::clamp(-std::ilogb(extent), -1000, 1000));
    const auto distance = [&](const Sample& s) { return middle_.distance(s.at); };
    const double near = quantile(samples_, kSampledShare, distance);
    geometry::Bounds bounds;
    for (const Sample& sample : samples_)
      if (distance(sample) <= near) bounds.add(sample.at);
    return kFarFactor * bounds.extent() <= extent;
  }

  void find_far_corner() {
    Shells all;
    run_phase(
        workspace_, "far corners", ranges_.size(),
        [&](std::size_t i) {
          ByteWriter writer;
          writer.put(middle_);
          writer.put_bytes(ranges_.task(i));
          return writer.take();
        },
        [&](std::span<const std::byte> task) {
          const auto middle = ByteReader(task).get<Middle>();
          Shells shells;
          visit_requested(
              workspace_, catalog_, task.subspan(sizeof(Middle)),
              [&](std::uint64_t number, const Position& p) { shells.add(number, p, middle.distance(p)); });
          return shells.to_bytes();
        },
        [&](std::size_t, const Bytes& bytes) {
          ByteReader reader(bytes);
          const auto farthest = reader.get<Farthest>();
          // The first one of several that are as far, whichever range answers first.
          if (farthest.distance > all.farthest.distance ||
              (farthest.distance == all.farthest.distance && farthest.number < all.farthest.number))
            all.farthest = farthest;
          while (reader.remaining() > 0) {
            const auto key = static_cast<std::uint32_t>(reader.get<std::uint64_t>());
            all.merge(key, reader.get<Shell>());
          }
        });
    if (workspace_.ranks.is_root()) judge(all);
  }

  void judge(const Shells& shells) {
    const std::uint64_t near = used_ - std::max<std::uint64_t>(used_ / kFarShare, 1);
    facts::FarCorner& corner = catalog_.far_corner;
    std::uint64_t count = 0;
    for (const auto& [key, shell] : shells.by_key) {
      if (count >= near) break;
      count += shell.count;
      corner.core.merge(shell.bounds);
    }
    if (kFarFactor * corner.core.extent() > catalog_.bounds.extent()) return;
    corner.is_far = true;
    corner.position = shells.farthest.position;
    const VertexName name = name_of(catalog_, shells.farthest.number);
    corner.file = name.file;
    corner.vertex = name.vertex;
    const double without =
        corner.core.extent() > 0.0 ? geometry::Lattice::fit(corner.core).input_error() : 0.0;
    core::warn(
        "{}: vertex {}, a corner at {} {} {}, lies far from the rest: {} of {} vertices lie within {} {} {} "
        "to {} {} {}. It makes the lattice coarse: vertices move by up to {}, and without what is so far by "
        "up to {}",
        catalog_.files[corner.file].name, corner.vertex, corner.position[0], corner.position[1],
        corner.position[2], count, used_, corner.core.low[0], corner.core.low[1], corner.core.low[2],
        corner.core.high[0], corner.core.high[1], corner.core.high[2],
        geometry::Lattice::fit(catalog_.bounds).input_error(), without);
  }

  const run::Workspace& workspace_;
  facts::Catalog& catalog_;
  RequestedRanges ranges_;
  // On rank 0:
  std::uint64_t used_ = 0;
  std::vector<Sample> samples_;
  Middle middle_;
};

}  // namespace

void measure_extent(const run::Workspace& workspace, facts::Catalog& catalog,
                    const std::vector<TriangleGroup>& groups) {
  ExtentMeasurer(workspace, catalog, groups).run();
}

void measure_median_edge(const run::Workspace& workspace, facts::Catalog& catalog,
                         std::span<const TriangleGroup> groups) {
  if (!catalog.far_corner.is_far) return;
  const std::uint64_t stride = catalog.counts.triangles / kMostSampledTriangles + 1;
  std::map<std::uint32_t, std::uint64_t> counts;  // by key_of() the length
  run_phase(
      workspace, "edges", groups.size(), [&](std::size_t i) { return group_task(groups[i]); },
      [&](std::span<const std::byte> task) {
        const Piece group = load_group(workspace, catalog, task);
        std::map<std::uint32_t, std::uint64_t> own;
        for (std::size_t i = 0; i < group.triangles.size(); i += stride)
          for (std::size_t k = 0; k < 3; ++k) {
            const std::int64_t squared =
                geometry::squared_distance(group.vertices[group.triangles[i][k]].position,
                                           group.vertices[group.triangles[i][(k + 1) % 3]].position);
            ++own[key_of(std::sqrt(static_cast<double>(squared)))];
          }
        ByteWriter writer;
        for (const auto& [key, count] : own) writer.put(std::array<std::uint64_t, 2>{key, count});
        return writer.take();
      },
      [&](std::size_t, const Bytes& bytes) {
        ByteReader reader(bytes);
        while (reader.remaining() > 0) {
          const auto [key, count] = reader.get<std::array<std::uint64_t, 2>>();
          counts[static_cast<std::uint32_t>(key)] += count;
        }
      });
  std::uint64_t whole = 0, sum = 0;
  for (const auto& [key, count] : counts) whole += count;
  for (const auto& [key, count] : counts) {
    sum += count;
    if (2 * sum < whole) continue;
    catalog.far_corner.median_edge =
        catalog.lattice.step * std::bit_cast<double>(std::uint64_t{key} << kKeyShift);
    break;
  }
  broadcast_value(workspace.ranks, catalog.far_corner);
}

std::string far_corner_text(const facts::Catalog& catalog) {
  const facts::FarCorner& corner = catalog.far_corner;
  if (!corner.is_far) return {};
  return fmt::format(" ({}: vertex {}, a corner at {} {} {}, lies far from the rest)",
                     catalog.files[corner.file].name, corner.vertex, corner.position[0], corner.position[1],
                     corner.position[2]);
}

void refuse_far_corner(const facts::BuildOptions& options, const facts::Catalog& catalog, double apart) {
  const facts::FarCorner& corner = catalog.far_corner;
  if (!corner.is_far || options.keep_outliers || !(apart > corner.median_edge)) return;
  core::fail(
      core::Status::kBadData,
      "{}: vertex {}, a corner at {} {} {}, lies so far from the rest that points up to {} apart may fall "
      "together, more than the median edge of {}: remove the triangles there, or go on with "
      "--keep-outliers",
      catalog.files[corner.file].name, corner.vertex, corner.position[0], corner.position[1],
      corner.position[2], apart, corner.median_edge);
}

}  // namespace colossus::pipeline::ingest
