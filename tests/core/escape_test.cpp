#include "core/escape.hpp"

#include <gtest/gtest.h>

namespace colossus::core {
namespace {

TEST(EscapedText, OfValidUtf8IsItself) {
  for (const char* text : {"", "scan.ply", "a\\b", "\xc3\xa4", "\xe2\x82\xac", "\xed\x9f\xbf", "\xee\x80\x80",
                           "\xf0\x90\x80\x80", "\xf4\x8f\xbf\xbf", "\x7f\n\t"})
    EXPECT_EQ(escaped_text(text), text);
}

TEST(EscapedText, OfOtherBytesShowsThem) {
  EXPECT_EQ(escaped_text("a\xff"), "a\\xff");
  EXPECT_EQ(escaped_text("\\\x80"), "\\\\\\x80");
  EXPECT_EQ(escaped_text("\xc3\xa4\xc3"), "\xc3\xa4\\xc3") << "cut short";
  EXPECT_EQ(escaped_text("\xe2\x82z"), "\\xe2\\x82z");
  EXPECT_EQ(escaped_text("\xc0\xaf"), "\\xc0\\xaf") << "overlong";
  EXPECT_EQ(escaped_text("\xe0\x9f\xbf"), "\\xe0\\x9f\\xbf") << "overlong";
  EXPECT_EQ(escaped_text("\xf0\x8f\xbf\xbf"), "\\xf0\\x8f\\xbf\\xbf") << "overlong";
  EXPECT_EQ(escaped_text("\xed\xa0\x80"), "\\xed\\xa0\\x80") << "a surrogate";
  EXPECT_EQ(escaped_text("\xf4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80") << "above U+10FFFF";
}

}  // namespace
}  // namespace colossus::core
