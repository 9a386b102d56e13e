#include <cstdio>
#include <cstdlib>

#include "cluster/session.hpp"
#include "mpi_test.hpp"

namespace colossus::testing {
namespace {

cluster::Communicator* all_ranks = nullptr;
std::uint64_t seed = 1;

// For ranks other than 0.
class FailurePrinter : public ::testing::EmptyTestEventListener {
 public:
  void OnTestPartResult(const ::testing::TestPartResult& result) override {
    if (!result.failed()) return;
    std::fprintf(stderr, "rank %d: %s:%d: %s\n", world().rank(),
                 result.file_name() ? result.file_name() : "?", result.line_number(), result.message());
  }
};

int run_tests(cluster::Communicator& ranks, int argc, char** argv) {
  all_ranks = &ranks;
  if (const char* text = std::getenv("COLOSSUS_TEST_SEED")) seed = std::strtoull(text, nullptr, 10);
  // A caught exception would be one rank's failure, and the others would wait for this rank for ever.
  ::testing::GTEST_FLAG(catch_exceptions) = false;
  ::testing::InitGoogleTest(&argc, argv);
  if (ranks.is_root()) {
    std::printf("seed %llu, %d ranks\n", static_cast<unsigned long long>(seed), ranks.size());
  } else {
    auto& listeners = ::testing::UnitTest::GetInstance()->listeners();
    delete listeners.Release(listeners.default_result_printer());
    listeners.Append(new FailurePrinter);
  }
  return RUN_ALL_TESTS();
}

}  // namespace

cluster::Communicator& world() { return *all_ranks; }

std::uint64_t test_seed() { return seed; }

::testing::AssertionResult holds_on_all_ranks(bool mine) {
  const std::int64_t nobody = world().size();
  const std::int64_t lowest = world().min<std::int64_t>(mine ? nobody : world().rank());
  if (lowest == nobody) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "does not hold on rank " << lowest << " of " << nobody << ": ";
}

std::optional<core::Error> error_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const core::Error& error) {
    return error;
  }
  return std::nullopt;
}

}  // namespace colossus::testing

int main(int argc, char** argv) {
  return colossus::cluster::run_ranks(argc, argv, [&](colossus::cluster::Communicator& ranks) {
    return colossus::testing::run_tests(ranks, argc, argv);
  });
}
