#include "client/cli/sweep_range.h"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>

namespace mwidth::cli {
namespace {

TEST(SweepRangeTest, EveryPartIsRead) {
  const auto range = ParseSweepRange("hand-stiffness=1:2e3:33:log");
  EXPECT_EQ(range.parameter(), v1::SWEEP_PARAMETER_HAND_STIFFNESS);
  EXPECT_EQ(range.min(), 1);
  EXPECT_EQ(range.max(), 2000);
  EXPECT_EQ(range.count(), 33U);
  EXPECT_TRUE(range.logarithmic());
}

TEST(SweepRangeTest, CountAndScaleMayBeLeftOut) {
  EXPECT_EQ(ParseSweepRange("cutoff_hz=1:100").count(), 21U);
  EXPECT_FALSE(ParseSweepRange("cutoff-hz=1:100").logarithmic());
  EXPECT_TRUE(ParseSweepRange("cutoff-hz=1:100:log").logarithmic());
  EXPECT_EQ(ParseSweepRange("cutoff-hz=1:100:log").count(), 21U);
}

TEST(SweepRangeTest, EveryParameterOfTheApiHasItsName) {
  for (int i = v1::SweepParameter_MIN + 1; i <= v1::SweepParameter_MAX; ++i) {
    const auto parameter = static_cast<v1::SweepParameter>(i);
    const auto name = ParameterName(parameter);
    EXPECT_EQ(ParseSweepRange(name + "=0:1").parameter(), parameter);
    // A field of LoopParameters, and so an option.
    EXPECT_NE(v1::LoopParameters::descriptor()->FindFieldByName(name), nullptr) << name;
  }
}

TEST(ParameterRangeTest, IsLeastAndGreatest) {
  const auto range = ParseParameterRange("--hand-damping-range", "-1.5:2e3");
  EXPECT_EQ(range.min(), -1.5);
  EXPECT_EQ(range.max(), 2000);
}

TEST(ParameterRangeTest, WhatIsNoRangeIsRefusedWithTheNameOfItsOption) {
  for (const char* text : {"", ":", "5", "5:", ":5", "5:6:7", "a:b", "1:2 "}) {
    try {
      ParseParameterRange("--hand-damping-range", text);
      ADD_FAILURE() << text;
    } catch (const CLI::ValidationError& error) {
      EXPECT_TRUE(std::string(error.what()).starts_with("--hand-damping-range: ")) << error.what();
    }
  }
}

TEST(SweepRangeTest, WhatIsNoRangeIsRefused) {
  for (const char* text :
       {"", "cutoff-hz", "=1:2", "cutoff-hz=", "cutoff-hz=1", "cutoff-hz=1:", "cutoff-hz=1:2:3:4",
        "cutoff-hz=1:2:3.5", "cutoff-hz=1:2:-3", "cutoff-hz=1:log", "cutoff-hz=1:2=3", "unspecified=1:2"}) {
    EXPECT_THROW(ParseSweepRange(text), CLI::ValidationError) << text;
  }
}

}  // namespace
}  // namespace mwidth::cli
