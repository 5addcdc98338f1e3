#include "device/simulated_drive.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>

#include "tests/support/faulty_drive.h"

namespace mwidth::device {
namespace {

class StillHand final : public HandMotion {
 public:
  explicit StillHand(double position) : position_(position) {}
  double PositionAt(double /*time_s*/) const noexcept override { return position_; }

 private:
  double position_;
};

SimulatedDriveConfig PaperDrive() {
  return {.loop = {.device_mass = 0.07,
                   .device_damping = 0.005,
                   .hand_damping = 5,
                   .hand_stiffness = 700,
                   .period_s = 1e-3,
                   .cutoff_hz = 10},
          .position_quantum = 1e-5,
          .force_quantum = 1e-3};
}

std::unique_ptr<HandMotion> Reach() {
  return std::make_unique<MinimumJerkReach>(
      ReachParameters{.start_position = 0.02, .amplitude = 0.1, .duration_s = 0.5, .hold_s = 0.2});
}

std::unique_ptr<SimulatedDrive> DriveOfStillHand(double position = 0) {
  return std::make_unique<SimulatedDrive>(PaperDrive(), std::make_unique<StillHand>(position));
}

TEST(SimulatedDrive, SaysThatNoMotorCanMove) {
  const DriveInfo info = DriveOfStillHand()->Info();
  EXPECT_TRUE(info.simulated);
  EXPECT_EQ(info.position_quantum, 1e-5);
  EXPECT_EQ(info.force_quantum, 1e-3);
}

TEST(SimulatedDrive, BeginsAtRestWhereTheHandIs) {
  const auto drive = DriveOfStillHand(-0.0123456);
  for (const uint64_t tick : {7U, 8U, 9U, 500U}) {
    const Reading reading = drive->Read(tick);
    EXPECT_TRUE(reading.ok);
    EXPECT_EQ(reading.position_counts, -1235);
  }
}

TEST(SimulatedDrive, ReadsTheModelsPositionInWholeCounts) {
  SimulatedDrive drive(PaperDrive(), Reach());
  model::HybridSimulation model(PaperDrive().loop);
  const std::unique_ptr<HandMotion> hand = Reach();
  model.Reset(hand->PositionAt(0), 0, hand->PositionAt(0));
  ASSERT_EQ(drive.Enable(), Enabling::kEnabled);
  for (uint64_t tick = 0; tick < 1500; ++tick) {
    const Reading reading = drive.Read(1000 + tick);
    ASSERT_TRUE(reading.ok);
    ASSERT_EQ(reading.position_counts, std::llround(model.position() / 1e-5));
    const auto force_counts = static_cast<int32_t>(tick % 300) - 100;
    ASSERT_TRUE(drive.Write(force_counts));
    model.Command(force_counts * 1e-3);
    model.Advance(hand->PositionAt(static_cast<double>(tick + 1) * 1e-3));
  }
}

TEST(SimulatedDrive, ReadsTheModelsAccelerometerInWholeCounts) {
  SimulatedDriveConfig config = PaperDrive();
  config.loop.accelerometer_bandwidth_hz = 150;
  config.acceleration_quantum = 0.02;
  SimulatedDrive drive(config, Reach());
  EXPECT_TRUE(drive.Info().senses_acceleration());
  EXPECT_EQ(drive.Info().acceleration_quantum, 0.02);
  EXPECT_EQ(drive.Info().accelerometer_bandwidth_hz, 150);
  model::AccelerometerSimulation model(config.loop);
  const std::unique_ptr<HandMotion> hand = Reach();
  model.Reset(hand->PositionAt(0), 0, hand->PositionAt(0));
  ASSERT_EQ(drive.Enable(), Enabling::kEnabled);
  int largest = 0;
  for (uint64_t tick = 0; tick < 1500; ++tick) {
    const Reading reading = drive.Read(1000 + tick);
    ASSERT_TRUE(reading.ok);
    ASSERT_EQ(reading.position_counts, std::llround(model.position() / 1e-5));
    ASSERT_EQ(reading.acceleration_counts, std::lround(model.sensed() / 0.02));
    largest = std::max(largest, reading.acceleration_counts);
    const auto force_counts = static_cast<int32_t>(tick % 300) - 100;
    ASSERT_TRUE(drive.Write(force_counts));
    model.Command(force_counts * 1e-3);
    model.Advance(hand->PositionAt(static_cast<double>(tick + 1) * 1e-3));
  }
  EXPECT_GT(largest, 50);
}

TEST(SimulatedDrive, HasNoAccelerometerUnlessToldSo) {
  EXPECT_FALSE(DriveOfStillHand()->Info().senses_acceleration());
  EXPECT_EQ(DriveOfStillHand()->Read(0).acceleration_counts, 0);
  SimulatedDriveConfig config = PaperDrive();
  config.acceleration_quantum = 0.02;  // of a sensor without a bandwidth
  EXPECT_THROW(SimulatedDrive(config, Reach()), std::runtime_error);
  config.loop.accelerometer_bandwidth_hz = 150;
  config.acceleration_quantum = -1;
  EXPECT_THROW(SimulatedDrive(config, Reach()), std::runtime_error);
}

TEST(SimulatedDrive, FailsWhereTheAccelerationHasNoCount) {
  SimulatedDriveConfig config = PaperDrive();
  config.loop.accelerometer_bandwidth_hz = 150;
  config.acceleration_quantum = 1e-12;
  SimulatedDrive drive(config, Reach());
  EXPECT_TRUE(drive.Read(0).ok);
  EXPECT_FALSE(drive.Read(300).ok);
}

TEST(SimulatedDrive, MovesOnThroughSkippedTicksUnderTheLastForce) {
  SimulatedDrive every(PaperDrive(), Reach());
  SimulatedDrive skipping(PaperDrive(), Reach());
  for (SimulatedDrive* drive : {&every, &skipping}) {
    drive->Enable();
    drive->Read(0);
    drive->Write(500);
  }
  for (uint64_t tick = 1; tick < 700; ++tick) {
    every.Read(tick);
  }
  EXPECT_EQ(skipping.Read(700).position_counts, every.Read(700).position_counts);
}

TEST(SimulatedDrive, PushesAgainstThePositiveDirection) {
  const auto drive = DriveOfStillHand();
  drive->Enable();
  drive->Read(0);
  ASSERT_TRUE(drive->Write(7000));
  EXPECT_EQ(drive->Read(5000).position_counts, -1000);
}

TEST(SimulatedDrive, TakesNoForceUnlessEnabled) {
  const auto drive = DriveOfStillHand();
  drive->Read(0);
  EXPECT_FALSE(drive->Write(7000));
  EXPECT_TRUE(drive->Write(0));
  EXPECT_EQ(drive->Read(1000).position_counts, 0);
}

TEST(SimulatedDrive, DropsTheForceWhenDisabled) {
  const auto drive = DriveOfStillHand();
  drive->Enable();
  drive->Read(0);
  drive->Write(7000);
  EXPECT_EQ(drive->Read(5000).position_counts, -1000);
  drive->Disable();
  EXPECT_EQ(drive->Read(10000).position_counts, 0);
  drive->Enable();
  EXPECT_EQ(drive->Read(15000).position_counts, 0);
}

TEST(SimulatedDrive, FailsOneReadAfterTooLongAGapAndThenRestsAtTheHand) {
  const auto drive = DriveOfStillHand(0.5);
  drive->Enable();
  drive->Read(0);
  drive->Write(7000);
  EXPECT_TRUE(drive->Read(SimulatedDrive::kMaxGapTicks).ok);
  const uint64_t far = uint64_t{1} << 60;
  EXPECT_FALSE(drive->Read(far).ok);
  EXPECT_EQ(drive->Read(far + 1).position_counts, 50000);
}

TEST(SimulatedDrive, FailsWhereTicksDoNotRise) {
  const auto drive = DriveOfStillHand();
  EXPECT_TRUE(drive->Read(5).ok);
  EXPECT_FALSE(drive->Read(5).ok);
  EXPECT_FALSE(drive->Read(4).ok);
  EXPECT_TRUE(drive->Read(6).ok);
}

TEST(SimulatedDrive, FailsWhereThePositionHasNoCount) {
  SimulatedDriveConfig config = PaperDrive();
  config.position_quantum = 1e-300;
  SimulatedDrive drive(config, std::make_unique<StillHand>(1));
  EXPECT_FALSE(drive.Read(0).ok);
}

TEST(SimulatedDrive, RefusesParametersOutOfRange) {
  SimulatedDriveConfig config = PaperDrive();
  config.loop.period_s = 1;
  EXPECT_THROW(SimulatedDrive(config, Reach()), std::runtime_error);
  for (const double quantum : {0.0, -1.0, std::numeric_limits<double>::infinity()}) {
    config = PaperDrive();
    config.position_quantum = quantum;
    EXPECT_THROW(SimulatedDrive(config, Reach()), std::runtime_error);
    config = PaperDrive();
    config.force_quantum = quantum;
    EXPECT_THROW(SimulatedDrive(config, Reach()), std::runtime_error);
  }
  EXPECT_THROW(SimulatedDrive(PaperDrive(), nullptr), std::runtime_error);
}

TEST(FaultyDrive, FailsAsToldAndOnlyThen) {
  FaultyDrive drive(DriveOfStillHand(0.01));
  drive.RefuseEnable(true);
  EXPECT_EQ(drive.Enable(), Enabling::kRefused);
  drive.RefuseEnable(false);
  EXPECT_EQ(drive.Enable(), Enabling::kEnabled);
  EXPECT_EQ(drive.Read(0).position_counts, 1000);
  drive.SilenceReads(2);
  EXPECT_FALSE(drive.Read(1).ok);
  EXPECT_FALSE(drive.Read(2).ok);
  drive.Jump(-300);
  EXPECT_EQ(drive.Read(3).position_counts, 700);
  drive.RefuseWrites(1);
  EXPECT_FALSE(drive.Write(7000));
  EXPECT_TRUE(drive.Write(7000));
  drive.Freeze(true);
  EXPECT_EQ(drive.Read(5000).position_counts, 700);
  drive.Freeze(false);
  EXPECT_EQ(drive.Read(5001).position_counts, -300);
}

}  // namespace
}  // namespace mwidth::device
