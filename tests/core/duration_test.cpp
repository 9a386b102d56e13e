#include "core/duration.hpp"

#include <gtest/gtest.h>

namespace colossus::core {
namespace {

TEST(Duration, IsReadAsPeopleAndSlurmWriteIt) {
  EXPECT_EQ(parse_duration("90"), 90.0);
  EXPECT_EQ(parse_duration("90s"), 90.0);
  EXPECT_EQ(parse_duration("45m"), 2700.0);
  EXPECT_EQ(parse_duration("3h50m"), 13800.0);
  EXPECT_EQ(parse_duration("1d12h1s"), 129601.0);
  EXPECT_EQ(parse_duration("50:01"), 3001.0);
  EXPECT_EQ(parse_duration("02:00:01"), 7201.0);
  EXPECT_EQ(parse_duration("1-02"), 93600.0);
  EXPECT_EQ(parse_duration("1-02:30"), 95400.0);
  EXPECT_EQ(parse_duration("1-02:00:00"), 93600.0);
}

TEST(Duration, IsNothingElse) {
  for (const char* text :
       {"",  "0",  "0s", "soon",    "-5", "5x",    "1h30",  "30m1h", "1h1h",       "1.5h",  " 5",  "5 ",
        "s", "1:", ":1", "1:2:3:4", "1-", "-1:00", "1-2-3", "1:2h",  "9999999999", "1001d", "1m-2"})
    EXPECT_EQ(parse_duration(text), std::nullopt) << text;
}

}  // namespace
}  // namespace colossus::core
