// Levels of made-up tasks on any number of ranks: their order, memory, log and errors, and what a resumed
// build does of them again.
#include "pipeline/nodes/level_driver.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "core/hash.hpp"
#include "pipeline/facts/level_table.hpp"
#include "pipeline/run/memory.hpp"
#include "pipeline/test_build.hpp"

namespace colossus::pipeline::nodes {
namespace {

constexpr std::uint64_t kMiB = std::uint64_t{1} << 20;

struct TaskBytes {
  std::uint64_t level = 0;
  std::uint64_t index = 0;
  std::uint64_t triangles = 0;
};

// Of level, index and size alone: 1 to 3 nodes, whose areas differ by so much that their sum tells their
// order.
std::vector<facts::FinishedNode> nodes_of(const TaskBytes& task) {
  std::vector<facts::FinishedNode> nodes;
  for (std::uint64_t k = 0; k <= task.index % 3; ++k) {
    const std::uint64_t random = core::mix64(1 + (task.level << 40) + (task.index << 8) + k);
    facts::FinishedNode node;
    node.row.level = static_cast<std::uint32_t>(task.level);
    node.row.center = {static_cast<std::int32_t>(random & 7), static_cast<std::int32_t>(random >> 40),
                       static_cast<std::int32_t>(3 * task.index + k)};
    node.row.flags = random % 2 == 0 ? container::kNodeIsLeaf : std::uint8_t{0};
    node.row.triangles = static_cast<std::uint32_t>(task.triangles + k);
    node.row.vertices = static_cast<std::uint32_t>(random % 1000);
    node.row.error = static_cast<double>(random % 991);
    node.row.stored_bytes = random % 977;
    node.area = std::ldexp(1.0 + static_cast<double>(random % 1009) / 1009.0, static_cast<int>(random % 60));
    node.statistics.initial_triangles = 3 * task.triangles;
    node.statistics.locked_vertices = random % 13;
    nodes.push_back(node);
  }
  return nodes;
}

// What a level has done: on rank 0 the calls, on all ranks how often tasks were worked on, by index.
struct Trace {
  struct Call {
    char what = ' ';  // 'b': task_bytes of so many triangles, 'm': make, of an index
    std::uint64_t value = 0;
    friend bool operator==(const Call&, const Call&) = default;
  };
  std::vector<Call> calls;
  std::vector<std::uint64_t> worked;
  std::vector<std::size_t> made() const {
    std::vector<std::size_t> made;
    for (const Call& call : calls)
      if (call.what == 'm') made.push_back(call.value);
    return made;
  }
  std::uint64_t work_count() const {
    std::uint64_t sum = 0;
    for (const auto count : worked) sum += count;
    return sum;
  }
};

// Tasks in any order, several of a size.
std::vector<PlannedTask> random_plan(std::mt19937_64& random, std::size_t count = 31) {
  std::vector<PlannedTask> plan(count);
  for (std::size_t i = 0; i < count; ++i) plan[i] = {i, 1 + random() % 9};
  std::shuffle(plan.begin(), plan.end(), random);
  return plan;
}

// Ranks other than 0 know of it what they have to.
Level made_up_level(std::uint32_t number, const std::vector<PlannedTask>& plan, Trace& trace) {
  Level level;
  level.name = fmt::format("level {}", number);
  trace = {};
  trace.worked.resize(plan.size());
  level.work = [&trace](std::span<const std::byte> bytes) {
    ++trace.worked.at(core::ByteReader(bytes).get<TaskBytes>().index);
    return core::Bytes(bytes.begin(), bytes.end());
  };
  if (!world().is_root()) return level;
  level.tasks = plan;
  level.task_name = "a made-up task";
  level.task_bytes = [&trace](std::uint64_t triangles) {
    trace.calls.push_back({'b', triangles});
    return triangles * kMiB;
  };
  level.make = [&trace, number, plan](std::size_t index) {
    trace.calls.push_back({'m', index});
    const auto task = std::find_if(plan.begin(), plan.end(), [&](const auto& t) { return t.index == index; });
    core::ByteWriter writer;
    writer.put(TaskBytes{number, index, task->triangles});
    return writer.take();
  };
  level.take = [](std::span<const std::byte> bytes) {
    return nodes_of(core::ByteReader(bytes).get<TaskBytes>());
  };
  return level;
}

// By level.
using Plans = std::vector<std::vector<PlannedTask>>;

facts::FinishedNodes expected_of(const Plans& plans) {
  facts::FinishedNodes finished;
  for (std::uint32_t number = 0; number < plans.size(); ++number)
    for (const PlannedTask& task : plans[number])
      for (const auto& node : nodes_of({number, task.index, task.triangles})) finished.add(node);
  finished.sort();
  return finished;
}

void expect_same(const facts::FinishedNodes& found, const facts::FinishedNodes& expected) {
  ASSERT_EQ(found.nodes.size(), expected.nodes.size());
  for (std::size_t i = 0; i < found.nodes.size(); ++i) {
    EXPECT_EQ(found.nodes[i].row, expected.nodes[i].row);
    EXPECT_EQ(found.nodes[i].area, expected.nodes[i].area);
  }
  EXPECT_EQ(found.finest_area(), expected.finest_area());
  ASSERT_EQ(found.levels.size(), expected.levels.size());
  for (std::size_t i = 0; i < found.levels.size(); ++i)
    facts::for_each_level_field([&](const facts::LevelField& field, auto member) {
      EXPECT_EQ(std::invoke(member, found.levels[i]), std::invoke(member, expected.levels[i]))
          << "level " << i << ": " << (field.column == nullptr ? "not stored" : field.column);
    });
}

TEST(LevelDriver, MakesTheLargestTasksFirst) {
  std::mt19937_64 random(test_seed());
  const CommonFolder folder;
  const TestBuild build(folder);
  LevelDriver driver(build.workspace());
  for (std::uint32_t number = 5; number-- > 0;) {
    const std::vector<PlannedTask> plan = random_plan(random, 1 + random() % 40);
    Trace trace;
    driver.run(made_up_level(number, plan, trace));
    world().all_sum(trace.worked);
    EXPECT_EQ(trace.worked, std::vector<std::uint64_t>(plan.size(), 1));
    std::vector<std::size_t> expected;
    for (std::uint64_t triangles = 9; triangles > 0; --triangles)
      for (const PlannedTask& task : plan)
        if (task.triangles == triangles) expected.push_back(task.index);
    if (world().is_root()) {
      EXPECT_EQ(trace.made(), expected) << "those of a size as they were planned";
    }
  }
}

TEST(LevelDriver, AsksForTheMemoryOfATaskBeforeItIsMade) {
  std::mt19937_64 random(test_seed() + 1);
  const std::vector<PlannedTask> plan = random_plan(random);
  std::uint64_t greatest = 0;
  for (const PlannedTask& task : plan) greatest = std::max(greatest, task.triangles);
  const std::uint64_t enough = greatest * kMiB + run::kBaseMemory;
  {
    const CommonFolder folder;
    const TestBuild build(folder, {}, false, enough);
    Trace trace;
    LevelDriver(build.workspace()).run(made_up_level(3, plan, trace));
    ASSERT_EQ(trace.calls.size(), world().is_root() ? 2 * plan.size() : 0);
    for (std::size_t i = 0; i < trace.calls.size(); i += 2) {
      const auto task = std::find_if(plan.begin(), plan.end(),
                                     [&](const auto& t) { return t.index == trace.calls[i + 1].value; });
      EXPECT_EQ(trace.calls[i], (Trace::Call{'b', task->triangles}));
      EXPECT_EQ(trace.calls[i + 1].what, 'm');
    }
  }
  const CommonFolder folder;
  const TestBuild build(folder, {}, false, enough - 1);
  Trace trace;
  const auto error = error_of([&] { LevelDriver(build.workspace()).run(made_up_level(3, plan, trace)); });
  ASSERT_ALL(error.has_value());
  EXPECT_EQ(error->status(), core::Status::kNoResources);
  EXPECT_EQ(
      std::string(error->what()).find(fmt::format("a made-up task of {} triangles in level 3", greatest)), 0U)
      << error->what();
  EXPECT_EQ(trace.made(), std::vector<std::size_t>()) << "the largest comes first";
  world().all_sum(trace.worked);
  EXPECT_EQ(trace.work_count(), 0U);
}

// On each number of ranks the same as one after the other here.
TEST(LevelDriver, FinishesTheSameNodesInWhateverOrder) {
  std::mt19937_64 random(test_seed() + 2);
  Plans plans;
  for (int number = 0; number < 4; ++number) plans.push_back(random_plan(random));
  const facts::FinishedNodes expected = expected_of(plans);
  for (int round = 0; round < 3; ++round) {
    const CommonFolder folder;
    const TestBuild build(folder);
    LevelDriver driver(build.workspace());
    for (std::uint32_t number = 4; number-- > 0;) {
      std::shuffle(plans[number].begin(), plans[number].end(), random);
      Trace trace;
      driver.run(made_up_level(number, plans[number], trace));
    }
    const facts::FinishedNodes found = driver.take();
    if (world().is_root())
      expect_same(found, expected);
    else
      EXPECT_TRUE(found.nodes.empty() && found.levels.empty());
  }
}

TEST(LevelDriver, TakesAllOfItByLevelAndCentre) {
  std::mt19937_64 random(test_seed() + 3);
  const CommonFolder folder;
  const TestBuild build(folder);
  LevelDriver driver(build.workspace());
  driver.finished().position_bits = 13;
  driver.finished().options = {{"of_the_scheme", "7"}};
  for (std::uint32_t number = 3; number-- > 0;) {
    Trace trace;
    driver.run(made_up_level(number, random_plan(random), trace));
  }
  const facts::FinishedNodes found = driver.take();
  EXPECT_EQ(found.position_bits, 13);
  EXPECT_EQ(found.options, (std::vector<container::NamedText>{{"of_the_scheme", "7"}}));
  EXPECT_EQ(found.nodes.size() > 100, world().is_root());
  for (std::size_t i = 1; i < found.nodes.size(); ++i) {
    const container::NodeRow &a = found.nodes[i - 1].row, &b = found.nodes[i].row;
    EXPECT_TRUE(a.level < b.level || (a.level == b.level && a.center < b.center)) << i;
  }
}

// What the driver says while it runs a level: progress, which only rank 0 has, and warnings.
struct Said {
  std::string log, warnings;
};
Said said_while(const std::function<void()>& action) {
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  action();
  Said said;
  said.log = ::testing::internal::GetCapturedStdout();
  said.warnings = ::testing::internal::GetCapturedStderr();
  return said;
}

TEST(LevelDriver, LogsALevelByItsOwnNodes) {
  std::mt19937_64 random(test_seed() + 4);
  const CommonFolder folder;
  const TestBuild build(folder);
  LevelDriver driver(build.workspace());
  for (const bool has_text : {false, true}) {
    const std::uint32_t number = has_text ? 1 : 2;
    const std::vector<PlannedTask> plan = random_plan(random);
    std::uint64_t nodes = 0, triangles = 0;
    for (const PlannedTask& task : plan)
      for (const auto& node : nodes_of({number, task.index, task.triangles})) {
        ++nodes;
        triangles += node.row.triangles;
      }
    Trace trace;
    Level level = made_up_level(number, plan, trace);
    if (has_text) level.nodes_text = [](std::uint64_t count) { return fmt::format("{} cubes", count); };
    const Said said = said_while([&] { driver.run(std::move(level)); });
    const std::string line = fmt::format("level {}: {} {}, {} triangles, peak memory ", number, nodes,
                                         has_text ? "cubes" : "nodes", triangles);
    EXPECT_EQ(said.log.find(line) != std::string::npos, world().is_root()) << said.log;
    EXPECT_EQ(said.warnings, "");
  }
}

TEST(LevelDriver, WarnsOfALevelThatHasMissedItsTarget) {
  std::mt19937_64 random(test_seed() + 5);
  for (int round = 0; round < 6; ++round) {
    const std::uint64_t target = 1000 + random() % 1000 * 10;
    const std::uint64_t most = target / 10 * 11;
    const bool is_missed = round % 2 == 1;
    // The level that the tasks simplify has the sums; another one, or none, has nothing to miss.
    const std::optional<std::uint32_t> simplified =
        round < 4 ? std::optional<std::uint32_t>(2) : std::nullopt;
    const CommonFolder folder;
    const TestBuild build(folder);
    LevelDriver driver(build.workspace());
    Trace trace;
    Level level = made_up_level(2, {{0, 1}, {1, 1}, {2, 1}}, trace);
    level.take = [&](std::span<const std::byte> bytes) {
      const auto task = core::ByteReader(bytes).get<TaskBytes>();
      std::vector<facts::FinishedNode> nodes = nodes_of(task);
      // One task alone says nothing.
      nodes[0].statistics.target_triangles = task.index == 0 ? target : 0;
      nodes[0].statistics.reached_triangles = task.index == 1 ? most + (is_missed ? 1 : 0) : 0;
      return nodes;
    };
    level.simplified = simplified;
    const Said said = said_while([&] { driver.run(std::move(level)); });
    const bool is_warned = said.warnings.find("level 2 does not shrink as it should") != std::string::npos;
    EXPECT_EQ(is_warned, world().is_root() && simplified && is_missed) << target << ' ' << said.warnings;
    EXPECT_EQ(said.warnings.empty(), !is_warned) << said.warnings;
  }
}

TEST(LevelDriver, RunsALevelWithoutTasks) {
  const CommonFolder folder;
  const TestBuild build(folder);
  LevelDriver driver(build.workspace());
  Level level;
  level.name = "level 7";
  level.work = [](std::span<const std::byte>) -> core::Bytes { throw std::logic_error("there is no task"); };
  level.simplified = 7;
  const Said said = said_while([&] { driver.run(std::move(level)); });
  EXPECT_EQ(said.log.find("level 7: 0 nodes, 0 triangles") != std::string::npos, world().is_root())
      << said.log;
  EXPECT_EQ(said.warnings, "");
  EXPECT_EQ(run::last_phase(build.workspace()), 1U) << "a resumed build counts it, too";
  const facts::FinishedNodes found = driver.take();
  EXPECT_TRUE(found.nodes.empty() && found.levels.empty());
}

TEST(LevelDriver, EndsOnAllRanksWhereAnyCallFails) {
  std::mt19937_64 random(test_seed() + 6);
  const std::vector<PlannedTask> plan = random_plan(random);
  const auto fail = [] { core::fail(core::Status::kBadData, "as it was told to"); };
  using Change = std::function<void(Level&)>;
  for (const Change& change : {Change([&](Level& l) {
                                 l.work = [&, work = l.work](std::span<const std::byte> bytes) {
                                   if (core::ByteReader(bytes).get<TaskBytes>().index == 17) fail();
                                   return work(bytes);
                                 };
                               }),
                               Change([&](Level& l) {
                                 l.make = [&, make = l.make](std::size_t index) {
                                   if (index == 17) fail();
                                   return make(index);
                                 };
                               }),
                               Change([&](Level& l) {
                                 l.take = [&, take = l.take](std::span<const std::byte> bytes) {
                                   if (core::ByteReader(bytes).get<TaskBytes>().index == 17) fail();
                                   return take(bytes);
                                 };
                               })}) {
    const CommonFolder folder;
    const TestBuild build(folder);
    LevelDriver driver(build.workspace());
    Trace trace;
    Level level = made_up_level(2, plan, trace);
    change(level);
    const auto error = error_of([&] { driver.run(std::move(level)); });
    ASSERT_ALL(error.has_value());
    EXPECT_EQ(error->status(), core::Status::kBadData);
    EXPECT_EQ(std::string(error->what()).find("as it was told to"), 0U) << error->what();
  }
}

TEST(LevelDriver, GoesOnWhereAnAttemptHasFailed) {
  std::mt19937_64 random(test_seed() + 7);
  Plans plans;
  for (int number = 0; number < 3; ++number) plans.push_back(random_plan(random));
  const CommonFolder folder;
  std::vector<std::uint64_t> worked;
  {
    const TestBuild build(folder);
    LevelDriver driver(build.workspace());
    Trace trace;
    driver.run(made_up_level(2, plans[2], trace));
    Level level = made_up_level(1, plans[1], trace);
    level.work = [work = level.work](std::span<const std::byte> bytes) {
      if (core::ByteReader(bytes).get<TaskBytes>().index == 11)
        core::fail(core::Status::kNoResources, "as it was told to");
      return work(bytes);
    };
    const auto error = error_of([&] { driver.run(std::move(level)); });
    ASSERT_ALL(error.has_value());
    world().all_sum(trace.worked);
    worked = trace.worked;
    EXPECT_EQ(worked[11], 0U);
  }
  const TestBuild build(folder, {}, true);
  LevelDriver driver(build.workspace());
  for (std::uint32_t number = 3; number-- > 0;) {
    Trace trace;
    driver.run(made_up_level(number, plans[number], trace));
    world().all_sum(trace.worked);
    for (std::size_t i = 0; i < plans[number].size(); ++i)
      EXPECT_EQ(trace.worked[i], number == 2 ? 0 : number == 1 ? 1 - worked[i] : 1) << number << ' ' << i;
  }
  const facts::FinishedNodes found = driver.take();
  if (world().is_root()) expect_same(found, expected_of(plans));
}

// The finest level alone, all leaves, and an input with so much of its area.
struct Finest {
  std::vector<PlannedTask> plan;
  facts::Catalog catalog;
  double area = 0.0;

  Finest(std::mt19937_64& random, double share) : plan(random_plan(random)) {
    const facts::FinishedNodes all = expected_of({{}, {}, plan});
    area = all.finest_area();
    catalog.files.push_back({"a.ply", 0, "", false, false});
    catalog.area = area / share;
    catalog.lattice.step = 0.25;
  }
  void run(LevelDriver& driver) const {
    driver.finished().lattice.step = 0.25;
    Trace trace;
    Level level = made_up_level(2, plan, trace);
    level.take = [](std::span<const std::byte> bytes) {
      auto nodes = nodes_of(core::ByteReader(bytes).get<TaskBytes>());
      for (auto& node : nodes) node.row.flags = container::kNodeIsLeaf;
      return nodes;
    };
    driver.run(std::move(level));
  }
};

TEST(LevelDriver, RefusesAFinestLevelThatLacksSurface) {
  std::mt19937_64 random(test_seed() + 8);
  for (const double share : {0.1, 0.49, 0.51, 1.0}) {
    const CommonFolder folder;
    const TestBuild build(folder);
    LevelDriver driver(build.workspace());
    const Finest finest(random, share);
    finest.run(driver);
    const auto error = error_of([&] { driver.finish_finest(finest.catalog); });
    ASSERT_ALL(error.has_value() == (share < 0.5));
    if (error) {
      EXPECT_EQ(error->status(), core::Status::kBadData);
      EXPECT_EQ(std::string(error->what()).find("a.ply: the finest level would have"), 0U) << error->what();
    }
  }
}

TEST(LevelDriver, ChecksTheFinestLevelOnRank0BeforeItsSurface) {
  std::mt19937_64 random(test_seed() + 9);
  for (const bool lacks_surface : {false, true})
    for (const bool fails : {false, true}) {
      const CommonFolder folder;
      const TestBuild build(folder);
      LevelDriver driver(build.workspace());
      const Finest finest(random, lacks_surface ? 0.2 : 1.0);
      finest.run(driver);
      int checks = 0;
      const auto error = error_of([&] {
        driver.finish_finest(finest.catalog, [&] {
          ++checks;
          if (fails) core::fail(core::Status::kUsage, "as it was told to");
        });
      });
      EXPECT_EQ(checks, world().is_root() ? 1 : 0);
      ASSERT_ALL(error.has_value() == (fails || lacks_surface));
      if (error) {
        EXPECT_EQ(error->status(), fails ? core::Status::kUsage : core::Status::kBadData);
      }
      if (!error && world().is_root()) {
        const std::vector<facts::StoredNode>& nodes = driver.finished().nodes;
        EXPECT_TRUE(std::is_sorted(nodes.begin(), nodes.end(), [](const auto& a, const auto& b) {
          return a.row.center < b.row.center;
        })) << "the sum of areas is that of ordered nodes";
        EXPECT_EQ(driver.finished().finest_area(), finest.area);
      }
    }
}

}  // namespace
}  // namespace colossus::pipeline::nodes
