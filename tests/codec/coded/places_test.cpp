#include "codec/coded/places.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <numeric>
#include <random>

namespace colossus::codec::coded {
namespace {

using Random = std::mt19937_64;

std::uint32_t sum_of(const Weights& weights) {
  return std::accumulate(weights.begin(), weights.end(), std::uint32_t{0});
}

// Often 0 or small.
Weights random_weights(Random& random, int bits) {
  Weights weights{};
  std::uint32_t left = std::uint32_t{1} << bits;
  for (std::size_t i = 0; i < 3; ++i) {
    weights[i] = random() % 3 == 0 ? 0 : static_cast<std::uint32_t>(random() % (left + 1));
    if (random() % 3 == 0) weights[i] = std::min(weights[i], static_cast<std::uint32_t>(random() % 4));
    left -= weights[i];
  }
  weights[3] = left;
  return weights;
}

TEST(Places, CountFacesByWeightsOfZero) {
  EXPECT_EQ(face_count({64, 64, 64, 64}), 0U);
  EXPECT_EQ(face_count({64, 0, 128, 64}), 1U);
  EXPECT_EQ(face_count({0, 0, 1, 255}), 2U);
  EXPECT_EQ(face_count({0, 0, 256, 0}), 3U);
}

TEST(StepAside, TakesTheFirstFreePlaceInTheOrderOfTheCorners) {
  const Weights start{64, 64, 64, 64};
  std::vector<Weights> weights(13, start);
  Places places{{start, 0}};
  const std::vector<Weights> expected{{65, 63, 64, 64}, {65, 64, 63, 64}, {65, 64, 64, 63}, {63, 65, 64, 64},
                                      {64, 65, 63, 64}, {64, 65, 64, 63}, {63, 64, 65, 64}, {64, 63, 65, 64},
                                      {64, 64, 65, 63}, {63, 64, 64, 65}, {64, 63, 64, 65}, {64, 64, 63, 65}};
  for (std::uint32_t v = 1; v < 13; ++v) {
    EXPECT_TRUE(step_aside(v, weights, places));
    EXPECT_EQ(weights[v], expected[v - 1]);
    // It is noted: the next one goes on from there.
    EXPECT_EQ(places.at(weights[v]), v);
  }
  EXPECT_EQ(weights[0], start);
}

TEST(StepAside, StaysOnTheSameFaces) {
  std::vector<Weights> weights{{0, 1, 127, 128}, {0, 1, 127, 128}, {0, 1, 127, 128}, {0, 1, 127, 128}};
  Places places{{weights[0], 0}};
  const std::vector<Weights> expected{{0, 2, 126, 128}, {0, 2, 127, 127}, {0, 1, 128, 127}};
  for (std::uint32_t v = 1; v < 4; ++v) {
    EXPECT_TRUE(step_aside(v, weights, places));
    EXPECT_EQ(weights[v], expected[v - 1]);
  }
}

TEST(StepAside, FailsWhereThereIsNoPlace) {
  // On a corner; on the shortest edge that has two places, the other one taken.
  std::vector<Weights> weights{{0, 256, 0, 0}, {2, 0, 0, 1}, {2, 0, 0, 1}};
  Places places{{weights[0], 0}, {weights[1], 1}};
  EXPECT_FALSE(step_aside(0, weights, places));
  EXPECT_EQ(weights[0], (Weights{0, 256, 0, 0}));
  EXPECT_TRUE(step_aside(1, weights, places));
  EXPECT_EQ(weights[1], (Weights{1, 0, 0, 2}));
  EXPECT_FALSE(step_aside(2, weights, places));
  EXPECT_EQ(weights[2], (Weights{2, 0, 0, 1}));
}

TEST(MiddleOf, IsHalfwayAndRoundsInTurns) {
  EXPECT_EQ(middle_of({0, 100, 100, 56}, {0, 50, 150, 56}), (Weights{0, 75, 125, 56}));
  EXPECT_EQ(middle_of({101, 50, 50, 55}, {100, 51, 50, 55}), (Weights{100, 51, 50, 55}));
  EXPECT_EQ(middle_of({101, 51, 51, 53}, {100, 50, 50, 56}), (Weights{100, 51, 50, 55}));
  // A weight of one end alone is left at 1 at least: the middle is not on that face.
  EXPECT_EQ(middle_of({1, 0, 255, 0}, {0, 0, 256, 0}), (Weights{1, 0, 255, 0}));
}

TEST(MiddleOf, LiesOnCommonFacesAndNoOthers) {
  constexpr std::uint64_t kSeed = 1;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  Random random(kSeed);
  for (int round = 0; round < 20000; ++round) {
    const Weights a = random_weights(random, 8);
    const Weights b = random_weights(random, 8);
    const Weights middle = middle_of(a, b);
    EXPECT_EQ(sum_of(middle), 256U);
    EXPECT_EQ(middle, middle_of(b, a));
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_EQ(middle[i] == 0, a[i] == 0 && b[i] == 0);
      const int twice = static_cast<int>(2 * middle[i]);
      EXPECT_LE(std::abs(twice - static_cast<int>(a[i] + b[i])), 5);
    }
    if (HasFailure()) return;
  }
}

TEST(OffFaces, MovesToTheNearestPlaceInside) {
  EXPECT_EQ(off_faces({64, 64, 64, 64}), (Weights{64, 64, 64, 64}));
  EXPECT_EQ(off_faces({1, 1, 1, 253}), (Weights{1, 1, 1, 253}));
  EXPECT_EQ(off_faces({0, 100, 156, 0}), (Weights{1, 100, 154, 1}));
  EXPECT_EQ(off_faces({0, 0, 256, 0}), (Weights{1, 1, 253, 1}));
}

}  // namespace
}  // namespace colossus::codec::coded
