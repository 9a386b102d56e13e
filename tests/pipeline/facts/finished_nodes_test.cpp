#include "pipeline/facts/finished_nodes.hpp"

#include <gtest/gtest.h>

#include <functional>

#include "pipeline/facts/count_table.hpp"
#include "pipeline/facts/level_table.hpp"

namespace colossus::pipeline::facts {
namespace {

TEST(LevelTable, EachSumIsAdded) {
  NodeStatistics sum, one;
  std::uint64_t number = 0;
  for_each_sum([&](const LevelField&, auto member) {
    std::invoke(member, sum) = 100;
    std::invoke(member, one) = ++number;
  });
  sum += one;
  for_each_sum([&](const LevelField& field, auto member) {
    EXPECT_EQ(std::invoke(member, sum), 100 + std::invoke(member, one))
        << (field.column == nullptr ? "not stored" : field.column);
  });
}

TEST(CountTable, EachLineIsAMemberOfItsOwn) {
  InputCounts counts;
  for (const Count& count : kCounts) {
    EXPECT_EQ(counts.*count.member, 0U) << count.name;
    counts.*count.member = 1;
  }
}

}  // namespace
}  // namespace colossus::pipeline::facts
