#include "pipeline/estimate.hpp"

#include <sys/stat.h>
#include <sys/statvfs.h>

#include <algorithm>
#include <cmath>

#include "codec/codec.hpp"
#include "core/log.hpp"
#include "core/place.hpp"
#include "pipeline/ingest/join.hpp"
#include "pipeline/run/memory.hpp"
#include "pipeline/schemes.hpp"
#include "scratch/directory.hpp"

namespace colossus::pipeline {
namespace {

constexpr double kMiB = 1 << 20;

// Where no other source is named, constants are fitted to builds of statues of 0.1 to 6 million triangles, of
// both schemes, with all codecs, at 8 to 16 bits, in the order of space and shuffled (src/README.md).

// What was measured, times this, is estimated: statues differ.
constexpr double kMargin = 1.2;
constexpr double kOutputMargin = 1.28;  // noise counts

// Vertices that an input block has per triangle: where the order is that of space, and where it is shuffled.
constexpr double kVerticesInOrder = 0.7;
constexpr double kVerticesShuffled = 2.9;

// Memory of the tasks that all schemes have, bytes beyond what the program takes after the survey.
constexpr double kBucketBase = 4 * kMiB;
constexpr double kBucketPerTriangle = 110.0;  // of the input, while it is too small to fill a bucket
constexpr double kBucketMost = 31 * kMiB;
constexpr double kRangePerVertex = 43.0;     // of a range of the join
constexpr double kGroupPerTriangle = 150.0;  // of a group of the join, if it is shuffled
// Buckets take so many times as much where corners are vertices of their own: those of faces with colours,
// and those of formats without indices, which are known by their vertices per triangle; with indices it is a
// half.
constexpr double kMoreForFaceColors = 1.6;
constexpr double kMoreForCorners = 1.3;
constexpr double kLeastVerticesOfCorners = 2.0;

// Scratch, bytes. Positions, numbers and polygons are what their records have. Normals and colours are
// fitted, and less than the 6 and 4 that they have on the lattice.
constexpr double kPosition = 12.0;  // on the lattice: three integers of 32 bits
constexpr double kNormal = 4.0;
constexpr double kColor = 3.0;
constexpr double kRawPosition = 24.0;    // as it was read: three doubles
constexpr double kRawNormal = 12.0;      // three floats
constexpr double kIndices = 12.0;        // of a triangle: three numbers of 32 bits
constexpr double kVertexNumber = 4.0;    // within a range
constexpr double kReading = 4.0;         // of the colour of a face, or the other one of any colour
constexpr double kRequestedColor = 5.0;  // of a face of a group
constexpr double kPolygon = sizeof(input::Polygon);
constexpr double kPieceTriangle = 6.0;
constexpr double kPieceVertex = 8.0;  // beside the vertex itself: its number over all files

// Vertices of a group are so many times those of the input, and those of its pieces so many times as many
// again: what lies on a border is there more than once. In a shuffled file a triangle of a piece has three.
constexpr double kGroupBorders = 1.05;
constexpr double kPieceBorders = 1.15;
constexpr double kCornersPerTriangle = 3.0;

// The output, bytes: all that is no node; and what borders add to each triangle of a node, over the square
// root of how many it has.
constexpr double kContainerBase = 10000.0;
constexpr double kBorder = 45.0;

// How much of the triangles' order is without locality, from the vertices that an input block has per
// triangle.
double far_share(double vertices_per_triangle) {
  return std::clamp((vertices_per_triangle - kVerticesInOrder) / (kVerticesShuffled - kVerticesInOrder), 0.0,
                    1.0);
}

class Estimator {
 public:
  Estimator(const facts::BuildOptions& options, const facts::Catalog& catalog,
            const ingest::Occupancy& occupancy)
      : options_(options),
        catalog_(catalog),
        needs_(scheme_named(options.scheme).estimate(options, catalog, occupancy)),
        triangles_(static_cast<double>(catalog.counts.triangles)),
        vertices_(static_cast<double>(catalog.counts.vertices)),
        group_(static_cast<double>(ingest::group_size(catalog))),
        far_share_(far_share(static_cast<double>(catalog.input_block_vertices) / triangles_)) {}

  run::BuildEstimate run(std::uint64_t resident_bytes) const {
    run::BuildEstimate needs;
    needs.memory_bytes_per_rank = resident_bytes + static_cast<std::uint64_t>(task_memory());
    needs.scratch_bytes = static_cast<std::uint64_t>(kMargin * scratch());
    needs.output_bytes = static_cast<std::uint64_t>(kOutputMargin * output());
    return needs;
  }

 private:
  // How many vertices a group of the join has per triangle, when it is shuffled.
  double far_vertices_per_triangle() const {
    return vertices_ / group_ * (1.0 - std::exp(-kCornersPerTriangle * group_ / std::max(vertices_, 1.0)));
  }

  // Beyond what the program takes after the survey.
  double task_memory() const {
    const double more = catalog_.has_face_colors                           ? kMoreForFaceColors
                        : vertices_ > kLeastVerticesOfCorners * triangles_ ? kMoreForCorners
                                                                           : 1.0;
    const double buckets = more * std::min(kBucketMost, kBucketBase + kBucketPerTriangle * triangles_);
    const double range = kRangePerVertex * static_cast<double>(ingest::range_size(catalog_));
    const double groups = far_share_ * kGroupPerTriangle * std::min(group_, triangles_);
    return std::max({buckets, range, groups, needs_.task_bytes});
  }

  // At the end of the phases that hold most.
  double scratch() const {
    const double vertex =
        kPosition + (catalog_.has_normals ? kNormal : 0.0) + (catalog_.has_colors ? kColor : 0.0);
    const double raw_vertex =
        kRawPosition + (catalog_.has_normals ? kRawNormal : 0.0) + (catalog_.has_colors ? kColor : 0.0);
    const double per_triangle = vertices_ / triangles_;
    const double near = kGroupBorders * per_triangle;
    const double answered = near + far_share_ * (far_vertices_per_triangle() - near);
    const double in_pieces = kPieceBorders * near + far_share_ * (kCornersPerTriangle - kPieceBorders * near);
    const double polygons = kPolygon * static_cast<double>(catalog_.counts.polygons) / triangles_;
    const double other_reading = catalog_.has_both_readings ? kReading : 0.0;
    const double face_color = catalog_.has_face_colors ? kReading + other_reading : 0.0;
    const double survey = kIndices + polygons + face_color + (raw_vertex + other_reading) * per_triangle;
    const double group_triangles = kIndices + polygons + (catalog_.has_face_colors ? kRequestedColor : 0.0);
    const double requests = group_triangles + kVertexNumber * answered;
    const double cut = polygons > 0.0 ? group_triangles : 0.0;
    const double answers = (kVertexNumber + vertex) * answered;
    const double pieces = (kPieceVertex + vertex) * in_pieces + kPieceTriangle;
    const double levels = needs_.scratch_bytes + needs_.kept_output * output() / triangles_;
    return triangles_ * std::max({survey + requests + answers, requests + answers + cut + pieces, levels});
  }

  // Per triangle of a node. Larger meshes have fewer vertices on borders, which several nodes store.
  double stored_bytes() const {
    const codec::MeasuredBytes& bytes = codec::codec_named(options_.codec).measured;
    const int bits = options_.position_bits - codec::kMeasuredPositionBits;
    const double colors = catalog_.has_colors ? 0.0 : bytes.color;
    return bytes.triangle + (bits > 0 ? bytes.finer_bit : bytes.coarser_bit) * bits - colors +
           needs_.more_bytes + kBorder / std::sqrt(std::min(needs_.node_triangles, triangles_));
  }

  double output() const { return kContainerBase + triangles_ * needs_.stored_triangles * stored_bytes(); }

  const facts::BuildOptions& options_;
  const facts::Catalog& catalog_;
  nodes::NodeNeeds needs_;
  double triangles_;
  double vertices_;
  double group_;  // triangles of a group of the join
  double far_share_;
};

std::uint64_t free_bytes(const std::filesystem::path& folder) {
  struct statvfs info {};
  if (::statvfs(folder.c_str(), &info) != 0) return 0;
  return std::uint64_t{info.f_bavail} * info.f_frsize;
}

bool is_same_device(const std::filesystem::path& a, const std::filesystem::path& b) {
  struct stat of_a {};
  struct stat of_b {};
  return ::stat(a.c_str(), &of_a) == 0 && ::stat(b.c_str(), &of_b) == 0 && of_a.st_dev == of_b.st_dev;
}

void require_space(const std::filesystem::path& folder, std::uint64_t needed, std::uint64_t free,
                   const std::string& what) {
  if (needed <= free) return;
  core::fail(core::Status::kNoResources, "{}: {} will need some {} more, but {} are free", folder.string(),
             what, run::size_text(needed), run::size_text(free));
}

// The scratch that is there already is no longer free; at the end finished nodes lie in scratch and in the
// output.
void require(const run::Workspace& workspace, const run::BuildEstimate& needs,
             const std::filesystem::path& scratch, const std::filesystem::path& output) {
  const std::uint64_t used = scratch::bytes_in(scratch);
  const std::uint64_t more = needs.scratch_bytes > used ? needs.scratch_bytes - used : 0;
  const bool is_same = is_same_device(scratch, output);
  if (is_same) {
    const std::uint64_t at_end = 2 * needs.output_bytes - std::min(used, needs.output_bytes);
    require_space(scratch, std::max(more, at_end), needs.free_scratch_bytes, "scratch and output");
  } else {
    require_space(scratch, more, needs.free_scratch_bytes, "scratch");
    require_space(output, needs.output_bytes, needs.free_output_bytes, "the output");
  }
  if (needs.memory_bytes_per_rank > workspace.memory_bytes)
    core::fail(core::Status::kNoResources,
               "a rank will need some {} of memory, but may use {}: give each rank more with --memory, and "
               "start fewer "
               "ranks per host if need be",
               run::size_text(needs.memory_bytes_per_rank), run::size_text(workspace.memory_bytes));
}

}  // namespace

run::BuildEstimate estimate(const facts::BuildOptions& options, const facts::Catalog& catalog,
                            const ingest::Occupancy& occupancy, std::uint64_t resident_bytes) {
  return Estimator(options, catalog, occupancy).run(resident_bytes);
}

void announce_estimate(const run::Workspace& workspace, const facts::Catalog& catalog,
                       std::uint64_t resident_bytes) {
  const ingest::Occupancy occupancy = ingest::count_occupancy(workspace, catalog);
  workspace.ranks.attempt([&] {
    if (!workspace.ranks.is_root()) return;
    const std::filesystem::path& scratch = workspace.scratch.folder;
    const std::filesystem::path output = core::folder_of(workspace.outputs.container.path);
    run::BuildEstimate needs = estimate(workspace.options, catalog, occupancy, resident_bytes);
    needs.free_scratch_bytes = free_bytes(scratch);
    needs.free_output_bytes = free_bytes(output);
    workspace.reporter.set_estimate(needs);
    core::log("estimate: {} of memory per rank, {} of scratch ({} free), {} of output ({} free)",
              run::size_text(needs.memory_bytes_per_rank), run::size_text(needs.scratch_bytes),
              run::size_text(needs.free_scratch_bytes), run::size_text(needs.output_bytes),
              run::size_text(needs.free_output_bytes));
    require(workspace, needs, scratch, output);
  });
}

}  // namespace colossus::pipeline
