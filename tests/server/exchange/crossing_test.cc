#include "server/exchange/crossing.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <memory>
#include <type_traits>

namespace mwidth::exchange {
namespace {

// What a loop in a process of its own would need: shared memory has no constructors to run and no virtual
// tables.
static_assert(std::is_trivially_copyable_v<Settings> && std::is_standard_layout_v<Settings>);
static_assert(std::is_trivially_copyable_v<LoopStatus> && std::is_standard_layout_v<LoopStatus>);
static_assert(std::is_trivially_copyable_v<Sample> && std::is_standard_layout_v<Sample>);
static_assert(std::is_standard_layout_v<Crossing>);

TEST(CrossingTest, BeginsWithNothingToTakeAndSettingsThatRenderNothing) {
  const auto crossing = std::make_unique<Crossing>();
  Settings settings;
  EXPECT_FALSE(crossing->settings.Take(settings));
  EXPECT_FALSE(settings.rendering);
  EXPECT_EQ(settings.mass, 0);
  LoopStatus status;
  EXPECT_FALSE(crossing->status.Take(status));
  EXPECT_EQ(status.state, State::kIdle);
  Sample sample;
  EXPECT_FALSE(crossing->samples.Pop(sample));
}

TEST(CrossingTest, HoldsSamplesForFourSecondsAtOneKilohertz) {
  const auto crossing = std::make_unique<Crossing>();
  for (std::size_t i = 0; i < 4000; ++i) {
    ASSERT_TRUE(crossing->samples.Push({.tick = i}));
  }
}

}  // namespace
}  // namespace mwidth::exchange
