// What the ranks agree on before the first phase: memory, outputs; and what they report afterwards.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "pipeline/run/memory.hpp"
#include "pipeline/test_build.hpp"

namespace colossus::pipeline::run {
namespace {

TEST(MemoryPerRank, IsWhatTheUserAsksFor) {
  EXPECT_EQ(memory_per_rank(world(), "1G"), std::uint64_t{1} << 30);
  EXPECT_EQ(memory_per_rank(world(), "256M"), kLeastMemory);
  for (const std::string asked : {"255M", "0", "much"}) {
    const auto error = error_of([&] { memory_per_rank(world(), asked); });
    ASSERT_ALL(error.has_value());
    EXPECT_EQ(error->status(), core::Status::kUsage);
    EXPECT_NE(std::string(error->what()).find(asked), std::string::npos);
  }
}

TEST(MemoryPerRank, IsElseAShareOfTheHostsAndTheSameOnAllRanks) {
  const std::uint64_t mine = memory_per_rank(world(), {});
  EXPECT_GE(mine, kLeastMemory);
  EXPECT_EQ(world().min(mine), world().max(mine));
  EXPECT_LE(mine * static_cast<std::uint64_t>(world().size()),
            std::max<std::uint64_t>(static_cast<std::uint64_t>(::sysconf(_SC_PHYS_PAGES)) *
                                        static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE)),
                                    kLeastMemory * static_cast<std::uint64_t>(world().size())));
}

TEST(RequireMemory, RefusesWhatDoesNotFitBesideTheProgram) {
  const CommonFolder folder;
  const std::uint64_t limit = std::uint64_t{300} << 20;
  const TestBuild build(folder, {}, false, limit);
  EXPECT_FALSE(error_of([&] { require_memory(build.workspace(), limit - kBaseMemory, "a task"); }));
  const auto error = error_of([&] { require_memory(build.workspace(), limit - kBaseMemory + 1, "a task"); });
  ASSERT_TRUE(error);
  EXPECT_EQ(error->status(), core::Status::kNoResources);
  EXPECT_EQ(
      std::string(error->what()).find("a task needs some 300.1 MB of memory, but a rank may use 300.0 MB"),
      0U)
      << error->what();
}

TEST(PeakMemory, IsThatOfTheGreatestRank) {
  const std::uint64_t peak = greatest_peak_memory(world());
  EXPECT_GE(peak, std::uint64_t{1} << 20);
  EXPECT_EQ(world().min(peak), world().max(peak));
}

TEST(Outputs, AreKnownToRank0AndScratchToAll) {
  const CommonFolder folder;
  facts::BuildOptions options;
  options.output = folder / "out.h5";
  options.status_file = folder / "status.json";
  options.report_file = folder / "report.json";
  EXPECT_EQ(scratch_of(options), folder / "out.h5.scratch");
  EXPECT_EQ(plan_outputs(world(), options).scratch, folder / "out.h5.scratch");
  options.scratch = folder / "elsewhere";
  const Outputs outputs = plan_outputs(world(), options);
  EXPECT_EQ(scratch_of(options), folder / "elsewhere");
  EXPECT_EQ(outputs.scratch, folder / "elsewhere");
  if (!world().is_root()) return;
  EXPECT_EQ(outputs.container.path, folder / "out.h5");
  EXPECT_EQ(outputs.status.path, folder / "status.json");
  EXPECT_EQ(outputs.report.path, folder / "report.json");
}

TEST(Outputs, SpareInputsAndEachOther) {
  const CommonFolder folder;
  if (world().is_root()) std::ofstream(folder / "in.ply") << "ply\n";
  world().barrier();
  using Change = std::function<void(facts::BuildOptions&)>;
  for (const Change& change : {Change([&](auto& o) { o.output = folder / "in.ply"; }),
                               Change([&](auto& o) { o.report_file = folder / "in.ply"; }),
                               Change([&](auto& o) { o.status_file = folder / "out.h5"; }),
                               Change([&](auto& o) { o.scratch = folder.path(); }),
                               Change([&](auto& o) { o.report_file = folder / "out.h5.scratch"; })}) {
    facts::BuildOptions options;
    options.inputs = {(folder / "in.ply").string()};
    options.output = folder / "out.h5";
    EXPECT_FALSE(error_of([&] { plan_outputs(world(), options); }));
    change(options);
    const auto error = error_of([&] { plan_outputs(world(), options); });
    ASSERT_ALL(error.has_value());
    EXPECT_EQ(error->status(), core::Status::kUsage) << error->what();
  }
}

nlohmann::json read_json(const std::filesystem::path& path) {
  return nlohmann::json::parse(std::ifstream(path));
}

// Status and report of a build of two phases that ends with `failure`.
std::pair<nlohmann::json, nlohmann::json> report(const core::Error* failure) {
  const CommonFolder folder;
  facts::BuildOptions options;
  options.status_file = folder / "status.json";
  options.report_file = folder / "report.json";
  options.tolerance = 0.5;
  options.of_scheme["levels"] = std::int64_t{3};
  options.of_scheme["block_size"] = std::int64_t{8};
  TestBuild build(folder, options);
  if (world().is_root()) {
    EXPECT_EQ(read_json(folder / "status.json")["state"], "running");
    EXPECT_EQ(read_json(folder / "report.json")["state"], "running");
  }
  for (const char* name : {"one", "two"})
    run_phase(
        build.workspace(), name, 5, [](std::size_t) { return core::Bytes(3); },
        [&](std::span<const std::byte>) {
          build.workspace().reporter.add_triangles(10);
          build.workspace().writer.append(1, core::Bytes(100));
          return core::Bytes();
        },
        [](std::size_t, const core::Bytes&) {});
  facts::Catalog catalog;
  catalog.files.push_back({"a.ply", 1234, "hash", false, false});
  catalog.counts.triangles = 777;
  build.reporter().set_input(catalog);
  build.reporter().set_attempt(4);
  build.reporter().set_estimate({1, 2, 3, 4, 5});
  facts::FinishedNodes hierarchy;
  hierarchy.levels.resize(2);
  hierarchy.levels[1].triangles = 99;
  hierarchy.nodes.resize(6);
  build.reporter().set_output(hierarchy, 4321);
  build.reporter().finish(failure);
  if (!world().is_root()) return {};
  return {read_json(folder / "status.json"), read_json(folder / "report.json")};
}

TEST(Reporter, SaysWhatABuildHasDone) {
  const auto [status, report_of] = report(nullptr);
  if (!world().is_root()) return;
  EXPECT_EQ(status["state"], "done");
  EXPECT_EQ(status["attempt"], 4);
  EXPECT_EQ(status["phase"]["name"], "two");
  EXPECT_EQ(status["phase"]["done"], 5);
  EXPECT_EQ(report_of["state"], "done");
  EXPECT_EQ(report_of["exit_status"], 0);
  EXPECT_EQ(report_of["inputs"][0]["name"], "a.ply");
  EXPECT_EQ(report_of["counts"]["triangles"], 777);
  EXPECT_EQ(report_of["estimate"]["output_bytes"], 3);
  EXPECT_EQ(report_of["levels"][1]["triangles"], 99);
  EXPECT_EQ(report_of["output"]["nodes"], 6);
  EXPECT_EQ(report_of["output"]["bytes"], 4321);
  EXPECT_EQ(report_of["options"]["tolerance"], 0.5);
  EXPECT_EQ(report_of["options"]["levels"], 3);
  EXPECT_EQ(report_of["options"]["block_size"], 8);
  EXPECT_EQ(report_of["used"]["peak_memory_bytes"].size(), static_cast<std::size_t>(world().size()));
  ASSERT_EQ(report_of["phases"].size(), 2U);
  const double workers = world().size() == 1 ? 1.0 : world().size() - 1.0;
  for (const auto& phase : report_of["phases"]) {
    EXPECT_EQ(phase["tasks"], 5);
    EXPECT_DOUBLE_EQ(phase["rank_tasks"]["mean"], 5.0 / workers);
    EXPECT_DOUBLE_EQ(phase["triangles"]["mean"], 50.0 / workers);
    EXPECT_GE(phase["scratch_bytes"]["mean"], 500.0 / workers);
  }
}

TEST(Reporter, SaysHowABuildHasEnded) {
  const core::Error stop(core::Status::kStopped, "stopped for the test");
  const core::Error failure(core::Status::kBadData, "failed for the test");
  const auto [stopped, report_of_stop] = report(&stop);
  const auto [failed, report_of_failure] = report(&failure);
  if (!world().is_root()) return;
  EXPECT_EQ(stopped["state"], "stopped");
  EXPECT_EQ(failed["state"], "failed");
  EXPECT_EQ(report_of_stop["state"], "stopped");
  EXPECT_EQ(report_of_failure["state"], "failed");
  EXPECT_EQ(report_of_failure["message"], "failed for the test");
  EXPECT_EQ(report_of_failure["exit_status"], static_cast<int>(core::Status::kBadData));
}

TEST(Reporter, FailsBeforeTheBuildWhereItCannotWrite) {
  const CommonFolder folder;
  facts::BuildOptions options;
  options.output = folder / "out.h5";
  const Outputs outputs{{options.output}, {folder / "none/status.json"}, {}, folder / "scratch"};
  const auto error = error_of([&] { Reporter(world(), options, outputs); });
  ASSERT_ALL(error.has_value());
  EXPECT_EQ(error->status(), core::Status::kCannotCreate);
}

}  // namespace
}  // namespace colossus::pipeline::run
