// Synthetic statues: closed, even, and the same bytes everywhere.
#include <sys/resource.h>

#include <csignal>

#include "core/hash.hpp"
#include "support/synth_testing.hpp"
#include "synth/order.hpp"
#include "synth/surface.hpp"

namespace colossus::synth {

using namespace support;
namespace {

TEST_F(Synth, StatueIsClosedManifoldAndOutwardAtEverySize) {
  for (const std::uint64_t triangles : {1U, 12U, 20U, 100U, 1000U, 10'000U, 10'001U, 54'321U, 300'000U}) {
    SCOPED_TRACE(triangles);
    const Ply ply = parse(bytes(options(triangles)));
    EXPECT_EQ(ply.positions.size(), report_.vertices);
    EXPECT_EQ(ply.triangles.size(), report_.triangles);
    expect_closed_manifold(ply);
    EXPECT_GT(volume(ply), 0.05e9);
    EXPECT_LT(volume(ply), 0.60e9);
    double smallest = 1e30, sum = 0;
    for (const Triangle& t : ply.triangles) {
      const double area = length(area_vector(ply, t));
      smallest = std::min(smallest, area);
      sum += area;
    }
    EXPECT_GT(smallest, 0.01 * sum / static_cast<double>(ply.triangles.size()));
    for (const Point& p : ply.positions)
      for (const double c : p) EXPECT_TRUE(std::isfinite(c));
  }
}

TEST_F(Synth, CountsAreNearTheRequest) {
  for (const std::uint64_t triangles : {12U, 100U, 10'000U, 300'000U}) {
    synthesize(options(12));
    const SynthReport report = synthesize(options(triangles));
    EXPECT_EQ(report.triangles, triangles);
  }
  for (std::uint64_t triangles = 10'000; triangles < 400'000; triangles = triangles * 9 / 7 + 1) {
    const auto made = static_cast<double>(synthesize(options(triangles)).triangles);
    EXPECT_NEAR(made, static_cast<double>(triangles), 0.01 * static_cast<double>(triangles));
  }
}

TEST_F(Synth, TrianglesAreEven) {
  const Ply ply = parse(bytes(options(100'000)));
  std::vector<double> edges;
  for (const Triangle& t : ply.triangles)
    for (std::size_t i = 0; i < 3; ++i)
      edges.push_back(length(minus(ply.positions[t[i]], ply.positions[t[(i + 1) % 3]])));
  std::ranges::sort(edges);
  EXPECT_LT(edges[edges.size() * 99 / 100], 6 * edges[edges.size() / 100]);
  EXPECT_LT(edges.back(), 50 * edges.front());
}

// Too large to write here: corners of triangles all over the file are neighbours on the surface.
TEST(SynthSurface, LargestStatueIsSound) {
  EXPECT_THROW(make_statue_surface(std::uint64_t{1} << 33, 1), core::Error);
  const auto surface = make_statue_surface((std::uint64_t{1} << 32) - 2'000'000, 1);
  EXPECT_GT(surface->vertex_count(), (std::uint64_t{1} << 31) - 10'000'000);
  EXPECT_LE(surface->vertex_count(), std::uint64_t{1} << 31);
  EXPECT_EQ(surface->triangle_count(), 2 * surface->vertex_count() - 4);
  const auto batch = std::make_unique<SurfaceBatch>();
  const SynthOrder order(surface->triangle_count(), 99);
  for (std::uint64_t i = 0; i < 5000; ++i) {
    std::array<Triangle, 1> triangle;
    surface->triangles(i == 0 ? surface->triangle_count() - 1 : order.forward(i), triangle);
    for (const std::uint32_t v : triangle[0]) ASSERT_LT(v, surface->vertex_count());
    surface->evaluate(triangle[0], *batch);
    const auto& [x, y, z] = batch->position;
    for (std::size_t a = 0; a < 3; ++a) {
      const std::size_t b = (a + 1) % 3;
      const double edge = length({x[a] - x[b], y[a] - y[b], z[a] - z[b]});
      EXPECT_GT(edge, 0.1 * surface->mean_edge());
      EXPECT_LT(edge, 5 * surface->mean_edge());
    }
  }
}

// Over six edges along the plinth's flat front, the surface bends at every size: the relief goes down to the
// edges.
TEST_F(Synth, DetailReachesAFewEdgesAtEverySize) {
  for (const std::uint64_t triangles : {20'000U, 200'000U, 2'000'000U}) {
    SynthOptions made = options(triangles);
    made.colors = false;
    const Ply ply = parse(bytes(made));
    double bend = 0, across = 0;
    for (std::size_t i = 3; i + 3 < ply.positions.size() / 4; ++i) {
      const Point &before = ply.positions[i - 3], &here = ply.positions[i], &after = ply.positions[i + 3];
      if (here[2] < 40 || here[2] > 90 || here[1] > -200 || std::abs(here[0]) > 150) continue;
      bend += std::abs(after[1] - 2 * here[1] + before[1]);
      across += after[0] - before[0];
    }
    EXPECT_GT(bend / across, 0.025) << triangles;
  }
}

TEST_F(Synth, BytesDependOnSeedButNotOnThreads) {
  SynthOptions made = options(150'000);
  made.normals = true;
  for (const bool shuffle : {false, true}) {
    made.shuffle = shuffle;
    made.seed = 7;
    made.threads = 1;
    const core::Bytes one = bytes(made);
    for (const unsigned threads : {2U, 3U, 0U}) {
      made.threads = threads;
      EXPECT_EQ(bytes(made), one) << threads << " threads, shuffle " << shuffle;
    }
    made.seed = 8;
    EXPECT_NE(bytes(made), one);
  }
}

TEST_F(Synth, SeedsDifferInRelief) {
  SynthOptions made = options(20'000);
  const Ply one = parse(bytes(made));
  made.seed = 2;
  const Ply two = parse(bytes(made));
  double farthest = 0;
  for (std::size_t i = 0; i < one.positions.size(); ++i)
    farthest = std::max(farthest, length(minus(one.positions[i], two.positions[i])));
  EXPECT_GT(farthest, 5) << "millimetres; the scanner's noise is below 2";
}

constexpr std::uint64_t kGolden = 5878746031637011905U;

// The hash of a small statue, so that a change of compiler, build type or code that changes the bytes is
// noticed.
TEST_F(Synth, BytesAreTheSameOnEveryMachine) {
  SynthOptions made = options(30'000);
  made.normals = true;
  EXPECT_EQ(core::hash64(bytes(made)), kGolden);
}

TEST_F(Synth, HeaderListsWhatWasAskedFor) {
  SynthOptions made = options(12);
  made.normals = true;
  const std::vector<std::string> full = {"ply",
                                         "format binary_little_endian 1.0",
                                         "comment colossus synth, seed 1",
                                         "element vertex 8",
                                         "property float x",
                                         "property float y",
                                         "property float z",
                                         "property float nx",
                                         "property float ny",
                                         "property float nz",
                                         "property uchar red",
                                         "property uchar green",
                                         "property uchar blue",
                                         "element face 12",
                                         "property list uchar int vertex_indices",
                                         "end_header"};
  EXPECT_EQ(parse(bytes(made)).header, full);
  made.normals = made.colors = false;
  const Ply bare = parse(bytes(made));
  EXPECT_EQ(bare.header.size(), full.size() - 6);
  EXPECT_TRUE(bare.colors.empty());
}

TEST_F(Synth, ColorsVary) {
  const Ply ply = parse(bytes(options(50'000)));
  std::vector<std::size_t> histogram(256);
  for (const Rgb& c : ply.colors) ++histogram[c[0]];
  EXPECT_GT(std::ranges::count_if(histogram, [](std::size_t n) { return n > 20; }), 60);
  EXPECT_LT(histogram[0] + histogram[255], ply.colors.size() / 50);
}

TEST_F(Synth, NormalsAreThoseOfTheSurface) {
  SynthOptions made = options(100'000);
  made.normals = true;
  const Ply ply = parse(bytes(made));
  double sum = 0;
  for (const Triangle& t : ply.triangles) {
    const Point area = area_vector(ply, t);
    for (const std::uint32_t v : t) sum += dot(area, ply.normals[v]) / length(area);
  }
  EXPECT_GT(sum / (3.0 * static_cast<double>(ply.triangles.size())), 0.97);
  for (const Point& n : ply.normals) EXPECT_NEAR(length(n), 1, 1e-5);
}

std::multiset<std::array<Point, 3>> corners_of(const Ply& ply) {
  std::multiset<std::array<Point, 3>> result;
  for (const Triangle& t : ply.triangles) {
    result.insert({ply.positions[t[0]], ply.positions[t[1]], ply.positions[t[2]]});
  }
  return result;
}

TEST_F(Synth, ShuffleOnlyReorders) {
  SynthOptions made = options(40'000);
  const Ply plain = parse(bytes(made));
  made.shuffle = true;
  const Ply shuffled = parse(bytes(made));
  EXPECT_EQ(corners_of(shuffled), corners_of(plain));
  std::multiset<std::pair<Point, Rgb>> before, after;
  for (std::size_t i = 0; i < plain.positions.size(); ++i) {
    before.insert({plain.positions[i], plain.colors[i]});
    after.insert({shuffled.positions[i], shuffled.colors[i]});
  }
  EXPECT_EQ(after, before);
  // No locality: the corners of a triangle, and of successive triangles, lie anywhere.
  const auto mean_jump = [](const Ply& ply) {
    double sum = 0;
    for (std::size_t i = 0; i + 1 < ply.triangles.size(); ++i)
      for (const std::uint32_t other : {ply.triangles[i][1], ply.triangles[i + 1][0]})
        sum += std::abs(static_cast<double>(ply.triangles[i][0]) - static_cast<double>(other));
    return sum / static_cast<double>(2 * ply.triangles.size() * ply.positions.size());
  };
  EXPECT_NEAR(mean_jump(shuffled), 1.0 / 3, 0.02);
  EXPECT_LT(mean_jump(plain), 0.01);
}

TEST(SynthOrder, IsAPermutationWithItsInverse) {
  for (const std::uint64_t count : {1U, 2U, 3U, 4U, 5U, 16U, 17U, 1000U, 4096U, 65'537U}) {
    const SynthOrder order(count, count * 31 + 5);
    std::vector<bool> seen(count);
    for (std::uint64_t i = 0; i < count; ++i) {
      const std::uint64_t to = order.forward(i);
      ASSERT_LT(to, count);
      EXPECT_FALSE(seen[to]);
      seen[to] = true;
      EXPECT_EQ(order.backward(to), i);
    }
  }
}

// More than 2^32 faces are possible on bases with many sheets.
TEST(SynthOrder, LargeCountsHaveTheirInverse) {
  for (const std::uint64_t count : {(1ULL << 31) - 7, 1ULL << 32, (1ULL << 32) + 12'345, (1ULL << 33) - 1}) {
    const SynthOrder order(count, 3);
    for (std::uint64_t i = 0; i < 20'000; ++i)
      for (const std::uint64_t index : {i, count - 1 - i, core::mix64(i) % count}) {
        const std::uint64_t to = order.forward(index);
        ASSERT_LT(to, count);
        ASSERT_EQ(order.backward(to), index);
        ASSERT_LT(order.backward(index), count);
      }
  }
}

// Chi-square of where pairs of indices go, over 32 x 32 parts of the file, and how many go near each other.
struct PairStatistics {
  double chi_square = 0, near = 0;
};
constexpr std::uint64_t kPairParts = 32, kPairNear = 50;

PairStatistics measure_pairs(const std::vector<std::uint64_t>& to, std::uint64_t distance) {
  const std::uint64_t count = to.size();
  std::vector<double> pairs(kPairParts * kPairParts);
  PairStatistics result;
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::uint64_t a = to[i], b = to[(i + distance) % count];
    ++pairs[a * kPairParts / count * kPairParts + b * kPairParts / count];
    result.near += std::max(a, b) - std::min(a, b) <= kPairNear ? 1 : 0;
  }
  const double expected = static_cast<double>(count) / static_cast<double>(pairs.size());
  for (const double n : pairs) result.chi_square += (n - expected) * (n - expected) / expected;
  return result;
}

// Where two indices go is as good as independent, whatever their distance. With two or four rounds instead of
// six, those a multiple of 256 apart, which is the length of a row here, show.
TEST(SynthOrder, NoDistanceIsNear) {
  constexpr std::uint64_t kCount = 100'000, kSeeds = 16;
  constexpr double kFreedom = (kPairParts - 1.0) * (kPairParts - 1.0);
  for (const bool is_forward : {true, false})
    for (const std::uint64_t distance : {1U, 2U, 3U, 255U, 256U, 257U, 512U, 50'000U}) {
      double chi_square = 0, near = 0;
      for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
        const SynthOrder order(kCount, seed);
        std::vector<std::uint64_t> to(kCount);
        for (std::uint64_t i = 0; i < kCount; ++i) to[i] = is_forward ? order.forward(i) : order.backward(i);
        const PairStatistics pairs = measure_pairs(to, distance);
        chi_square += pairs.chi_square / kSeeds;
        near += pairs.near;
      }
      SCOPED_TRACE(fmt::format("distance {}, {}", distance, is_forward ? "forward" : "backward"));
      EXPECT_NEAR(chi_square, kFreedom, 5 * std::sqrt(2 * kFreedom / kSeeds));
      EXPECT_NEAR(near, 2.0 * kPairNear * kSeeds, 5 * std::sqrt(2.0 * kPairNear * kSeeds));
    }
}

TEST(SynthOrder, BlocksHoldTheirElementsByNumber) {
  for (const std::uint64_t count : {1ULL, 200ULL, 256ULL, 257ULL, 70'000ULL, 20'000'000ULL, 1ULL << 32}) {
    SCOPED_TRACE(count);
    const SynthOrder order(count, 17);
    const std::size_t size = std::min<std::uint64_t>(count, 1U << SynthSlot::kPlaceBits);
    for (const std::uint64_t first : {std::uint64_t{0}, count - size}) {
      const std::vector<SynthSlot> slots = order.block(first, size);
      ASSERT_EQ(slots.size(), size);
      std::vector<bool> seen(size);
      for (std::size_t i = 0; i < size; ++i) {
        ASSERT_EQ(slots[i].number(), order.forward(first + slots[i].place()));
        EXPECT_TRUE(i == 0 || slots[i - 1].number() < slots[i].number());
        EXPECT_FALSE(seen[slots[i].place()]);
        seen[slots[i].place()] = true;
      }
    }
  }
}

TEST(SynthSurface, TrianglesOfTheStatueAreTheSameInAnyOrder) {
  for (const std::uint64_t size : {1U, 12U, 100U, 5000U})
    expect_triangles_by_number(*make_statue_surface(size, 1));
}

TEST_F(Synth, ErrorsHaveTheirStatusAndLeaveNothingBehind) {
  EXPECT_EQ(failure(options(0)), 2);
  EXPECT_EQ(failure(options(std::uint64_t{1} << 40)), 2);
  EXPECT_EQ(failure(options((std::uint64_t{1} << 32) + 1)), 2);
  SynthOptions made = options(100'000);
  made.output = folder_.path() / "missing" / "statue.ply";
  EXPECT_EQ(failure(made), 73);
  made.output = folder_.path() / "directory";
  std::filesystem::create_directories(made.output / "full");
  EXPECT_EQ(failure(made), 73);
  made.output = folder_.path() / "disk.ply";
  std::filesystem::create_symlink("/dev/full", folder_.path() / "disk.ply.part");
  EXPECT_EQ(failure(made), 0) << "what lies at the name of the part is not followed";
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/full"));
}

// A write that fails in the middle, on whichever thread.
TEST_F(Synth, AFileThatCannotGrowIsRemoved) {
  struct rlimit before {};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const struct rlimit small = {1'000'000, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  SynthOptions made = options(300'000);
  std::vector<int> statuses;
  for (const unsigned threads : {1U, 3U}) {
    made.threads = threads;
    statuses.push_back(failure(made));
  }
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(statuses, std::vector<int>({69, 69}));
  EXPECT_FALSE(std::filesystem::exists(made.output));
}

TEST_F(Synth, AnOldFileIsReplacedAndNoPartRemains) {
  SynthOptions made = options(12);
  folder_.write("statue.ply", "old");
  folder_.write("statue.ply.part", std::string(100'000, 'x'));
  const Ply ply = parse(bytes(made));
  EXPECT_EQ(ply.triangles.size(), 12U);
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "statue.ply.part"));
}

}  // namespace
}  // namespace colossus::synth
