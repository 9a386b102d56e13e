// Payloads of any bytes into scratch.
#include "pipeline/nodes/store_node.hpp"

#include <gtest/gtest.h>

#include <numeric>
#include <random>

#include "container/chunk.hpp"
#include "core/hash.hpp"
#include "pipeline/facts/catalog.hpp"
#include "pipeline/test_build.hpp"

namespace colossus::pipeline::nodes {
namespace {

// Of few or many different bytes, with the head and the sections at any places.
codec::Payload random_payload(std::mt19937_64& random) {
  codec::Payload payload;
  payload.bytes.resize(100 + random() % 30000);
  const std::uint64_t values = random() % 2 == 0 ? 256 : 5;
  for (std::byte& byte : payload.bytes) byte = static_cast<std::byte>(random() % values);
  for (std::size_t& cut : payload.cuts) cut = random() % (payload.bytes.size() + 1);
  std::sort(payload.cuts.begin(), payload.cuts.end());
  return payload;
}

TEST(StoreNode, KeepsThePayloadOfAnyCodecAndSaysOfTheRowWhatItIs) {
  std::mt19937_64 random(test_seed() + 100 * static_cast<std::uint64_t>(world().rank()));
  const CommonFolder folder;
  const TestBuild build(folder);
  struct Stored {
    codec::Payload payload;
    facts::FinishedNode node;
    const codec::Codec* codec = nullptr;
  };
  std::vector<Stored> all;
  for (const codec::Codec& codec : codec::codecs())
    for (int i = 0; i < 10; ++i) {
      Stored& stored = all.emplace_back();
      stored.payload = random_payload(random);
      stored.codec = &codec;
      stored.node.row.level = 3;
      stored.node.row.center = {1, 2, 3};
      stored.node.row.triangles = 77;
      stored.node.row.error = 0.5;
      store_node(build.workspace(), codec, stored.payload, stored.node);
    }
  build.workspace().writer.flush();
  for (const Stored& stored : all) {
    const container::NodeRow& row = stored.node.row;
    EXPECT_EQ(stored.node.chunk.kind, static_cast<std::uint16_t>(facts::RecordKind::kChunk));
    EXPECT_EQ(stored.node.chunk.file.stream, scratch::kKeptStream) << "it stays when phases are released";
    const core::Bytes frame = build.workspace().reader.read(stored.node.chunk);
    const core::Result<core::Bytes> payload = container::unpack_chunk(frame, row.payload_bytes);
    ASSERT_TRUE(payload.ok());
    EXPECT_EQ(payload.value(), stored.payload.bytes);
    EXPECT_EQ(row.capacity_class, container::class_for(row.payload_bytes));
    EXPECT_EQ(row.stored_bytes, frame.size());
    EXPECT_EQ(row.checksum, core::hash64(frame));
    const container::PackOptions options{stored.codec->zstd_level, stored.payload.cuts};
    const container::PackedChunk packed = container::pack_chunk(stored.payload.bytes, options);
    EXPECT_EQ(frame, packed.frame) << "at the level of " << stored.codec->name;
    // Sections without the head before them and without the rest behind them.
    const auto& components = stored.node.component_bytes;
    EXPECT_EQ(std::accumulate(components.begin(), components.end(), std::uint64_t{0}) +
                  packed.piece_bytes.front() + packed.piece_bytes.back(),
              frame.size());
    for (std::size_t i = 0; i < components.size(); ++i) EXPECT_EQ(components[i], packed.piece_bytes[i + 1]);
    // What others fill in.
    EXPECT_EQ(row.level, 3U);
    EXPECT_EQ(row.center, (std::array<std::int32_t, 3>{1, 2, 3}));
    EXPECT_EQ(row.triangles, 77U);
    EXPECT_EQ(row.error, 0.5);
  }
}

}  // namespace
}  // namespace colossus::pipeline::nodes
