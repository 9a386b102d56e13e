#include <gtest/gtest.h>
#include <zstd.h>

#include "container/fixtures.hpp"
#include "core/hash.hpp"

namespace colossus::container {
namespace {

using test::make_payload;

TEST(CapacityClass, GrowsByAtMostAQuarter) {
  EXPECT_EQ(class_capacity(0), 4096u);
  EXPECT_EQ(class_capacity(1), 5120u);
  EXPECT_EQ(class_capacity(4), 8192u);
  EXPECT_EQ(class_capacity(kCapacityClassCount - 1), kMaxPayloadBytes);
  for (std::uint32_t k = 1; k < kCapacityClassCount; ++k) {
    EXPECT_LT(class_capacity(k - 1), class_capacity(k));
    EXPECT_LE(4 * class_capacity(k), 5 * class_capacity(k - 1));
  }
}

TEST(CapacityClass, IsTheSmallestThatHolds) {
  EXPECT_EQ(class_for(0), 0u);
  for (std::uint32_t k = 0; k < kCapacityClassCount; ++k) {
    EXPECT_EQ(class_for(class_capacity(k)), k);
    EXPECT_EQ(class_for(class_capacity(k) + 1), k + 1);
  }
}

TEST(PackChunk, RoundTripsEverySizeAroundTheClasses) {
  for (const std::size_t size : {0, 1, 5, 4095, 4096, 4097, 5120, 5121, 100000, 131072, 131073, 1000000}) {
    const core::Bytes payload = make_payload(size, size);
    const PackedChunk chunk = pack_chunk(payload);
    EXPECT_EQ(chunk.payload_bytes, size);
    EXPECT_EQ(chunk.capacity_class, class_for(size));
    EXPECT_EQ(chunk.checksum, core::hash64(chunk.frame));
    const auto unpacked = unpack_chunk(chunk.frame, size);
    ASSERT_TRUE(unpacked.ok()) << unpacked.defect().message;
    EXPECT_EQ(unpacked.value(), payload);
  }
}

TEST(PackChunk, IsOneFrameThatAnyDecoderReadsToTheCapacity) {
  const core::Bytes payload = make_payload(9000, 1);
  const PackedChunk chunk = pack_chunk(payload);
  ASSERT_EQ(ZSTD_getFrameContentSize(chunk.frame.data(), chunk.frame.size()), 10240u);
  core::Bytes content(10240);
  ASSERT_EQ(ZSTD_decompress(content.data(), content.size(), chunk.frame.data(), chunk.frame.size()), 10240u);
  EXPECT_TRUE(std::equal(payload.begin(), payload.end(), content.begin()));
  EXPECT_TRUE(
      std::all_of(content.begin() + 9000, content.end(), [](std::byte b) { return b == std::byte{0}; }));
}

TEST(PackChunk, DoesNotDependOnWhatWasPackedBefore) {
  const core::Bytes payload = make_payload(30000, 1);
  const PackedChunk first = pack_chunk(payload);
  pack_chunk(make_payload(70000, 2));
  EXPECT_EQ(pack_chunk(payload).frame, first.frame);
}

TEST(PackChunk, StoresPaddingInAFewBytes) {
  std::mt19937_64 random(1);
  core::Bytes noise((1 << 20) + 1);
  for (std::byte& b : noise) b = static_cast<std::byte>(random());
  EXPECT_LT(pack_chunk(noise).frame.size(), noise.size() + 100);
}

TEST(UnpackChunk, RefusesEveryTruncation) {
  const PackedChunk chunk = pack_chunk(make_payload(5000, 1));
  for (std::size_t size = 0; size < chunk.frame.size(); ++size)
    ASSERT_FALSE(unpack_chunk(std::span(chunk.frame).first(size), 5000).ok()) << size;
}

TEST(UnpackChunk, RefusesBytesBehindTheFrame) {
  // One byte, and a skippable frame of no bytes, which zstd itself would pass over.
  const std::vector<unsigned char> tails[] = {{0}, {0x50, 0x2a, 0x4d, 0x18, 0, 0, 0, 0}};
  for (const auto& tail : tails) {
    PackedChunk chunk = pack_chunk(make_payload(5000, 1));
    for (const unsigned char byte : tail) chunk.frame.push_back(std::byte{byte});
    EXPECT_FALSE(unpack_chunk(chunk.frame, 5000).ok()) << tail.size();
  }
}

TEST(UnpackChunk, RefusesAnotherPayloadSize) {
  const PackedChunk chunk = pack_chunk(make_payload(5000, 1));
  EXPECT_FALSE(unpack_chunk(chunk.frame, 4096).ok());  // another class
  EXPECT_FALSE(unpack_chunk(chunk.frame, 5121).ok());
  EXPECT_FALSE(unpack_chunk(chunk.frame, 4500).ok());  // the same class, but the rest is not zero
}

TEST(UnpackChunk, RefusesAbsurdSizesWithoutAllocatingThem) {
  const PackedChunk chunk = pack_chunk(make_payload(5000, 1));
  EXPECT_FALSE(unpack_chunk(chunk.frame, ~std::uint64_t{0}).ok());
  EXPECT_FALSE(unpack_chunk(chunk.frame, kMaxPayloadBytes + 1).ok());
  // A frame of one empty raw block whose header promises 1 GiB (single segment, 4-byte content size).
  const unsigned char lie[] = {0x28, 0xb5, 0x2f, 0xfd, 0xa0, 0x00, 0x00, 0x00, 0x40, 0x01, 0x00, 0x00};
  const auto result = unpack_chunk(std::as_bytes(std::span(lie)), kMaxPayloadBytes);
  ASSERT_FALSE(result.ok());
  EXPECT_NE(result.defect().message.find("cannot hold"), std::string::npos) << result.defect().message;
}

}  // namespace
}  // namespace colossus::container
