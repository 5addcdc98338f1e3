#include "server/render/accelerometer_watch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <random>

#include "server/model/accelerometer_simulation.h"

namespace mwidth::render {
namespace {

using exchange::Fault;

constexpr device::DriveInfo kDrive{.position_quantum = 1e-5,
                                   .force_quantum = 1e-3,
                                   .acceleration_quantum = 0.01,
                                   .accelerometer_bandwidth_hz = 80};

LoopConfig Config() {
  LoopConfig config;
  config.period_s = 1e-3;
  config.watch = {.acceleration_limit = 5000, .freeze_velocity = 0.1, .freeze_s = 0.1};
  return config;
}

double Counted(double value, double quantum) { return std::round(value / quantum) * quantum; }

// A hand that sweeps a device of 0.1 kg to and fro under a force that steps at every tick, and what encoder
// and accelerometer tell of it.
class Arm {
 public:
  Arm(const device::DriveInfo& info, unsigned seed)
      : info_(info),
        random_(seed),
        device_({.device_mass = 0.1,
                 .device_damping = 0.01,
                 .hand_damping = 5,
                 .hand_stiffness = 700,
                 .period_s = 1e-3,
                 .cutoff_hz = 10,
                 .estimator = model::EstimatorKind::kAccelerometer,
                 .accelerometer_bandwidth_hz = info.accelerometer_bandwidth_hz}) {}

  void Move(uint64_t periods = 1) {
    for (uint64_t i = 0; i < periods; ++i) {
      device_.Command(std::uniform_real_distribution<double>(-3, 3)(random_));
      device_.Advance(0.1 * std::sin(0.012 * static_cast<double>(++tick_)));
    }
    const double position = Counted(device_.position(), info_.position_quantum);
    velocity = (position - position_) / (static_cast<double>(periods) * 1e-3);
    position_ = position;
    acceleration = Counted(device_.sensed(), info_.acceleration_quantum);
  }

  double velocity = 0;
  double acceleration = 0;

 private:
  device::DriveInfo info_;
  std::mt19937_64 random_;
  model::AccelerometerSimulation device_;
  uint64_t tick_ = 0;
  double position_ = 0;
};

TEST(AccelerometerWatch, BelievesASensorOfAnyBandwidthAlsoOverGaps) {
  for (const double bandwidth_hz : {5.0, 80.0, 1000.0, 1e5}) {
    device::DriveInfo info = kDrive;
    info.accelerometer_bandwidth_hz = bandwidth_hz;
    AccelerometerWatch watch(Config(), info);
    Arm arm(info, 3);
    for (int i = 0; i < 20'000; ++i) {
      const uint64_t periods = i % 500 == 499 ? 3 : i == 7000 ? 100 : 1;
      arm.Move(periods);
      watch.Follow(arm.velocity, arm.acceleration, periods);
      ASSERT_EQ(watch.Judge().fault, Fault::kNone)
          << bandwidth_hz << " Hz, answer " << i << ": " << watch.Judge().value;
    }
  }
}

// The first answer that a watch does not believe after a second in which all was well; -1 within 3 s.
template <typename Spoil>
int Doubted(const Spoil& spoil) {
  AccelerometerWatch watch(Config(), kDrive);
  Arm arm(kDrive, 4);
  for (int i = 0; i < 4000; ++i) {
    arm.Move();
    double velocity = arm.velocity;
    double acceleration = arm.acceleration;
    if (i >= 1000) {
      spoil(velocity, acceleration);
    }
    watch.Follow(velocity, acceleration, 1);
    const Breach breach = watch.Judge();
    if (breach.fault != Fault::kNone) {
      EXPECT_EQ(breach.fault, Fault::kAccelerometer);
      EXPECT_GT(breach.value, breach.limit);
      return i - 1000;
    }
  }
  return -1;
}

TEST(AccelerometerWatch, DoubtsASensorThatIsStuckReversedBiasedOrOutOfScale) {
  const auto within = [](int answers, int most) { return answers >= 0 && answers <= most; };
  EXPECT_TRUE(within(Doubted([](double&, double& a) { a = 0; }), 400));
  EXPECT_TRUE(within(Doubted([](double&, double& a) { a = 20; }), 30));
  EXPECT_TRUE(within(Doubted([](double&, double& a) { a = -a; }), 400));
  EXPECT_TRUE(within(Doubted([](double&, double& a) { a *= 3; }), 400));
  EXPECT_TRUE(within(Doubted([](double&, double& a) { a += 3; }), 150));
}

TEST(AccelerometerWatch, DoubtsAnAccelerationThatNoJointHasAtOnce) {
  LoopConfig config = Config();
  config.watch.acceleration_limit = 100;
  for (const double sign : {-1.0, 1.0}) {
    // Too short a spike to sum up to anything, and before there is a sum.
    AccelerometerWatch watch(config, kDrive);
    watch.Follow(0, sign * 100, 1);
    EXPECT_EQ(watch.Judge().fault, Fault::kNone);
    watch.Follow(0, sign * 101, 1);
    EXPECT_EQ(watch.Judge().fault, Fault::kAccelerometer);
    EXPECT_EQ(watch.Judge().value, 101);
    EXPECT_EQ(watch.Judge().limit, 100);
    watch.Follow(0, 0, 1);
    EXPECT_NE(watch.Judge().limit, 100);
  }
}

TEST(AccelerometerWatch, DoubtsAFrozenEncoderToo) {
  EXPECT_GE(Doubted([](double& v, double&) { v = 0; }), 0);
}

TEST(AccelerometerWatch, HasNothingToSayWithoutAnAccelerometer) {
  AccelerometerWatch watch(Config(), {.position_quantum = 1e-5, .force_quantum = 1e-3});
  for (int i = 0; i < 100; ++i) {
    watch.Follow(i % 2, 0, 1);
    EXPECT_EQ(watch.Judge().fault, Fault::kNone);
  }
}

}  // namespace
}  // namespace mwidth::render
