#include "codec/zstd/packed_arrays.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "codec/coded/renumber.hpp"
#include "codec/payload.hpp"

namespace colossus::codec::zstd {
namespace {

using mesh::Triangle;

// A strip of triangles over a grid, shuffled.
std::vector<Triangle> shuffled_grid(std::mt19937& random, std::uint32_t side) {
  std::vector<Triangle> triangles;
  for (std::uint32_t y = 0; y + 1 < side; ++y)
    for (std::uint32_t x = 0; x + 1 < side; ++x) {
      const std::uint32_t v = y * side + x;
      triangles.push_back({v, v + 1, v + side});
      triangles.push_back({v + 1, v + side + 1, v + side});
    }
  std::shuffle(triangles.begin(), triangles.end(), random);
  return triangles;
}

// With the least corner first, in the same cyclic order.
Triangle turned(Triangle t) {
  std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  return t;
}

std::vector<Triangle> sorted(std::vector<Triangle> triangles) {
  for (Triangle& t : triangles) t = turned(t);
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

// How often a vertex is not among the last sixteen that were fetched.
std::size_t misses(const std::vector<Triangle>& triangles) {
  std::vector<std::uint32_t> cache;
  std::size_t count = 0;
  for (const Triangle& t : triangles)
    for (const std::uint32_t v : t) {
      if (std::find(cache.begin(), cache.end(), v) != cache.end()) continue;
      ++count;
      cache.push_back(v);
      if (cache.size() > 16) cache.erase(cache.begin());
    }
  return count;
}

TEST(PackedArrays, TheOrderForCachesKeepsTrianglesAndMissesLess) {
  std::mt19937 random(1);
  for (const std::uint32_t side : {2U, 9U, 40U}) {
    const std::vector<Triangle> before = shuffled_grid(random, side);
    std::vector<Triangle> after = before;
    order_for_cache(after, std::size_t{side} * side);
    EXPECT_EQ(sorted(after), sorted(before));
    std::vector<Triangle> again = before;
    order_for_cache(again, std::size_t{side} * side);
    EXPECT_EQ(again, after) << "deterministic";
    if (side >= 9) {
      EXPECT_LT(misses(after) * 2, misses(before));
    }
  }
}

TEST(PackedArrays, SectionsOfAnyOtherSizeAreADefect) {
  std::mt19937 random(2);
  coded::CodedNode node;
  node.position_bits = 12;
  node.has_normals = node.has_colors = true;
  coded::CodedPart& part = node.parts.emplace_back();
  part.triangles = shuffled_grid(random, 7);
  coded::renumber_by_first_use(part.triangles, 49);
  for (std::uint32_t v = 0; v < 49; ++v) {
    const auto coordinate = [&] { return static_cast<std::uint32_t>(random() % 1000); };
    const std::uint32_t a = coordinate(), b = coordinate(), c = coordinate();
    part.positions.push_back({a, b, c, 4096 - a - b - c});
    part.normals.push_back({static_cast<std::uint8_t>(random()), static_cast<std::uint8_t>(random())});
    part.colors.push_back({1, 2, static_cast<std::uint8_t>(random()), 4});
  }
  const coded::Sections sections = encode_packed(node);
  const auto decode = [&](const coded::Sections& bytes) {
    coded::CodedNode decoded = node;
    for (auto& position : decoded.parts[0].positions) position = {};
    for (auto& triangle : decoded.parts[0].triangles) triangle = {};
    coded::SectionViews views;
    for (std::size_t i = 0; i < views.size(); ++i) views[i] = bytes[i];
    const auto defect = decode_packed(views, decoded);
    return defect ? std::optional<coded::CodedNode>() : decoded;
  };
  ASSERT_EQ(decode(sections), node);
  for (std::size_t i = 0; i < sections.size(); ++i)
    for (const int change : {-1, 1}) {
      coded::Sections other = sections;
      if (other[i].empty() && change < 0) continue;
      other[i].resize(other[i].size() + static_cast<std::size_t>(change));
      EXPECT_EQ(decode(other), std::nullopt) << "section " << i << " by " << change;
    }
}

}  // namespace
}  // namespace colossus::codec::zstd
