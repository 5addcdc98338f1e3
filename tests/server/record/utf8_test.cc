#include "server/record/utf8.h"

#include <gtest/gtest.h>

#include <string>

namespace mwidth::record {
namespace {

TEST(Utf8Test, LeavesWellFormedTextAlone) {
  for (const char* text : {"", "plain", "\xC3\xBC", "\xE2\x82\xAC", "\xF0\x9F\x92\xAA", "line\nbreak"}) {
    EXPECT_EQ(WellFormedUtf8(text), text);
  }
}

TEST(Utf8Test, ReplacesEachByteThatIsNone) {
  const std::string mark = kReplacementCharacter;
  EXPECT_EQ(WellFormedUtf8("a\xFF"
                           "b"),
            "a" + mark + "b");
  EXPECT_EQ(WellFormedUtf8("\xC3"), mark) << "cut off";
  EXPECT_EQ(WellFormedUtf8("\xC0\x80"), mark + mark) << "longer than needed";
  EXPECT_EQ(WellFormedUtf8("\xED\xA0\x80"), mark + mark + mark) << "half a surrogate pair";
  EXPECT_EQ(WellFormedUtf8("\xF4\x90\x80\x80"), mark + mark + mark + mark) << "beyond Unicode";
}

}  // namespace
}  // namespace mwidth::record
