#include "server/render/encoder_watch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

namespace mwidth::render {
namespace {

using exchange::Fault;

constexpr double kQuantum = 1e-4;

LoopConfig Config() {
  LoopConfig config;
  config.period_s = 1e-3;
  config.watch = {.acceleration_limit = 200, .freeze_velocity = 0.5, .freeze_s = 0.1};
  return config;
}

int64_t CountsOf(double position) { return std::llround(position / kQuantum); }

class EncoderWatchTest : public testing::Test {
 protected:
  /// Moves at `velocity` for `ticks`.
  void Move(double velocity, int ticks) {
    for (int i = 0; i < ticks; ++i) {
      position_ += velocity * 1e-3;
      watch.Follow(CountsOf(position_), 1);
    }
  }

  EncoderWatch watch{Config(), kQuantum};
  double position_ = 0;
};

TEST_F(EncoderWatchTest, SeesNoJumpInAnyMotionWithinTheAccelerationLimitHoweverItIsSampled) {
  std::mt19937_64 random(7);
  for (int history = 0; history < 300; ++history) {
    EncoderWatch careful(Config(), kQuantum);
    // Full acceleration one way or the other, switched at random, between random gaps: exact in x and v.
    double x = std::uniform_real_distribution<double>(-1, 1)(random);
    double v = std::uniform_real_distribution<double>(-5, 5)(random);
    for (int i = 0; i < 300; ++i) {
      const uint64_t periods = random() % 4 == 0 ? 1 + random() % 20 : 1;
      for (uint64_t part = 0; part < 4 * periods; ++part) {
        const double a = random() % 2 == 0 ? 200 : -200;
        const double dt = 1e-3 / 4;
        x += v * dt + a * dt * dt / 2;
        v += a * dt;
      }
      careful.Follow(CountsOf(x), periods);
      ASSERT_NE(careful.Judge().fault, Fault::kEncoderJump) << "history " << history << ", step " << i;
    }
  }
}

TEST_F(EncoderWatchTest, SeesAJumpJustBeyondWhatTheLimitAndTheRoundingAllow) {
  Move(0, 10);
  // 200 m/s^2 and the rounding allow 0.2 + 0.2 m/s in one tick: 4 counts.
  watch.Follow(4, 1);
  EXPECT_EQ(watch.Judge().fault, Fault::kNone);
  EncoderWatch other(Config(), kQuantum);
  other.Follow(0, 1);
  other.Follow(0, 1);
  other.Follow(5, 1);
  const Breach breach = other.Judge();
  EXPECT_EQ(breach.fault, Fault::kEncoderJump);
  EXPECT_NEAR(breach.value, 300, 1e-9);
  EXPECT_EQ(breach.limit, 200);
}

TEST_F(EncoderWatchTest, SeesAJumpInFullMotionAndOneBehindAGap) {
  Move(2, 100);
  watch.Follow(CountsOf(position_ + 2e-3) - 20, 1);
  EXPECT_EQ(watch.Judge().fault, Fault::kEncoderJump);
  EncoderWatch gap(Config(), kQuantum);
  gap.Follow(0, 1);
  gap.Follow(20, 1);
  gap.Follow(120, 5);  // 2 m/s still.
  EXPECT_EQ(gap.Judge().fault, Fault::kNone);
  gap.Follow(220 + 60, 5);
  EXPECT_EQ(gap.Judge().fault, Fault::kEncoderJump);
}

TEST_F(EncoderWatchTest, RemembersAJumpForASecond) {
  Move(0, 10);
  position_ = 0.5;
  watch.Follow(CountsOf(position_), 1);
  Move(0, 999);
  EXPECT_EQ(watch.Judge().fault, Fault::kEncoderJump);
  Move(0, 2);
  EXPECT_NE(watch.Judge().fault, Fault::kEncoderJump);
}

TEST_F(EncoderWatchTest, BeginsAnewBehindAGapTooLongToBridge) {
  Move(1, 10);
  watch.Follow(1'000'000, 1000);
  watch.Follow(1'000'010, 1);
  watch.Follow(1'000'020, 1);
  EXPECT_EQ(watch.Judge().fault, Fault::kNone);
}

TEST_F(EncoderWatchTest, HoldsCountsAtTheEndsOfTheirRange) {
  watch.Follow(INT64_MIN, 1);
  watch.Follow(INT64_MAX, 1);  // One count back, by the wrapping difference.
  watch.Follow(INT64_MAX, 1);
  EXPECT_EQ(watch.Judge().fault, Fault::kNone);
  watch.Follow(0, 1);
  EXPECT_EQ(watch.Judge().fault, Fault::kEncoderJump);
}

TEST_F(EncoderWatchTest, SeesCountsThatStopDeadInMotionAndStay) {
  // Within the acceleration limit, so that it is no jump: 0.55 m/s to 0 is 5.5 counts less two of rounding.
  LoopConfig config = Config();
  config.watch.acceleration_limit = 1000;
  EncoderWatch frozen(config, kQuantum);
  for (int64_t i = 0; i < 100; ++i) {
    frozen.Follow(6 * i, 1);
  }
  for (int i = 0; i < 99; ++i) {
    frozen.Follow(594, 1);
    ASSERT_EQ(frozen.Judge().fault, Fault::kNone);
  }
  frozen.Follow(594, 1);
  const Breach breach = frozen.Judge();
  EXPECT_EQ(breach.fault, Fault::kEncoderFreeze);
  EXPECT_NEAR(breach.value, 0.6, 1e-12);
  EXPECT_EQ(breach.limit, 0.5);
  frozen.Follow(595, 1);  // A count that moves again, slowly, is no proof of a frozen encoder.
  EXPECT_EQ(frozen.Judge().fault, Fault::kNone);
}

TEST_F(EncoderWatchTest, LetsAHandComeToRestAndHoldStillForAsLongAsItLikes) {
  for (int i = 0; i <= 400; ++i) {
    position_ = 0.3 * (1 - std::cos(std::numbers::pi * i / 400)) / 2;
    watch.Follow(CountsOf(position_), 1);
    ASSERT_EQ(watch.Judge().fault, Fault::kNone);
  }
  for (int i = 0; i < 10'000; ++i) {
    watch.Follow(CountsOf(position_), 1);
    ASSERT_EQ(watch.Judge().fault, Fault::kNone);
  }
}

TEST_F(EncoderWatchTest, LetsAHandStopWithinATickFromLessThanTheFreezeVelocity) {
  Move(0.3, 100);
  Move(0, 10'000);
  EXPECT_EQ(watch.Judge().fault, Fault::kNone);
}

}  // namespace
}  // namespace mwidth::render
