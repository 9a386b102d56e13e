#include "pipeline/ingest/piece.hpp"

#include <gtest/gtest.h>

#include <random>
#include <set>

#include "pipeline/ingest/radix_sort.hpp"
#include "pipeline/test_build.hpp"

namespace colossus::pipeline::ingest {
namespace {

Piece random_piece(std::size_t vertices, std::size_t triangles, std::mt19937_64& random) {
  Piece piece;
  for (std::size_t v = 0; v < vertices; ++v) {
    mesh::Vertex vertex;
    const auto coordinate = [&](int residue) {
      return static_cast<std::int32_t>(random() % (1U << 27)) * 8 + residue;
    };
    vertex.position = {coordinate(1), coordinate(2), coordinate(4)};
    vertex.fingerprint = static_cast<std::uint16_t>(random() % (1U << 15));
    const auto component = [&] {
      return static_cast<std::int16_t>(static_cast<int>(random() % 65535) - 32767);
    };
    vertex.normal = {component(), component(), component()};
    for (auto& c : vertex.color) c = static_cast<std::uint8_t>(random());
    piece.vertices.push_back(vertex);
    piece.numbers.push_back(random());
  }
  for (std::size_t i = 0; i < triangles; ++i) {
    mesh::Triangle t;
    for (auto& v : t) v = static_cast<std::uint32_t>(random() % vertices);
    piece.triangles.push_back(t);
  }
  return piece;
}

// 65,536 vertices have 16-bit numbers, one more has not.
TEST(Piece, SurvivesScratch) {
  std::mt19937_64 random(test_seed());
  const CommonFolder folder;
  const TestBuild build(folder);
  facts::Catalog catalog;
  for (const std::size_t vertices : {1, 3, 65'535, 65'536, 65'537, 70'000})
    for (const bool has_normals : {false, true})
      for (const bool has_colors : {false, true}) {
        catalog.has_normals = has_normals;
        catalog.has_colors = has_colors;
        Piece piece = random_piece(vertices, 100'000, random);
        const scratch::RecordRef record = store_piece(build.workspace(), catalog, piece);
        for (mesh::Vertex& v : piece.vertices) {
          if (!has_normals) v.normal = {0, 0, 0};
          if (!has_colors) v.color = {255, 255, 255, 255};
        }
        Piece loaded;
        for (std::uint32_t i = 0; i < 2; ++i) {
          load_piece(build.workspace(), catalog, record, loaded);
          // The second time it comes behind the first.
          const auto first = static_cast<std::ptrdiff_t>(i * vertices);
          EXPECT_TRUE(std::equal(piece.numbers.begin(), piece.numbers.end(), loaded.numbers.begin() + first,
                                 loaded.numbers.end()));
          EXPECT_TRUE(std::equal(piece.vertices.begin(), piece.vertices.end(),
                                 loaded.vertices.begin() + first, loaded.vertices.end()));
          for (std::size_t t = 0; t < piece.triangles.size(); ++t)
            for (std::size_t k = 0; k < 3; ++k)
              ASSERT_EQ(loaded.triangles[i * piece.triangles.size() + t][k],
                        piece.triangles[t][k] + i * vertices);
        }
      }
}

TEST(PieceCutter, TakesTrianglesWithTheVerticesThatTheyUse) {
  std::mt19937_64 random(test_seed());
  const Piece whole = random_piece(1000, 3000, random);
  PieceCutter cutter(whole);
  for (int i = 0; i < 20; ++i) {
    std::vector<std::uint32_t> wanted;
    for (std::uint32_t t = 0; t < whole.triangles.size(); ++t)
      if (random() % 20 <= static_cast<unsigned>(i)) wanted.push_back(t);
    const Piece part = cutter.take(wanted);
    ASSERT_EQ(part.triangles.size(), wanted.size());
    ASSERT_EQ(part.numbers.size(), part.vertices.size());
    std::uint32_t next = 0;  // in order of first use
    std::set<std::uint32_t> used;
    for (std::size_t t = 0; t < wanted.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k) {
        const auto v = part.triangles[t][k];
        const auto of_whole = whole.triangles[wanted[t]][k];
        ASSERT_LE(v, next);
        if (v == next) ++next;
        ASSERT_EQ(part.numbers.at(v), whole.numbers[of_whole]);
        ASSERT_EQ(part.vertices[v], whole.vertices[of_whole]);
        used.insert(of_whole);
      }
    EXPECT_EQ(part.vertices.size(), used.size());
  }
  EXPECT_TRUE(cutter.take({}).vertices.empty());
}

TEST(FaceCorner, TellsItsVertexAndIsNoRealOne) {
  std::mt19937_64 random(test_seed());
  std::set<std::uint64_t> numbers;
  for (int i = 0; i < 1000; ++i) {
    const std::uint64_t vertex = random() >> 29;
    const std::uint64_t corner = random();
    const std::uint64_t number = face_corner_number(vertex, corner);
    EXPECT_GE(number, kFaceCornerNumbers);
    EXPECT_EQ(vertex_number(number), vertex);
    EXPECT_EQ(vertex_number(vertex), vertex);
    EXPECT_NE(face_corner_number(vertex, corner + 1), number);
    EXPECT_NE(face_corner_number(vertex + 1, corner), number);
  }
}

TEST(RadixSort, IsAStableSortBySomeBits) {
  std::mt19937_64 random(test_seed());
  for (int i = 0; i < 200; ++i) {
    const int first = static_cast<int>(random() % 40);
    const int end = first + static_cast<int>(random() % (65 - static_cast<unsigned>(first)));
    std::vector<std::uint64_t> keys(random() % 3000);
    for (auto& key : keys) key = random();
    const auto part = [&](std::uint64_t key) {
      return end - first == 64 ? key : key >> first & ((std::uint64_t{1} << (end - first)) - 1);
    };
    std::vector<std::uint64_t> expected = keys;
    std::stable_sort(expected.begin(), expected.end(), [&](auto a, auto b) { return part(a) < part(b); });
    radix_sort(keys, first, end);
    ASSERT_TRUE(keys == expected) << first << " to " << end;
  }
}

}  // namespace
}  // namespace colossus::pipeline::ingest
