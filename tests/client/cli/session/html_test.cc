#include "client/cli/session/html.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>

namespace mwidth::cli::session {
namespace {

TEST(EscapeTest, LeavesNothingThatHtmlReads) {
  EXPECT_EQ(Escape("<a href=\"x\" b='y'>&amp;</a>"),
            "&lt;a href=&quot;x&quot; b=&#39;y&#39;&gt;&amp;amp;&lt;/a&gt;");
  EXPECT_EQ(Escape("Grüße, 你好 🙂\n"), "Grüße, 你好 🙂\n");
}

TEST(EscapeTest, ReplacesWhatIsNoText) {
  const std::string replaced = "\xEF\xBF\xBD";
  EXPECT_EQ(Escape(std::string("a\0b\x1b\x7f", 5)), "a" + replaced + "b" + replaced + replaced);
  EXPECT_EQ(Escape("\xff<"), replaced + "&lt;");
  EXPECT_EQ(Escape("\xc0\xbc"), replaced + replaced);                 // An overlong "<".
  EXPECT_EQ(Escape("\xed\xa0\x80"), replaced + replaced + replaced);  // A surrogate.
  EXPECT_EQ(Escape("\xe4\xbd"), replaced + replaced);                 // Cut off.
  EXPECT_EQ(Escape("\xf4\x90\x80\x80"), replaced + replaced + replaced + replaced);
}

TEST(EscapeTest, LeavesNoTagOfAnyBytes) {
  std::mt19937 random(1);
  for (int i = 0; i < 2000; ++i) {
    std::string bytes(40, '\0');
    for (char& byte : bytes) {
      byte = static_cast<char>(random());
    }
    const std::string escaped = Escape(bytes);
    ASSERT_EQ(escaped.find_first_of("<>\"'"), std::string::npos);
    ASSERT_EQ(Escape(escaped).size() - escaped.size(),
              4 * static_cast<std::size_t>(std::count(escaped.begin(), escaped.end(), '&')))
        << "what is escaped is well-formed";
  }
}

TEST(FixedTest, ShowsNumbersAsPeopleWriteThem) {
  EXPECT_EQ(Fixed(1.25, 1), "1.2");
  EXPECT_EQ(Fixed(-1.5, 1), "−1.5");
  EXPECT_EQ(Fixed(1.5, 1, true), "+1.5");
  EXPECT_EQ(Fixed(-0.001, 1), "0.0");
  EXPECT_EQ(Fixed({}, 3), "–");
  EXPECT_EQ(Fixed(std::nan(""), 3), "–");
  EXPECT_EQ(Fixed(std::numeric_limits<double>::max(), 2).size(), 312);
}

TEST(SignificantTest, ShowsSoManyDigits) {
  EXPECT_EQ(Significant(0.0123456), "0.01235");
  EXPECT_EQ(Significant(-30.0), "−30");
  EXPECT_EQ(Significant(std::numeric_limits<double>::infinity()), "–");
}

TEST(CountedTest, GroupsThousandsAndKnowsOne) {
  EXPECT_EQ(Counted(1, "tick"), "1 tick");
  EXPECT_EQ(Counted(0, "tick"), "0 ticks");
  EXPECT_EQ(Counted(1234567, "sample"), "1\u202f234\u202f567 samples");
  EXPECT_EQ(Counted(999, "sample"), "999 samples");
}

TEST(UtcTextTest, TellsTheSecond) {
  EXPECT_EQ(UtcText(0), "1970-01-01 00:00:00 UTC");
  EXPECT_EQ(UtcText(1'795'329'135'999'999'999), "2026-11-22 06:32:15 UTC");
  EXPECT_EQ(UtcText(-1), "1969-12-31 23:59:59 UTC");
}

}  // namespace
}  // namespace mwidth::cli::session
