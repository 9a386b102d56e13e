#include "build/estimate.hpp"

#include <sys/stat.h>
#include <sys/statvfs.h>

#include "build/memory.hpp"
#include "core/log.hpp"
#include "scratch/directory.hpp"

namespace colossus::build {
namespace {

std::filesystem::path folder_of(const std::filesystem::path& file) {
  return file.has_parent_path() ? file.parent_path() : ".";
}

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

}  // namespace

BuildEstimate estimate(const BuildOptions& options, const Catalog& catalog, std::uint64_t resident_bytes) {
  (void)options;
  BuildEstimate needs;
  needs.memory_bytes_per_rank = resident_bytes;
  needs.scratch_bytes = 200 * catalog.counts.triangles;
  needs.output_bytes = 25 * catalog.counts.triangles;
  return needs;
}

void announce_estimate(const Workspace& workspace, const Catalog& catalog) {
  const std::uint64_t resident = greatest_peak_memory(workspace.ranks);
  workspace.ranks.attempt([&] {
    if (!workspace.ranks.is_root()) return;
    const std::filesystem::path& scratch = workspace.scratch.folder;
    const std::filesystem::path output = folder_of(workspace.options.output);
    BuildEstimate needs = estimate(workspace.options, catalog, resident);
    needs.free_scratch_bytes = free_bytes(scratch);
    needs.free_output_bytes = free_bytes(output);
    workspace.reporter.set_estimate(needs);
    core::log("estimate: {} of memory per rank, {} of scratch ({} free), {} of output ({} free)",
              size_text(needs.memory_bytes_per_rank), size_text(needs.scratch_bytes),
              size_text(needs.free_scratch_bytes), size_text(needs.output_bytes),
              size_text(needs.free_output_bytes));
  });
}

}  // namespace colossus::build
