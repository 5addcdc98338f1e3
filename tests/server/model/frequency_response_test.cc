#include "server/model/frequency_response.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>

#include "server/model/continuous_loop.h"
#include "server/model/estimator.h"
#include "server/model/hybrid_simulation.h"
#include "server/model/m_width.h"
#include "tests/server/model/model_loops.h"
#include "tests/server/model/reference_plant.h"

namespace mwidth::model {
namespace {

using std::numbers::pi;
using Complex = std::complex<double>;

struct RealComplex {
  Real re;
  Real im;
};
RealComplex operator*(const RealComplex& a, const RealComplex& b) {
  return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}
RealComplex operator/(const RealComplex& a, const RealComplex& b) {
  const Real size = b.re * b.re + b.im * b.im;
  return {(a.re * b.re + a.im * b.im) / size, (a.im * b.re - a.re * b.im) / size};
}
RealComplex operator+(const RealComplex& a, const RealComplex& b) { return {a.re + b.re, a.im + b.im}; }
RealComplex operator-(const RealComplex& a, const RealComplex& b) { return {a.re - b.re, a.im - b.im}; }

// Eqs. 3, 4 and 10 as printed, in powers of z and 50 digits, the hold split at the delay's fraction by the
// matrix exponential: L/M.
Complex ReferenceLoop(const LoopParameters& loop, double frequency_hz) {
  const Real period = loop.period_s;
  const Real angle = 2 * boost::math::constants::pi<Real>() * Real(frequency_hz) * period;
  const RealComplex z{cos(angle), sin(angle)};
  const RealComplex one{1, 0};
  const Real ticks = Real(loop.delay_s) / period;
  const int whole = static_cast<int>(floor(ticks));
  const Real fraction = ticks - whole;
  const Matrix tick = Exponential(Generator(loop), period);
  const Matrix late = Exponential(Generator(loop), period * (1 - fraction));
  RealComplex force{-late[0][2], 0};
  RealComplex force_v{-late[1][2], 0};
  force = force + RealComplex{late[0][2] - tick[0][2], 0} / z;
  force_v = force_v + RealComplex{late[1][2] - tick[1][2], 0} / z;
  // (z - A) X = B, two by two; the generator's force pushes in the negative direction, so B = -column 2.
  const RealComplex a = z - RealComplex{tick[0][0], 0};
  const RealComplex d = z - RealComplex{tick[1][1], 0};
  const RealComplex b{tick[0][1], 0};
  const RealComplex c{tick[1][0], 0};
  RealComplex position = (d * force + b * force_v) / (a * d - b * c);
  for (int i = 0; i < whole; ++i) {
    position = position / z;
  }
  const Real pole = exp(-2 * boost::math::constants::pi<Real>() * Real(loop.cutoff_hz) * period);
  const RealComplex difference = (z - one) / (RealComplex{period, 0} * z);
  const RealComplex filter = RealComplex{1 - pole, 0} * z / (z - RealComplex{pole, 0});
  const RealComplex result = filter * difference * difference * position;
  return {static_cast<double>(result.re), static_cast<double>(result.im)};
}

TEST(SampledResponse, LoopEqualsThePrintedEquationsIn50Digits) {
  RandomLoops loops(2012);
  for (int i = 0; i < 100; ++i) {
    const LoopParameters loop = loops.Next();
    const double frequency_hz = loops.LogUniform(1e-7, 0.5) / loop.period_s;
    const Complex expected = ReferenceLoop(loop, frequency_hz);
    const Complex found = SampledResponse(loop).Loop(1, frequency_hz);
    // Near a lightly damped resonance the phase itself amplifies rounding of w_n T.
    EXPECT_LT(std::abs(found - expected), 1e-11 * std::abs(expected)) << "loop " << i;
  }
}

TEST(SampledResponse, LoopIsMinusOneAtTheEdgesOfTheMWidth) {
  RandomLoops loops(4);
  for (int i = 0; i < 300; ++i) {
    const LoopParameters loop = loops.Next();
    const MWidth m_width = ComputeMWidth(loop);
    for (const Edge& edge : {m_width.lower, m_width.upper}) {
      EXPECT_LT(std::abs(SampledResponse(loop).Loop(edge.mass, edge.critical_hz) + 1.0), 1e-9)
          << "loop " << i;
    }
  }
}

// The transform of one cycle of the simulated steady state, at `frequency_hz` = whole cycles over `ticks`.
struct Simulated {
  Complex position;
  Complex velocity;
};
Simulated SimulateSteadyState(const LoopParameters& loop, double mass, int cycles, int ticks, int settle) {
  HybridSimulation device(loop);
  AccelerationEstimator estimator(loop.period_s, loop.cutoff_hz);
  Simulated sum;
  const double turn = 2 * pi * cycles / ticks;
  const Complex hand(loop.hand_stiffness, loop.hand_damping * turn / loop.period_s);
  const auto drive = [&](double k) { return (hand * std::polar(1.0, turn * k)).real(); };
  for (int k = 0; k < settle + ticks; ++k) {
    if (k >= settle) {
      const Complex back = std::polar(2.0 / ticks, -turn * k);
      sum.position += device.position() * back;
      sum.velocity += device.velocity() * back;
    }
    device.Command(mass * estimator.Update(device.position()));
    device.AdvanceUnder(drive(k), drive(k + 0.5), drive(k + 1));
  }
  return sum;
}

TEST(SampledResponse, ToHandIsTheSteadyStateOfTheSimulation) {
  LoopParameters loop = TableTwo();
  loop.hand_mass = 0.02;
  loop.device_damping = 0.7;
  for (const double delay_s : {0.0, 0.3e-3, 1e-3, 2.6e-3}) {
    loop.delay_s = delay_s;
    for (const double mass : {0.3, -0.04}) {
      for (const int cycles : {2, 17, 40}) {
        constexpr int kTicks = 2000;
        const double frequency_hz = cycles / (kTicks * loop.period_s);
        const Simulated simulated = SimulateSteadyState(loop, mass, cycles, kTicks, 40000);
        const HandResponse response = SampledResponse(loop).ToHand(mass, frequency_hz);
        // The simulated drive is made of parabolas. Within a tick they are a third order of the angle off the
        // sinusoid, to both sides: the position hardly notices.
        const double angle = 2 * pi * frequency_hz * loop.period_s;
        EXPECT_LT(std::abs(simulated.position - response.position),
                  (std::pow(angle, 4) / 500 + 1e-11) * std::abs(response.position));
        EXPECT_LT(std::abs(simulated.velocity - response.velocity),
                  (std::pow(angle, 3) / 500 + 1e-11) * std::abs(response.velocity));
      }
    }
  }
}

TEST(SampledResponse, ForcesBalanceAtEveryInstant) {
  RandomLoops loops(21);
  for (int i = 0; i < 100; ++i) {
    const LoopParameters loop = loops.Next();
    const MWidth m_width = ComputeMWidth(loop);
    const double mass = loops.Uniform(0.9 * m_width.lower.mass, 0.9 * m_width.upper.mass);
    const double frequency_hz = loops.LogUniform(1e-4, 0.4) / loop.period_s;
    const Complex s(0, 2 * pi * frequency_hz);
    const SampledResponse sampled(loop);
    const HandResponse before = sampled.ToHand(mass, frequency_hz, TickInstant::kBeforeForceStep);
    const HandResponse after = sampled.ToHand(mass, frequency_hz, TickInstant::kAfterForceStep);
    for (const HandResponse& response : {before, after}) {
      // Eq. 2, less what accelerates the hand mass.
      const Complex spring = loop.hand_damping * (s - response.velocity) +
                             loop.hand_stiffness * (1.0 - response.position) -
                             loop.hand_mass * response.acceleration;
      const double size =
          loop.hand_stiffness + loop.hand_damping * std::abs(s) + std::abs(response.hand_force);
      EXPECT_LT(std::abs(spring - response.hand_force), 1e-9 * size) << "loop " << i;
    }
    // Across the step the acceleration changes by the change of the command over the moving mass.
    const CircleFrequency at = AtFrequency(frequency_hz, loop.period_s);
    const Complex commanded = mass * EstimatorOf(loop).Response(at) * after.position;
    const double ticks = loop.delay_s / loop.period_s;
    const double moving_mass = loop.device_mass + loop.hand_mass;
    const Complex step =
        std::abs(ticks - std::round(ticks)) < 1e-12
            ? -commanded * at.w / at.z * std::polar(1.0, std::arg(at.z) * -ticks) / moving_mass
            : 0.0;
    EXPECT_LT(std::abs(after.acceleration - before.acceleration - step),
              1e-9 * (std::abs(after.acceleration) + std::abs(commanded) / moving_mass))
        << "loop " << i;
  }
}

TEST(SampledResponse, ApproachesTheContinuousModelAsThePeriodShrinks) {
  LoopParameters loop = TableTwo();
  double before = 1;
  for (const double period_s : {1e-3, 1e-4, 1e-5}) {
    loop.period_s = period_s;
    const Complex continuous = RenderedStiffness(loop, 0.2, 4);
    const Complex sampled = SampledResponse(loop).ToHand(0.2, 4).hand_force;
    const double off = std::abs(sampled / continuous - 1.0);
    EXPECT_LT(off, before / 5);
    before = off;
  }
}

TEST(EffectiveRatios, OfTheIdealAreTheMassesAndNoDamping) {
  const LoopParameters loop = TableTwo();
  for (const double frequency_hz : {0.1, 5.0, 300.0}) {
    const EffectiveRatios ratios =
        ComputeEffectiveRatios(loop, IdealStiffness(loop, 3 * loop.device_mass, frequency_hz), frequency_hz);
    EXPECT_DOUBLE_EQ(ratios.mass, 4);
    EXPECT_EQ(*ratios.damping, 0);
  }
}

TEST(EffectiveRatios, OfTheDeviceFollowEquation17) {
  const LoopParameters loop = TableTwo();
  const double m = loop.device_mass;
  const double b = loop.device_damping;
  const double b_h = loop.hand_damping;
  const double k_h = loop.hand_stiffness;
  for (const double frequency_hz : {0.01, 1.0, 16.0, 300.0}) {
    const Complex s(0, 2 * pi * frequency_hz);
    const Complex printed = b_h * s * (s + b / m) * (s + k_h / b_h) / (s * s + (b + b_h) / m * s + k_h / m);
    EXPECT_LT(std::abs(RenderedStiffness(loop, 0, frequency_hz) - printed), 1e-13 * std::abs(printed));
  }
  // Far below the resonance: the device as it is.
  const EffectiveRatios slow = ComputeEffectiveRatios(loop, RenderedStiffness(loop, 0, 0.01), 0.01);
  EXPECT_NEAR(slow.mass, 1, 1e-4);
  EXPECT_NEAR(*slow.damping, b / (b + b_h), 1e-5);
}

TEST(EffectiveRatios, OfTheSystemFollowEquation18) {
  const LoopParameters loop = TableTwo();
  const double cutoff = 2 * pi * loop.cutoff_hz;
  for (const double mass_ratio : {3.0, -0.5}) {
    const double mass = mass_ratio * loop.device_mass;
    for (const double frequency_hz : {0.01, 1.0, 16.0, 300.0}) {
      const Complex s(0, 2 * pi * frequency_hz);
      const Complex rendered =
          mass * 4.0 * s * s / std::pow(s * loop.period_s + 2.0, 2) * cutoff / (s + cutoff);
      const Complex device = loop.device_mass * s * s + loop.device_damping * s + rendered;
      const Complex printed = (loop.hand_damping * s + loop.hand_stiffness) * device /
                              (device + loop.hand_damping * s + loop.hand_stiffness);
      EXPECT_LT(std::abs(RenderedStiffness(loop, mass, frequency_hz) - printed), 1e-13 * std::abs(printed));
    }
    // Figure 8: ideal far below the cut-off, like the device alone far above it.
    EXPECT_NEAR(ComputeEffectiveRatios(loop, RenderedStiffness(loop, mass, 0.05), 0.05).mass, 1 + mass_ratio,
                1e-3);
    const double fast_hz = 450;
    EXPECT_NEAR(std::abs(RenderedStiffness(loop, mass, fast_hz) / RenderedStiffness(loop, 0, fast_hz)), 1,
                1e-2);
  }
}

TEST(EffectiveRatios, HaveNoDampingRatioWhereNothingDamps) {
  LoopParameters loop = TableTwo();
  loop.device_damping = loop.hand_damping = 0;
  const EffectiveRatios ratios = ComputeEffectiveRatios(loop, RenderedStiffness(loop, 0, 0.01), 0.01);
  EXPECT_FALSE(ratios.damping);
  EXPECT_NEAR(ratios.mass, 1, 1e-4);
}

}  // namespace
}  // namespace mwidth::model
