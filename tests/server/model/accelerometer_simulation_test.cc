#include "server/model/accelerometer_simulation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <random>

#include "server/model/frequency_response.h"
#include "server/model/low_pass.h"
#include "server/model/m_width.h"
#include "tests/server/model/model_loops.h"

namespace mwidth::model {
namespace {

LoopParameters WithAccelerometer(LoopParameters loop, double bandwidth_hz, int index) {
  loop.estimator = kAccelerometerKinds.at(static_cast<std::size_t>(index) % 2);
  loop.accelerometer_bandwidth_hz = bandwidth_hz;
  return loop;
}

// Steps compose: the same forces and the same hand in steps of an eighth, or of the whole.
TEST(AccelerometerSimulation, EndsWhereEighthsOfItsStepEnd) {
  RandomLoops random(41);
  for (int i = 0; i < 200; ++i) {
    LoopParameters loop = WithAccelerometer(random.Next(), random.LogUniform(1, 1e5), i);
    loop.delay_s = 0;
    LoopParameters fine = loop;
    fine.period_s = loop.period_s / 8;
    AccelerometerSimulation whole(loop);
    AccelerometerSimulation eighths(fine);
    double hand = 0;
    double largest = 0;
    for (int k = 0; k < 40; ++k) {
      const double force = random.Uniform(-1, 1);
      const double hand_next = random.Uniform(-1, 1);
      whole.Command(force);
      eighths.Command(force);
      whole.Advance(hand_next);
      for (int part = 1; part <= 8; ++part) {
        eighths.Advance(hand + (hand_next - hand) * part / 8);
        largest = std::max(largest, std::abs(eighths.sensed()));
      }
      ASSERT_NEAR(whole.sensed(), eighths.sensed(), 1e-11 * largest) << i;
      hand = hand_next;
    }
  }
}

TEST(AccelerometerSimulation, SplitsTheDelayInsideTheTick) {
  RandomLoops random(42);
  for (int i = 0; i < 100; ++i) {
    LoopParameters loop = WithAccelerometer(random.Next(), random.LogUniform(1, 1e5), i);
    loop.delay_s = loop.period_s * 1.375;
    LoopParameters fine = loop;
    fine.period_s = loop.period_s / 8;
    fine.delay_s = 0;
    AccelerometerSimulation whole(loop);
    AccelerometerSimulation eighths(fine);
    double past[3] = {0, 0, 0};
    double largest = 0;
    for (int k = 0; k < 40; ++k) {
      past[2] = past[1];
      past[1] = past[0];
      past[0] = random.Uniform(-1, 1);
      whole.Command(past[0]);
      whole.Advance(0);
      for (int part = 0; part < 8; ++part) {
        eighths.Command(part < 3 ? past[2] : past[1]);
        eighths.Advance(0);
        largest = std::max(largest, std::abs(eighths.sensed()));
      }
      ASSERT_NEAR(whole.sensed(), eighths.sensed(), 1e-11 * largest) << i;
    }
  }
}

// A hand that moves as a parabola within each tick drives the sensor as the same parabola cut in eighths.
TEST(AccelerometerSimulation, FollowsAParabolaOfDrive) {
  RandomLoops random(43);
  for (int i = 0; i < 100; ++i) {
    LoopParameters loop = WithAccelerometer(random.Next(), random.LogUniform(1, 1e5), i);
    loop.delay_s = 0;
    LoopParameters fine = loop;
    fine.period_s = loop.period_s / 8;
    AccelerometerSimulation whole(loop);
    AccelerometerSimulation eighths(fine);
    const auto drive = [](double ticks) { return 1 + 0.3 * ticks - 0.7 * ticks * ticks; };
    double largest = 0;
    for (int k = 0; k < 20; ++k) {
      whole.AdvanceUnder(drive(k), drive(k + 0.5), drive(k + 1));
      for (int part = 0; part < 8; ++part) {
        const double from = k + part / 8.0;
        eighths.AdvanceUnder(drive(from), drive(from + 1.0 / 16), drive(from + 1.0 / 8));
        largest = std::max(largest, std::abs(eighths.sensed()));
      }
      ASSERT_NEAR(whole.sensed(), eighths.sensed(), 1e-11 * largest) << i;
    }
  }
}

// A fast sensor tells the acceleration itself: eq. 1 just before the tick.
TEST(AccelerometerSimulation, OfAFastSensorIsTheAcceleration) {
  LoopParameters loop = WithAccelerometer(TableTwo(), 1e6, 0);
  AccelerometerSimulation device(loop);
  device.Reset(1e-3, 0.1, 0);
  device.Command(0.2);
  for (int k = 0; k < 20; ++k) {
    device.Advance(0);
    const double acceleration = -(loop.hand_stiffness * device.position() +
                                  (loop.hand_damping + loop.device_damping) * device.velocity() + 0.2) /
                                loop.device_mass;
    EXPECT_NEAR(device.sensed(), acceleration, 1e-3 * std::abs(acceleration) + 1e-3);
  }
}

// The loop closed by simulation has the frequency response that is computed for it.
TEST(AccelerometerSimulation, SettlesOnTheFrequencyResponse) {
  for (const double delay_ticks : {0.0, 0.4, 1.0}) {
    for (int kind = 0; kind < 2; ++kind) {
      LoopParameters loop = WithAccelerometer(TableTwo(), 120, kind);
      loop.delay_s = delay_ticks * loop.period_s;
      const double mass = 0.6 * ComputeMWidth(loop).upper.mass;
      const double frequency_hz = 7;
      const double rate = 2 * std::numbers::pi * frequency_hz;
      AccelerometerSimulation device(loop);
      FirstOrderLowPass filter(FirstOrderLowPass::Factors(loop.period_s, loop.cutoff_hz));
      const auto drive = [&](double t) {
        return loop.hand_stiffness * std::cos(rate * t) - loop.hand_damping * rate * std::sin(rate * t);
      };
      const std::complex<double> expected = SampledResponse(loop).ToHand(mass, frequency_hz).position;
      for (int k = 0; k < 20000; ++k) {
        const double t = k * loop.period_s;
        if (k > 19000) {
          // Within a tick the parabola is (rate T)^3/120 off the sinusoid at most.
          ASSERT_NEAR(device.position(), (expected * std::polar(1.0, rate * t)).real(), 1e-6) << k;
        }
        device.Command(mass * (kind == 1 ? filter.Update(device.sensed()) : device.sensed()));
        device.AdvanceUnder(drive(t), drive(t + loop.period_s / 2), drive(t + loop.period_s));
      }
    }
  }
}

}  // namespace
}  // namespace mwidth::model
