// The coders of values and the traversal on their own: whatever goes in comes out, and nonsense ends.
#include <gtest/gtest.h>

#include <random>

#include "codec/coded/renumber.hpp"
#include "codec/predict/adaptive_connectivity.hpp"
#include "codec/predict/basis.hpp"
#include "codec/predict/connectivity.hpp"
#include "codec/predict/values.hpp"
#include "core/error.hpp"

namespace colossus::codec::predict {
namespace {

using mesh::Triangle;
using Random = std::mt19937_64;

std::uint32_t pick(Random& random, std::uint32_t low, std::uint32_t high) {
  return std::uniform_int_distribution<std::uint32_t>(low, high)(random);
}

TEST(Values, TokensTileAllNumbers) {
  std::uint64_t next = 0;
  for (std::uint32_t token = 0; token < kTokens; ++token) {
    EXPECT_EQ(kTokenRanges[token].base, next);
    EXPECT_EQ(token_of(kTokenRanges[token].base), token);
    next += std::uint64_t{1} << kTokenRanges[token].bits;
    EXPECT_EQ(token_of(static_cast<std::uint32_t>(next - 1)), token);
  }
  EXPECT_EQ(next, std::uint64_t{1} << 32);
  for (const std::int32_t value : {0, 1, -1, 2147483647, -2147483647 - 1})
    EXPECT_EQ(to_signed(to_unsigned(value)), value);
}

TEST(Values, DecodeWhatWasEncoded) {
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    constexpr std::uint32_t kContexts = 5;
    std::vector<std::vector<std::uint32_t>> batches(pick(random, 0, 6));
    ValueEncoder encoder(kContexts);
    const std::uint32_t drop = pick(random, 0, 31);
    const auto context_of = [](std::size_t i) { return static_cast<std::uint32_t>(i % (kContexts - 1)); };
    for (auto& batch : batches) {
      batch.resize(pick(random, 0, 100));
      for (std::size_t i = 0; i < batch.size(); ++i) {
        batch[i] = context_of(i) == 2 ? 7 : static_cast<std::uint32_t>(random()) >> drop;
        encoder.put(context_of(i), batch[i]);
      }
      encoder.end_batch();
    }
    const core::Bytes bytes = encoder.finish();
    ValueDecoder decoder(bytes, kContexts, TableLayout::kRuns);
    for (const auto& batch : batches) {
      std::vector<std::uint32_t> values(batch.size());
      decoder.get_batch(values, context_of);
      ASSERT_EQ(values, batch);
    }
    EXPECT_TRUE(decoder.is_done());
    if (bytes.empty()) continue;
    // Any other length is noticed, if not at once.
    const std::span<const std::byte> cut(bytes.data(), bytes.size() - 1);
    ValueDecoder shorter(cut, kContexts, TableLayout::kRuns);
    for (const auto& batch : batches) {
      std::vector<std::uint32_t> values(batch.size());
      shorter.get_batch(values, context_of);
    }
    EXPECT_FALSE(shorter.is_done());
  }
}

TEST(Values, NonsenseEnds) {
  for (std::uint64_t seed = 1; seed <= 500; ++seed) {
    Random random(seed);
    core::Bytes bytes(pick(random, 0, 200));
    for (std::byte& byte : bytes) byte = static_cast<std::byte>(random());
    for (const TableLayout layout : {TableLayout::kEach, TableLayout::kRuns}) {
      ValueDecoder decoder(bytes, 3, layout);
      std::vector<std::uint32_t> values(1000);
      decoder.get_batch(values, [](std::size_t i) { return i % 3; });
      for (std::size_t table = 0; table < decoder.table_count(); ++table) decoder.get_of_table(values, table);
    }
  }
}

// Contexts of like values share a table, others do not, and none is left out.
TEST(Values, ContextsShareTablesWhereThatIsShorter) {
  static constexpr std::size_t kContexts = 40;
  static constexpr std::size_t kCount = 8;
  const auto table_count = [](std::uint32_t per_context, auto token_of_context) {
    std::vector<std::uint32_t> counts(kContexts * kCount);
    for (std::size_t c = 0; c < kContexts; ++c)
      for (std::size_t t = 0; t < kCount; ++t)
        counts[c * kCount + t] = t == token_of_context(c) ? 9 * per_context : t < 2 ? per_context : 0;
    const TableRuns runs = TableRuns::of(counts, kCount);
    EXPECT_EQ(runs.tables().size(), kContexts);
    for (std::size_t c = 1; c < kContexts; ++c) {
      EXPECT_GE(runs.tables()[c], runs.tables()[c - 1]);
      EXPECT_LE(runs.tables()[c], runs.tables()[c - 1] + 1);
    }
    entropy::RangeEncoder encoder;
    runs.write(encoder);
    const core::Bytes bytes = encoder.finish_without_zeros();
    entropy::RangeDecoder decoder(bytes);
    TableRuns again;
    EXPECT_TRUE(again.read(decoder, kContexts));
    EXPECT_EQ(again.table_count(), runs.table_count());
    EXPECT_TRUE(std::equal(again.tables().begin(), again.tables().end(), runs.tables().begin()));
    return runs.table_count();
  };
  EXPECT_EQ(table_count(0, [](std::size_t) { return 0U; }), 0U);
  EXPECT_EQ(table_count(100, [](std::size_t) { return 3U; }), 1U);
  EXPECT_EQ(table_count(100, [](std::size_t c) { return c < 20 ? 3U : 4U; }), 2U);
  EXPECT_EQ(table_count(100, [](std::size_t c) { return c % 2 == 0 ? 3U : 4U; }), kContexts);
  EXPECT_LT(table_count(1, [](std::size_t c) { return c % 2 == 0 ? 3U : 4U; }), kContexts);
}

// More contexts than tables, each with values of its own.
TEST(Values, TablesAreAtMostSoMany) {
  constexpr std::uint32_t kContexts = 3 * kMostTables;
  ValueEncoder encoder(kContexts);
  for (std::uint32_t i = 0; i < 300 * kContexts; ++i) encoder.put(i % kContexts, i % kContexts % 2);
  encoder.end_batch();
  const core::Bytes bytes = encoder.finish();
  ValueDecoder decoder(bytes, kContexts, TableLayout::kRuns);
  EXPECT_EQ(decoder.table_count(), kMostTables);
  std::vector<std::uint32_t> values(300 * kContexts);
  decoder.get_batch(values, [](std::size_t i) { return i % kContexts; });
  for (std::uint32_t i = 0; i < values.size(); ++i) ASSERT_EQ(values[i], i % kContexts % 2);
  EXPECT_TRUE(decoder.is_done());
}

struct Coded {
  coded::CodedPart part;
  core::Bytes bytes;
};

Coded coded(std::vector<Triangle> triangles, std::uint32_t vertex_count) {
  Coded result;
  order_by_traversal(triangles, vertex_count);
  coded::renumber_by_first_use(triangles, vertex_count);
  result.part.triangles = std::move(triangles);
  result.part.positions.resize(vertex_count);
  ConnectivityEncoder encoder;
  LinkStore store(vertex_count);
  encoder.encode(result.part, store);
  result.bytes = encoder.finish();
  return result;
}

void expect_round_trip(const std::vector<Triangle>& triangles, std::uint32_t vertex_count) {
  const Coded from = coded(triangles, vertex_count);
  // Sorted with the least corner first, it is the same set of triangles.
  const auto sorted = [](std::vector<Triangle> all) {
    for (Triangle& t : all) std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
    std::sort(all.begin(), all.end());
    return all;
  };
  std::vector<Triangle> again = from.part.triangles;
  order_by_traversal(again, vertex_count);
  EXPECT_EQ(again, from.part.triangles) << "the order is no fixed point";
  std::vector<Triangle> ordered = triangles;
  order_by_traversal(ordered, vertex_count);
  EXPECT_EQ(sorted(ordered), sorted(triangles));
  coded::CodedPart to;
  to.positions.resize(vertex_count);
  to.triangles.resize(triangles.size());
  ConnectivityDecoder decoder(from.bytes, triangles.size());
  LinkStore store(vertex_count);
  ASSERT_TRUE(decoder.decode(to, store));
  EXPECT_TRUE(decoder.is_done());
  EXPECT_EQ(to.triangles, from.part.triangles);
}

TEST(Traversal, KeepsAnyTriangles) {
  expect_round_trip({}, 0);
  expect_round_trip({{0, 1, 2}}, 3);
  expect_round_trip({{0, 0, 0}}, 1);
  expect_round_trip({{0, 1, 2}, {0, 1, 2}, {2, 1, 0}}, 3);
  for (std::uint64_t seed = 1; seed <= 2000; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const std::uint32_t vertex_count = pick(random, 1, 12);
    std::vector<Triangle> triangles(pick(random, 0, 25));
    for (Triangle& t : triangles)
      for (auto& v : t) v = pick(random, 0, vertex_count - 1);
    expect_round_trip(triangles, vertex_count);
  }
}

std::vector<Triangle> torus(std::uint32_t columns, std::uint32_t rows) {
  std::vector<Triangle> triangles;
  for (std::uint32_t y = 0; y < rows; ++y)
    for (std::uint32_t x = 0; x < columns; ++x) {
      const auto at = [&](std::uint32_t dx, std::uint32_t dy) {
        return (y + dy) % rows * columns + (x + dx) % columns;
      };
      triangles.push_back({at(0, 0), at(1, 0), at(0, 1)});
      triangles.push_back({at(1, 0), at(1, 1), at(0, 1)});
    }
  return triangles;
}

// A regular closed surface with a handle is next to nothing.
TEST(Traversal, KeepsATorusInFewBits) {
  std::vector<Triangle> triangles = torus(60, 50);
  expect_round_trip(triangles, 3000);
  EXPECT_LT(8 * coded(triangles, 3000).bytes.size(), 3000U * 55 / 100);
}

// A vertex of 100,000 triangles, and as many triangles on one edge, take no more time than others.
TEST(Traversal, IsLinearInFansAndFins) {
  constexpr std::uint32_t kCount = 100000;
  std::vector<Triangle> fan;
  std::vector<Triangle> fins;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    fan.push_back({0, i + 1, i + 2});
    fins.push_back({0, 1, i + 2});
  }
  expect_round_trip(fan, kCount + 2);
  expect_round_trip(fins, kCount + 2);
}

template <typename Decoder>
std::size_t count_accepted_nonsense(std::uint64_t seeds, const core::Bytes& start) {
  std::size_t accepted = 0;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    // Other bytes, or a few that are changed.
    core::Bytes bytes = seed % 2 == 0 ? start : core::Bytes(pick(random, 0, 60));
    for (std::byte& byte : bytes)
      if (seed % 2 != 0 || pick(random, 0, 20) == 0) byte = static_cast<std::byte>(random());
    coded::CodedPart part;
    const std::uint32_t vertex_count = pick(random, 0, 40);
    part.positions.resize(vertex_count);
    part.triangles.resize(pick(random, 0, 80));
    Decoder decoder(bytes, part.triangles.size());
    LinkStore store(vertex_count);
    if (!decoder.decode(part, store)) continue;
    ++accepted;
    for (const Triangle& t : part.triangles)
      for (const std::uint32_t v : t) EXPECT_LT(v, vertex_count);
    const Links links = store.first(vertex_count);
    for (std::uint32_t v = 0; v < vertex_count; ++v) {
      if (neighbors_of(links.kinds[v]) > 0) {
        for (const std::uint32_t neighbor : links.of[v].neighbors) EXPECT_LT(neighbor, v);
      }
      if (relations_of(links.kinds[v]) > 0) {
        for (const Relation& r : links.of[v].relations)
          EXPECT_LT(std::max({r.first, r.second, r.opposite}), v);
      }
    }
  }
  return accepted;
}

TEST(Traversal, NonsenseEndsInValidTriangles) {
  const core::Bytes start = coded(torus(6, 5), 30).bytes;
  EXPECT_GT(count_accepted_nonsense<ConnectivityDecoder>(4000, start), 20U);
  EXPECT_GT(count_accepted_nonsense<AdaptiveConnectivityDecoder>(2000, start), 100U);
}

// Whatever a head can say of a frame.
TEST(Basis, IsUnimodularForAnyFrame) {
  for (std::uint64_t seed = 1; seed <= 2000; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    coded::Frame frame{};
    for (auto& row : frame)
      for (auto& entry : row) entry = static_cast<std::int8_t>(static_cast<int>(pick(random, 0, 4)) - 2);
    const Basis basis = basis_of(frame);
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j) {
        std::int32_t product = 0;
        for (std::size_t k = 0; k < 3; ++k) product += basis.to_weights[i][k] * basis.from_weights[k][j];
        EXPECT_EQ(product, i == j ? 1 : 0);
      }
  }
}

}  // namespace
}  // namespace colossus::codec::predict
