// What a build has before its first phase, on all ranks of a test; and inputs that no file was read for.
#pragma once

#include <unistd.h>

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mpi_test.hpp"
#include "pipeline/facts/catalog.hpp"
#include "pipeline/run/phase.hpp"
#include "pipeline/run/restart.hpp"

namespace colossus::pipeline {

using testing::error_of;
using testing::test_seed;
using testing::world;

// A folder of which all ranks know the name; removed with all that is in it. Collective.
class CommonFolder {
 public:
  CommonFolder() {
    static int count = 0;
    auto pid = static_cast<std::uint64_t>(::getpid());
    broadcast_value(world(), pid);
    path_ = std::filesystem::temp_directory_path() / fmt::format("colossus-pipeline-{}-{}", pid, ++count);
    if (world().is_root()) std::filesystem::create_directory(path_);
    world().barrier();
  }
  ~CommonFolder() {
    world().barrier();
    if (world().is_root()) std::filesystem::remove_all(path_);
    world().barrier();
  }
  CommonFolder(const CommonFolder&) = delete;
  CommonFolder& operator=(const CommonFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

inline scratch::Manifest sample_manifest() {
  scratch::Manifest manifest;
  manifest.add("leaf_triangles", "8000");
  return manifest;
}

// One attempt at a build, whose scratch lies in the folder and stays there when this is gone. Collective.
class TestBuild {
 public:
  explicit TestBuild(const CommonFolder& folder, facts::BuildOptions options = {}, bool may_resume = false,
                     std::uint64_t memory_bytes = std::uint64_t{1} << 30)
      : options_(with_output(folder, std::move(options))),
        outputs_(run::plan_outputs(world(), options_)),
        reporter_(world(), options_, outputs_),
        opened_(run::open_scratch(world(), outputs_.scratch, may_resume, sample_manifest())),
        writer_(opened_.location, opened_.progress.journal.attempt(),
                static_cast<std::uint16_t>(world().rank())),
        reader_(opened_.location),
        workspace_{world(),      options_,         opened_.location, writer_, reader_,
                   memory_bytes, opened_.progress, reporter_,        outputs_} {}
  ~TestBuild() { world().barrier(); }
  TestBuild(const TestBuild&) = delete;
  TestBuild& operator=(const TestBuild&) = delete;

  const run::Workspace& workspace() const { return workspace_; }
  run::Reporter& reporter() { return reporter_; }

 private:
  static facts::BuildOptions with_output(const CommonFolder& folder, facts::BuildOptions options) {
    options.output = folder / "out.h5";
    return options;
  }

  facts::BuildOptions options_;
  run::Outputs outputs_;
  run::Reporter reporter_;
  run::OpenedScratch opened_;
  scratch::SpoolWriter writer_;
  scratch::SpoolReader reader_;
  run::Workspace workspace_;
};

// An input file as the survey leaves it.
struct MadeUpFile {
  std::vector<std::array<double, 3>> positions;
  std::vector<std::array<float, 3>> normals;  // empty, or one per position
  std::vector<mesh::Color> colors;            // likewise
  std::vector<mesh::Color> byte_colors;       // likewise: another reading
  std::vector<mesh::Triangle> triangles;
  std::vector<mesh::Color> face_colors;  // empty, or one per triangle
  std::vector<input::Polygon> polygons;
};

// Stores blocks of the files in a phase, as the survey does, and returns the catalogue of them, on all ranks.
// All ranks have the same files; those with polygons have one block of triangles. Collective.
facts::Catalog store_files(const run::Workspace& workspace, const std::vector<MadeUpFile>& files,
                           std::size_t block_vertices, std::size_t block_triangles);

// The catalogue's bounds and lattice, from all vertices.
void fit_lattice(facts::Catalog& catalog, const std::vector<MadeUpFile>& files);

}  // namespace colossus::pipeline
