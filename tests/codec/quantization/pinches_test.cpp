#include "codec/quantization/pinches.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <map>

#include "mesh/topology.hpp"

namespace colossus::codec::quantization {
namespace {

using mesh::Triangle;

// Inside, on two faces, and around.
constexpr coded::Weights kInnerA{50, 60, 70, 76};
constexpr coded::Weights kInnerB{60, 50, 70, 76};
constexpr coded::Weights kOnFaceA{0, 100, 100, 56};
constexpr coded::Weights kOnFaceB{100, 0, 100, 56};

struct Surface {
  std::vector<mesh::Vertex> vertices;
  std::vector<Triangle> triangles;
  std::vector<coded::Weights> weights;
  std::vector<bool> is_merged;

  std::uint32_t add(const coded::Weights& w) {
    vertices.push_back({});
    // So that the middle can be told.
    vertices.back().position = {static_cast<std::int32_t>(8 * w[0]), static_cast<std::int32_t>(8 * w[1]),
                                static_cast<std::int32_t>(8 * w[2])};
    weights.push_back(w);
    is_merged.push_back(false);
    return static_cast<std::uint32_t>(weights.size() - 1);
  }
  // A triangle at the edge with a corner where nothing else is.
  void hang(std::uint32_t a, std::uint32_t b) {
    const auto count = static_cast<std::uint32_t>(weights.size());
    triangles.push_back({a, b, add({20 + count, 30, 100, 106 - count})});
  }
  // Two triangles at a new edge between these places; returns its first end, the other one follows.
  std::uint32_t add_pair(const coded::Weights& a, const coded::Weights& b) {
    const std::uint32_t from = add(a);
    const std::uint32_t to = add(b);
    hang(from, to);
    hang(to, from);
    return from;
  }
  void split() { split_edges(vertices, triangles, weights, is_merged); }

  // Welded by place: the most triangles at an edge, and how many edges have more in one direction.
  std::size_t most_triangles() const {
    std::size_t most = 0;
    for (const mesh::Edge& edge : welded_edges()) most = std::max<std::size_t>(most, edge.count());
    return most;
  }
  std::size_t unbalanced() const {
    std::size_t count = 0;
    for (const mesh::Edge& edge : welded_edges()) count += edge.forward != edge.backward ? 1 : 0;
    return count;
  }
  std::vector<mesh::Edge> welded_edges() const {
    std::map<coded::Weights, std::uint32_t> places;
    std::vector<Triangle> welded = triangles;
    for (Triangle& t : welded)
      for (auto& v : t)
        v = places.try_emplace(weights[v], static_cast<std::uint32_t>(places.size())).first->second;
    return mesh::edges(welded);
  }
};

// How many weights differ, all by one unit.
std::size_t count_steps(const std::vector<coded::Weights>& before, const std::vector<coded::Weights>& after) {
  std::size_t steps = 0;
  for (std::size_t v = 0; v < before.size(); ++v) {
    if (before[v] == after[v]) continue;
    ++steps;
    int moved = 0;
    for (std::size_t i = 0; i < 4; ++i)
      moved += std::abs(static_cast<int>(before[v][i]) - static_cast<int>(after[v][i]));
    EXPECT_EQ(moved, 2) << "vertex " << v;
  }
  return steps;
}

TEST(SeparateEdges, InnerVerticesOfCoincidingEdgesStepAside) {
  Surface surface;
  const std::uint32_t first = surface.add_pair(kInnerA, kInnerB);
  surface.add_pair(kInnerA, kInnerB);
  ASSERT_EQ(surface.most_triangles(), 4U);
  const auto before = surface.weights;
  separate_edges(surface.triangles, surface.weights);
  EXPECT_EQ(surface.most_triangles(), 2U);
  EXPECT_EQ(count_steps(before, surface.weights), 2U);
  EXPECT_EQ(surface.weights[first], kInnerA);
  EXPECT_EQ(surface.weights[first + 1], kInnerB);
}

TEST(SeparateEdges, AsManyAsThereArePlaces) {
  Surface surface;
  for (int i = 0; i < 6; ++i) surface.add_pair(kInnerA, kInnerB);
  separate_edges(surface.triangles, surface.weights);
  EXPECT_EQ(surface.most_triangles(), 2U);
}

TEST(SeparateEdges, VerticesOnFacesStay) {
  Surface surface;
  const std::uint32_t first = surface.add_pair(kOnFaceA, kInnerB);
  const std::uint32_t second = surface.add_pair(kOnFaceA, kInnerB);
  separate_edges(surface.triangles, surface.weights);
  EXPECT_EQ(surface.weights[first], kOnFaceA);
  EXPECT_EQ(surface.weights[second], kOnFaceA);
  EXPECT_EQ(surface.weights[first + 1], kInnerB);
  EXPECT_NE(surface.weights[second + 1], kInnerB);
  EXPECT_EQ(surface.most_triangles(), 2U);
}

TEST(SeparateEdges, StepsLeadOntoNoOtherEdge) {
  Surface surface;
  surface.add_pair(kOnFaceA, kInnerB);
  surface.add_pair(kOnFaceA, kInnerB);
  // Where the second would step to, an edge of the same face is already.
  coded::Weights taken = kInnerB;
  ++taken[0];
  --taken[1];
  surface.add_pair(kOnFaceA, taken);
  separate_edges(surface.triangles, surface.weights);
  EXPECT_EQ(surface.most_triangles(), 2U);
}

TEST(SeparateEdges, SingleVerticesThatCoincideStay) {
  Surface surface;
  surface.add_pair(kInnerA, kInnerB);
  surface.add_pair(kInnerA, {70, 50, 60, 76});
  // At the other end's place, but of no triangle.
  surface.add(kInnerB);
  const auto before = surface.weights;
  separate_edges(surface.triangles, surface.weights);
  EXPECT_EQ(surface.weights, before);
}

TEST(SeparateEdges, EdgesOfThreeSheetsStay) {
  Surface surface;
  const std::uint32_t a = surface.add_pair(kInnerA, kInnerB);
  surface.hang(a, a + 1);
  const auto before = surface.weights;
  separate_edges(surface.triangles, surface.weights);
  EXPECT_EQ(surface.weights, before);
}

TEST(SplitEdges, OfTwoPairsAtTheSamePlacesOneIsSplitInsideTheTetrahedron) {
  Surface surface;
  surface.add_pair(kOnFaceA, kOnFaceB);
  surface.add_pair(kOnFaceA, kOnFaceB);
  const auto before = surface;
  surface.split();
  EXPECT_EQ(surface.most_triangles(), 2U);
  EXPECT_EQ(surface.triangles.size(), before.triangles.size() + 2);
  ASSERT_EQ(surface.weights.size(), before.weights.size() + 1);
  ASSERT_EQ(surface.vertices.size(), surface.weights.size());
  EXPECT_EQ(surface.weights.back(), (coded::Weights{50, 50, 100, 56}));
  EXPECT_EQ(surface.vertices.back().position, (mesh::Point{400, 400, 800}));
  EXPECT_TRUE(std::equal(before.weights.begin(), before.weights.end(), surface.weights.begin()));
  EXPECT_EQ(surface.unbalanced(), before.unbalanced());
}

TEST(SplitEdges, AMiddleOnAFaceMovesInside) {
  Surface surface;
  for (int i = 0; i < 2; ++i) surface.add_pair({0, 100, 100, 56}, {0, 50, 150, 56});
  surface.split();
  EXPECT_EQ(surface.weights.back(), (coded::Weights{1, 75, 124, 56}));
  EXPECT_EQ(surface.most_triangles(), 2U);
}

TEST(SplitEdges, MiddlesTakeDifferentPlaces) {
  Surface surface;
  for (int i = 0; i < 4; ++i) surface.add_pair(kOnFaceA, kOnFaceB);
  // Somebody stands at the middle.
  surface.add_pair({50, 50, 100, 56}, {55, 50, 95, 56});
  const std::size_t vertex_count = surface.weights.size();
  surface.split();
  EXPECT_EQ(surface.weights.size(), vertex_count + 3);
  EXPECT_EQ(surface.most_triangles(), 2U);
  EXPECT_EQ(std::count(surface.weights.begin(), surface.weights.end(), coded::Weights{50, 50, 100, 56}), 1);
}

TEST(SplitEdges, APairAtAnEdgeThatCannotBeSplitIsSplit) {
  for (const bool border_first : {false, true}) {
    Surface surface;
    const auto add_border = [&] {
      const std::uint32_t a = surface.add(kOnFaceA);
      surface.hang(a, surface.add(kOnFaceB));
    };
    if (border_first) add_border();
    surface.add_pair(kOnFaceA, kOnFaceB);
    if (!border_first) add_border();
    const std::size_t triangle_count = surface.triangles.size();
    surface.split();
    EXPECT_EQ(surface.triangles.size(), triangle_count + 2);
    EXPECT_EQ(surface.most_triangles(), 2U);
  }
}

// Of four triangles at an edge of merged vertices, two have a new edge afterwards, once.
TEST(SplitEdges, AnEdgeOfTwoMergedPairsIsSplitOnce) {
  for (const std::uint32_t merged_end : {0U, 1U}) {
    Surface surface;
    const std::uint32_t a = surface.add_pair(kOnFaceA, kOnFaceB);
    surface.hang(a, a + 1);
    surface.hang(a + 1, a);
    surface.is_merged[a + merged_end] = true;
    const auto before = surface;
    surface.split();
    EXPECT_EQ(surface.triangles.size(), before.triangles.size() + 2);
    EXPECT_EQ(surface.weights.size(), before.weights.size() + 1);
    EXPECT_EQ(surface.most_triangles(), 2U);
    EXPECT_EQ(surface.unbalanced(), before.unbalanced());
  }
}

TEST(SplitEdges, OfThreeMergedPairsTwoAreSplit) {
  Surface surface;
  const std::uint32_t a = surface.add_pair(kOnFaceA, kOnFaceB);
  for (int i = 0; i < 2; ++i) {
    surface.hang(a, a + 1);
    surface.hang(a + 1, a);
  }
  surface.is_merged[a] = true;
  const std::size_t triangle_count = surface.triangles.size();
  surface.split();
  EXPECT_EQ(surface.triangles.size(), triangle_count + 4);
  EXPECT_EQ(surface.most_triangles(), 2U);
}

// Two edges to split at one vertex: the second finds the triangles that the first has made.
TEST(SplitEdges, EdgesAroundOneVertexAreAllSplit) {
  Surface surface;
  for (int i = 0; i < 2; ++i) {
    const std::uint32_t a = surface.add(kOnFaceA);
    const std::uint32_t b = surface.add(kOnFaceB);
    const std::uint32_t c = surface.add({100, 100, 0, 56});
    surface.triangles.push_back({a, b, c});
    surface.hang(b, a);
    surface.hang(c, b);
    surface.hang(a, c);
  }
  const std::size_t triangle_count = surface.triangles.size();
  const std::size_t unbalanced = surface.unbalanced();
  surface.split();
  EXPECT_EQ(surface.triangles.size(), triangle_count + 6);
  EXPECT_EQ(surface.most_triangles(), 2U);
  EXPECT_EQ(surface.unbalanced(), unbalanced);
}

TEST(SplitEdges, EdgesOfSeveralSheetsOfTheInputStay) {
  for (const bool has_fourth : {false, true}) {
    Surface surface;
    const std::uint32_t a = surface.add_pair(kInnerA, kInnerB);
    surface.hang(a, a + 1);
    if (has_fourth) surface.hang(a + 1, a);
    // Beside it something to do.
    for (int i = 0; i < 2; ++i) surface.add_pair(kOnFaceA, kOnFaceB);
    const std::size_t triangle_count = surface.triangles.size();
    surface.split();
    EXPECT_EQ(surface.triangles.size(), triangle_count + 2);
    EXPECT_EQ(surface.most_triangles(), has_fourth ? 4U : 3U);
  }
}

// The third triangle would be left at an edge that the others no longer have: a crack.
TEST(SplitEdges, AnEdgeOfThreeSheetsStaysWhenItsVerticesHaveBeenMerged) {
  for (const bool has_pair_beside : {false, true}) {
    Surface surface;
    const std::uint32_t a = surface.add_pair(kInnerA, kInnerB);
    surface.hang(a, a + 1);
    surface.is_merged[a] = true;
    if (has_pair_beside) surface.add_pair(kInnerA, kInnerB);
    const std::size_t triangle_count = surface.triangles.size();
    surface.split();
    EXPECT_EQ(surface.triangles.size(), triangle_count + (has_pair_beside ? 2 : 0));
    EXPECT_EQ(surface.most_triangles(), 3U);
  }
}

TEST(SplitEdges, SingleVerticesThatCoincideStay) {
  Surface surface;
  surface.add_pair(kOnFaceA, kOnFaceB);
  surface.add_pair(kOnFaceA, kInnerB);
  const auto triangles = surface.triangles;
  surface.split();
  EXPECT_EQ(surface.triangles, triangles);
}

}  // namespace
}  // namespace colossus::codec::quantization
