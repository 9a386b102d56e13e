#include "pipeline/estimate.hpp"

#include <sys/stat.h>
#include <sys/statvfs.h>

#include <algorithm>
#include <cmath>

#include "codec/codec.hpp"
#include "core/log.hpp"
#include "core/place.hpp"
#include "pipeline/run/memory.hpp"
#include "pipeline/schemes.hpp"
#include "scratch/directory.hpp"

namespace colossus::pipeline {
namespace {

constexpr double kMiB = 1 << 20;

// What was measured, times this, is estimated: statues differ.
constexpr double kMargin = 1.2;
constexpr double kOutputMargin = 1.28;  // noise counts

// How much of the triangles' order is without locality, from the vertices that a block of triangles has per
// triangle.
double far_share(double vertices_per_triangle) {
  return std::clamp((vertices_per_triangle - 0.7) / (2.9 - 0.7), 0.0, 1.0);
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
        far_share_(far_share(static_cast<double>(catalog.input_block_vertices) / triangles_)) {}

  run::BuildEstimate run(std::uint64_t resident_bytes) const {
    run::BuildEstimate needs;
    needs.memory_bytes_per_rank = resident_bytes + static_cast<std::uint64_t>(task_memory());
    needs.scratch_bytes = static_cast<std::uint64_t>(kMargin * scratch());
    needs.output_bytes = static_cast<std::uint64_t>(kOutputMargin * output());
    return needs;
  }

 private:
  // A group of triangles as join_vertices() takes them, and how many vertices one has, when shuffled.
  double group() const { return std::clamp(triangles_ / 64, 131072.0, 524288.0); }
  double far_vertices_per_triangle() const {
    return vertices_ / group() * (1.0 - std::exp(-3.0 * group() / std::max(vertices_, 1.0)));
  }

  // Beyond what the program takes after the survey.
  double task_memory() const {
    // Where each corner is a vertex of its own, more of them are held at a time.
    const double corners = catalog_.has_face_colors ? 1.6 : vertices_ > 2.0 * triangles_ ? 1.3 : 1.0;
    const double buckets = corners * std::min(31 * kMiB, 4 * kMiB + 110.0 * triangles_);
    const double range =
        43.0 * std::clamp(std::exp2(std::ceil(std::log2(vertices_ / 64 + 1))), 131072.0, 1048576.0);
    const double groups = far_share_ * 150.0 * std::min(group(), triangles_);
    return std::max({buckets, range, groups, needs_.task_bytes});
  }

  // At the end of the phases that hold most.
  double scratch() const {
    const double vertex_bytes = 12.0 + (catalog_.has_normals ? 4.0 : 0.0) + (catalog_.has_colors ? 3.0 : 0.0);
    const double raw_bytes = 24.0 + (catalog_.has_normals ? 12.0 : 0.0) + (catalog_.has_colors ? 3.0 : 0.0);
    const double near = 1.05 * vertices_ / triangles_;
    const double answered = near + far_share_ * (far_vertices_per_triangle() - near);
    const double in_pieces = 1.15 * near + far_share_ * (3.0 - 1.15 * near);
    const double polygons = 8.0 * static_cast<double>(catalog_.counts.polygons) / triangles_;
    const double other_reading = catalog_.has_both_readings ? 4.0 : 0.0;
    const double face_color = catalog_.has_face_colors ? 4.0 + other_reading : 0.0;
    const double survey = 12.0 + polygons + face_color + (raw_bytes + other_reading) * vertices_ / triangles_;
    const double group_triangles = 12.0 + polygons + (catalog_.has_face_colors ? 5.0 : 0.0);
    const double requests = group_triangles + 4.0 * answered;
    const double cut = polygons > 0.0 ? group_triangles : 0.0;
    const double answers = (4.0 + vertex_bytes) * answered;
    const double pieces = (8.0 + vertex_bytes) * in_pieces + 6.0;
    const double levels = needs_.scratch_bytes + needs_.kept_output * output() / triangles_;
    return triangles_ * std::max({survey + requests + answers, requests + answers + cut + pieces, levels});
  }

  // Per triangle of a node. Larger meshes have fewer vertices on borders, which several nodes store.
  double stored_bytes() const {
    const codec::MeasuredBytes& bytes = codec::codec_named(options_.codec).measured;
    const int bits = options_.position_bits - 12;
    const double colors = catalog_.has_colors ? 0.0 : bytes.color;
    return bytes.triangle + (bits > 0 ? bytes.finer_bit : bytes.coarser_bit) * bits - colors +
           needs_.more_bytes + 45.0 / std::sqrt(std::min(needs_.node_triangles, triangles_));
  }

  double output() const { return 10000.0 + triangles_ * needs_.stored_triangles * stored_bytes(); }

  const facts::BuildOptions& options_;
  const facts::Catalog& catalog_;
  nodes::NodeNeeds needs_;
  double triangles_;
  double vertices_;
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
