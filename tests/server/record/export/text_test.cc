#include "server/record/export/text.h"

#include "server/record/session/session_schema.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstdlib>
#include <limits>
#include <random>

namespace mwidth::record {
namespace {

TEST(TextTest, NumbersReadBackToTheSameBits) {
  std::mt19937_64 random(20261122);
  for (int i = 0; i < 200'000; ++i) {
    const auto value = std::bit_cast<double>(random());
    if (value == value) {
      const std::string text = Number(value);
      EXPECT_EQ(std::bit_cast<uint64_t>(std::strtod(text.c_str(), nullptr)), std::bit_cast<uint64_t>(value))
          << text;
    }
  }
}

TEST(TextTest, NumbersAreAsShortAsTheyCanBe) {
  EXPECT_EQ(Number(0.1), "0.1");
  EXPECT_EQ(Number(-0.0), "-0");
  EXPECT_EQ(Number(1000), "1000");
  EXPECT_EQ(Number(5e-324), "5e-324");
  EXPECT_EQ(Number(std::numeric_limits<double>::infinity()), "inf");
}

TEST(TextTest, TimesAreUtcWithMicroseconds) {
  EXPECT_EQ(UtcTime(0), "1970-01-01T00:00:00.000000Z");
  EXPECT_EQ(UtcTime(1'709'209'799'999'999'999), "2024-02-29T12:29:59.999999Z");
  // Rounded down, also before 1970.
  EXPECT_EQ(UtcTime(-1), "1969-12-31T23:59:59.999999Z");
}

TEST(TextTest, CsvCellsAreQuotedOnlyWhereTheyMustBe) {
  EXPECT_EQ(CsvCell("plain; text"), "plain; text");
  EXPECT_EQ(CsvCell("a,b"), "\"a,b\"");
  EXPECT_EQ(CsvCell("say \"so\""), "\"say \"\"so\"\"\"");
  EXPECT_EQ(CsvCell("two\nlines"), "\"two\nlines\"");
  EXPECT_EQ(CsvCell(""), "");
}

TEST(TextTest, TsvCellsStayInTheirPlace) {
  EXPECT_EQ(TsvCell("a\tb\nc"), "a b c");
  EXPECT_EQ(TsvCell(""), "n/a");
  EXPECT_EQ(TsvCell(" \n "), "n/a");
  EXPECT_EQ(TsvCell("größer"), "größer");
  EXPECT_EQ(TsvCell("\"a\" b"), "\"\"\"a\"\" b\"");
  EXPECT_EQ(TsvCell("{\"a\":1}"), "{\"a\":1}");
}

TEST(TextTest, MetadataIsOneLineOfJson) {
  EXPECT_EQ(MetadataText({}), "{}");
  EXPECT_EQ(MetadataText({{"b", "2\n"}, {"a", "\"1\""}}), R"({"a":"\"1\"","b":"2\n"})");
  // What is no UTF-8 does not keep the rest from being exported.
  EXPECT_EQ(MetadataText({{"a", "\xFF"}}), "{\"a\":\"\xEF\xBF\xBD\"}");
}

}  // namespace
}  // namespace mwidth::record
