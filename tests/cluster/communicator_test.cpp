#include "cluster/communicator.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <random>

#include "core/hash.hpp"
#include "mpi_test.hpp"

namespace colossus::cluster {
namespace {

using core::Bytes;
using testing::world;

// The bytes that rank `from` sends to rank `to` in a round: sizes around `piece_bytes` and none at all, so
// that both ends are computed independently.
Bytes message(int from, int to, int round, std::size_t longest = 300'000) {
  std::mt19937_64 random(core::mix64(testing::test_seed()) ^
                         core::mix64(static_cast<std::uint64_t>((round * 100 + from) * 100 + to + 1)));
  Bytes bytes(random() % 3 == 0 ? 0 : random() % longest);
  std::generate(bytes.begin(), bytes.end(), [&] { return static_cast<std::byte>(random()); });
  return bytes;
}

// Restores the piece size, so that each test may set its own.
class CommunicatorTest : public ::testing::TestWithParam<std::size_t> {
 protected:
  CommunicatorTest() { world().set_piece_bytes(GetParam()); }
  ~CommunicatorTest() override { world().set_piece_bytes(kDefaultPieceBytes); }
};
INSTANTIATE_TEST_SUITE_P(PieceBytes, CommunicatorTest, ::testing::Values(1000, 65'536, kDefaultPieceBytes));

TEST_P(CommunicatorTest, BroadcastGivesAllRanksTheBytesOfTheRoot) {
  for (int root = 0; root < world().size(); ++root) {
    for (const std::size_t size : {0, 1, 999, 1000, 1001, 250'000}) {
      Bytes expected(size);
      for (std::size_t i = 0; i < size; ++i) expected[i] = static_cast<std::byte>(i * 7 + size);
      Bytes bytes = world().rank() == root ? expected : Bytes(17);
      world().broadcast(bytes, root);
      EXPECT_ALL(bytes == expected);
    }
  }
}

TEST_P(CommunicatorTest, GatherGivesRankZeroTheBytesOfEachRank) {
  for (int round = 0; round < 5; ++round) {
    const std::vector<Bytes> all = world().gather(message(world().rank(), 0, round));
    bool good = all.size() == (world().is_root() ? static_cast<std::size_t>(world().size()) : 0U);
    for (std::size_t r = 0; r < all.size(); ++r)
      good = good && all[r] == message(static_cast<int>(r), 0, round);
    EXPECT_ALL(good);
  }
}

TEST_P(CommunicatorTest, AllGatherGivesEveryRankTheBytesOfEachRank) {
  for (int round = 0; round < 5; ++round) {
    const std::vector<Bytes> all = world().all_gather(message(world().rank(), 0, round));
    bool good = all.size() == static_cast<std::size_t>(world().size());
    for (std::size_t r = 0; r < all.size(); ++r)
      good = good && all[r] == message(static_cast<int>(r), 0, round);
    EXPECT_ALL(good);
  }
}

TEST_P(CommunicatorTest, ExchangeDeliversEveryPartWhateverItsSize) {
  for (int round = 0; round < 5; ++round) {
    std::vector<Bytes> parts;
    for (int to = 0; to < world().size(); ++to) parts.push_back(message(world().rank(), to, round));
    const std::vector<Bytes> received = world().exchange(std::move(parts));
    bool good = received.size() == static_cast<std::size_t>(world().size());
    for (std::size_t from = 0; from < received.size(); ++from)
      good = good && received[from] == message(static_cast<int>(from), world().rank(), round);
    EXPECT_ALL(good);
  }
}

TEST_P(CommunicatorTest, ExchangeOfNothingReturnsNothing) {
  const std::vector<Bytes> received =
      world().exchange(std::vector<Bytes>(static_cast<std::size_t>(world().size())));
  EXPECT_ALL(std::all_of(received.begin(), received.end(), [](const Bytes& part) { return part.empty(); }));
}

TEST_P(CommunicatorTest, ReductionsOfIntegersAreElementwise) {
  const auto rank = static_cast<std::int64_t>(world().rank());
  const auto size = static_cast<std::int64_t>(world().size());
  std::vector<std::int64_t> sums(3000);
  std::vector<std::int64_t> minima(3000);
  std::vector<std::uint64_t> maxima(3000);
  for (std::size_t i = 0; i < sums.size(); ++i) {
    sums[i] = rank * static_cast<std::int64_t>(i);
    minima[i] = static_cast<std::int64_t>(i) - rank;
    maxima[i] = (std::uint64_t{1} << 63) + i + static_cast<std::uint64_t>(rank);
  }
  world().all_sum(std::span<std::int64_t>(sums));
  world().all_min(std::span<std::int64_t>(minima));
  world().all_max(std::span<std::uint64_t>(maxima));
  bool good = true;
  for (std::size_t i = 0; i < sums.size(); ++i) {
    good = good && sums[i] == size * (size - 1) / 2 * static_cast<std::int64_t>(i);
    good = good && minima[i] == static_cast<std::int64_t>(i) - (size - 1);
    good = good && maxima[i] == (std::uint64_t{1} << 63) + i + static_cast<std::uint64_t>(size - 1);
  }
  EXPECT_ALL(good);
}

TEST(Communicator, SumsWrapAroundAndSingleValuesWork) {
  const auto size = static_cast<std::uint64_t>(world().size());
  EXPECT_ALL(world().sum<std::uint64_t>(~std::uint64_t{0}) == std::uint64_t{0} - size);
  EXPECT_ALL(world().max<std::int64_t>(-world().rank()) == 0);
  EXPECT_ALL(world().min<std::uint64_t>(5 + static_cast<std::uint64_t>(world().rank())) == 5);
}

TEST(Communicator, MinimumAndMaximumOfDoublesDoNotDependOnTheOrderOfRanks) {
  // Each value at each rank in turn; the rest holds 0.0.
  const double infinity = std::numeric_limits<double>::infinity();
  for (int holder = 0; holder < world().size(); ++holder) {
    const bool mine = world().rank() == holder;
    std::vector<double> low{mine ? -0.0 : 0.0, mine ? -3.5 : 2.0, mine ? -infinity : 0.0,
                            mine ? 1e-310 : 7.0};
    std::vector<double> high{mine ? 0.0 : -0.0, mine ? 3.5 : -2.0, mine ? infinity : 0.0,
                             mine ? -1e-310 : -7.0};
    world().all_min(std::span<double>(low));
    world().all_max(std::span<double>(high));
    EXPECT_ALL(std::signbit(low[0]) && low[0] == 0.0);
    EXPECT_ALL(low[1] == -3.5 && low[2] == -infinity && low[3] == 1e-310);
    EXPECT_ALL(!std::signbit(high[0]) && high[0] == 0.0);
    EXPECT_ALL(high[1] == 3.5 && high[2] == infinity && high[3] == -1e-310);
  }
}

TEST(Communicator, AgreeReturnsWhenNoRankHasAnError) {
  EXPECT_ALL(!testing::error_of([] { world().agree(std::nullopt); }));
}

TEST(Communicator, AgreeThrowsTheErrorOfTheLowestRankOnAllRanks) {
  for (int first = 0; first < world().size(); ++first) {
    const auto error = testing::error_of([&] {
      std::optional<core::Error> mine;
      if (world().rank() >= first)
        mine.emplace(core::Status::kBadData, fmt::format("rank {}", world().rank()));
      world().agree(mine);
    });
    ASSERT_ALL(error.has_value());
    EXPECT_ALL(error->status() == core::Status::kBadData);
    EXPECT_ALL(error->what() == fmt::format("rank {}", first));
  }
}

TEST(Communicator, AttemptTurnsAnyExceptionIntoAnErrorOfAllRanks) {
  const int last = world().size() - 1;
  const auto status_of = [&](auto exception) {
    const auto error = testing::error_of([&] {
      world().attempt([&] {
        if (world().rank() == last) throw exception;
      });
    });
    return error ? error->status() : core::Status::kOk;
  };
  EXPECT_ALL(status_of(core::Error(core::Status::kIo, "disk")) == core::Status::kIo);
  EXPECT_ALL(status_of(std::bad_alloc()) == core::Status::kNoResources);
  EXPECT_ALL(status_of(std::out_of_range("at")) == core::Status::kInternal);
  EXPECT_ALL(status_of(3) == core::Status::kInternal);
}

TEST(Communicator, HostNamesHasOneNamePerRank) {
  const std::vector<std::string> hosts = world().host_names();
  EXPECT_ALL(hosts.size() == static_cast<std::size_t>(world().size()));
  EXPECT_ALL(std::none_of(hosts.begin(), hosts.end(), [](const std::string& host) { return host.empty(); }));
}

}  // namespace
}  // namespace colossus::cluster
