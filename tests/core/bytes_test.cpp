#include "core/bytes.hpp"

#include <gtest/gtest.h>

#include "core/error.hpp"

namespace colossus::core {
namespace {

TEST(Bytes, ReaderReturnsWhatWasWritten) {
  ByteWriter writer;
  writer.put<std::uint32_t>(7);
  const std::vector<std::uint16_t> values{1, 2, 3};
  writer.put_array<std::uint16_t>(values);
  ByteReader reader(writer.bytes());
  EXPECT_EQ(reader.get<std::uint32_t>(), 7U);
  EXPECT_EQ(reader.get_array<std::uint16_t>(3), values);
  EXPECT_FALSE(reader.failed());
  EXPECT_EQ(reader.remaining(), 0U);
}

TEST(Bytes, ReaderNeverReadsPastItsEndAndSaysSo) {
  const Bytes bytes(5);
  ByteReader reader(bytes);
  EXPECT_EQ(reader.get_array<std::uint32_t>(std::uint64_t{1} << 62).size(), 0U);
  EXPECT_TRUE(reader.failed());
  ByteReader second(bytes);
  second.get<std::uint32_t>();
  EXPECT_FALSE(second.failed());
  second.get<std::uint32_t>();
  EXPECT_TRUE(second.failed());
}

TEST(Result, HoldsAValueOrADefect) {
  const Result<int> good = 3;
  const Result<int> bad = Defect{"short", 12};
  EXPECT_TRUE(good.ok());
  EXPECT_EQ(good.value(), 3);
  EXPECT_FALSE(bad.ok());
  EXPECT_EQ(bad.defect().offset, 12U);
}

}  // namespace
}  // namespace colossus::core
