#include "server/gate/stability_gate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <utility>

#include "tests/server/gate/axis_fixture.h"

namespace mwidth::gate {
namespace {

using testing::HasSubstr;

constexpr MassLimits kWide{.min = -1e6, .max = 1e6};
constexpr auto kLinear = model::AxisKind::kLinear;

model::LoopParameters PaperLoop() { return PaperAxis().loop; }

model::LoopParameters UndampedLoop() {
  model::LoopParameters loop = PaperLoop();
  loop.device_damping = 0;
  loop.hand_damping = 0;
  return loop;
}

TEST(StabilityGate, TakesItsRangeFromTheModel) {
  const model::MWidth m_width = model::ComputeMWidth(PaperLoop());
  const MassRange range = StabilityGate(PaperLoop(), {.gain_margin_db = 3}).range();
  EXPECT_EQ(range.nominal.min, m_width.lower.mass);
  EXPECT_EQ(range.nominal.max, m_width.upper.mass);
  EXPECT_EQ(range.min_critical_hz, m_width.lower.critical_hz);
  EXPECT_EQ(range.max_critical_hz, m_width.upper.critical_hz);
  EXPECT_EQ(range.required_gain_margin_db, 3);
}

TEST(StabilityGate, ShrinksTheRangeByTheRequiredGainMargin) {
  const MassRange range = StabilityGate(PaperLoop(), {.gain_margin_db = 6}).range();
  EXPECT_NEAR(range.admitted.min, range.robust.min / 1.9952623149688795, 1e-12);
  EXPECT_NEAR(range.admitted.max, range.robust.max / 1.9952623149688795, 1e-12);
  const StabilityGate no_margin(PaperLoop(), {.gain_margin_db = 0});
  EXPECT_EQ(no_margin.range().admitted.max, no_margin.range().robust.max);
}

TEST(StabilityGate, AdmitsExactlyTheMassesThatKeepTheRequiredGainMargin) {
  const StabilityGate gate(PaperLoop(), {.gain_margin_db = 3});
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> around(-2, 2);
  int admitted = 0;
  for (int i = 0; i < 1000; ++i) {
    const double draw = around(random);
    const double mass = draw * std::abs(draw < 0 ? gate.range().nominal.min : gate.range().nominal.max);
    const StabilityReport report = gate.Judge(mass, kWide, kLinear);
    EXPECT_EQ(report.admitted, report.gain_margin_db > 3) << mass;
    admitted += report.admitted ? 1 : 0;
  }
  EXPECT_GT(admitted, 100);
  EXPECT_LT(admitted, 900);
}

TEST(StabilityGate, AdmitsTheNearestAdmittedMassWhenAskedForIt) {
  const StabilityGate gate(PaperLoop(), {.gain_margin_db = 3});
  for (const double mass : {1e3, -1e3, gate.range().admitted.max, gate.range().admitted.min}) {
    const StabilityReport refused = gate.Judge(mass, kWide, kLinear);
    EXPECT_FALSE(refused.admitted) << mass;
    EXPECT_TRUE(gate.Judge(refused.nearest_admitted_mass, kWide, kLinear).admitted) << mass;
    const double edge = mass > 0 ? gate.range().admitted.max : gate.range().admitted.min;
    EXPECT_NEAR(refused.nearest_admitted_mass / edge, 1, 1e-15);
  }
  EXPECT_EQ(gate.Judge(0.01, kWide, kLinear).nearest_admitted_mass, 0.01);
}

TEST(StabilityGate, KeepsTheNearestAdmittedMassWithinTheHardLimits) {
  const StabilityGate gate(PaperLoop(), {.gain_margin_db = 3});
  const MassLimits narrow{.min = -0.01, .max = 0.02};
  EXPECT_EQ(gate.Judge(1e3, narrow, kLinear).nearest_admitted_mass, 0.02);
  EXPECT_EQ(gate.Judge(-1e3, narrow, kLinear).nearest_admitted_mass, -0.01);
}

TEST(StabilityGate, NamesACutOffThatAdmitsTheRefusedMass) {
  const StabilityGate gate(PaperLoop(), {.gain_margin_db = 3});
  const double mass = 1.5 * gate.range().admitted.max;
  const StabilityReport refused = gate.Judge(mass, kWide, kLinear);
  ASSERT_TRUE(refused.admitting_cutoff_hz.has_value());
  model::LoopParameters slower = PaperLoop();
  slower.cutoff_hz = *refused.admitting_cutoff_hz;
  EXPECT_TRUE(StabilityGate(slower, {.gain_margin_db = 3}).Judge(mass, kWide, kLinear).admitted);
  EXPECT_FALSE(gate.Judge(0.01, kWide, kLinear).admitting_cutoff_hz.has_value());
}

TEST(StabilityGate, SaysWhichEdgeBindsAndWhereItOscillates) {
  const StabilityGate gate(PaperLoop(), {.gain_margin_db = 3});
  const StabilityReport lower = gate.Judge(-1e3, kWide, kLinear);
  EXPECT_EQ(lower.critical_hz, gate.range().min_critical_hz);
  EXPECT_THAT(lower.binding, HasSubstr("3 dB"));
  const StabilityReport upper = gate.Judge(1e3, kWide, kLinear);
  EXPECT_EQ(upper.critical_hz, gate.range().max_critical_hz);
  EXPECT_NE(lower.binding, upper.binding);
  EXPECT_THAT(upper.binding, testing::Not(HasSubstr("delay")));
  model::LoopParameters late = PaperLoop();
  late.delay_s = 1e-3;
  EXPECT_THAT(StabilityGate(late, {.gain_margin_db = 3}).Judge(1e3, kWide, kLinear).binding,
              HasSubstr("delay_s at its greatest (0.001)"));
}

TEST(StabilityGate, WithoutAnMWidthAdmitsNothingButZero) {
  const StabilityGate gate(UndampedLoop(), {.gain_margin_db = 3});
  EXPECT_TRUE(gate.range().nominal.empty());
  EXPECT_TRUE(gate.range().admitted.empty());
  for (const double mass : {1e-9, -1e-9, 1.0}) {
    const StabilityReport report = gate.Judge(mass, kWide, kLinear);
    EXPECT_FALSE(report.admitted);
    EXPECT_EQ(report.binding, gate.range().nominal.empty_reason);
    EXPECT_EQ(report.nearest_admitted_mass, 0);
    EXPECT_EQ(report.gain_margin_db, -std::numeric_limits<double>::infinity());
    EXPECT_FALSE(report.admitting_cutoff_hz.has_value());
  }
  EXPECT_TRUE(gate.Judge(0, kWide, kLinear).admitted);
}

TEST(StabilityGate, GivesZeroAnInfiniteMargin) {
  const StabilityReport report = StabilityGate(PaperLoop(), {.gain_margin_db = 3}).Judge(0, kWide, kLinear);
  EXPECT_TRUE(report.admitted);
  EXPECT_EQ(report.gain_margin_db, std::numeric_limits<double>::infinity());
}

TEST(StabilityGate, RefusesAMassThatBuzzesAndNamesTheNearestThatDoesNot) {
  const ForceNoiseLimit limit{.position_quantum = 1e-6, .max_force_noise = 0.01};
  const StabilityGate gate(PaperLoop(), {.gain_margin_db = 3, .noise_limit = limit});
  for (const double mass : {1.5, -0.06}) {
    const double scale = mass > 0 ? 1 : 0.01;
    const StabilityGate strict(PaperLoop(),
                               {.gain_margin_db = 3, .noise_limit = ForceNoiseLimit{1e-6, 0.01 * scale}});
    const StabilityReport noisy = strict.Judge(mass, kWide, kLinear);
    EXPECT_TRUE(noisy.range.admitted.Contains(mass));
    EXPECT_TRUE(noisy.noisy);
    EXPECT_FALSE(noisy.admitted);
    EXPECT_GT(noisy.force_noise, 0.01 * scale);
    EXPECT_THAT(noisy.binding, HasSubstr("are allowed"));
    const double nearest = noisy.nearest_admitted_mass;
    EXPECT_GT(nearest / mass, 0);
    EXPECT_LT(nearest / mass, 1);
    EXPECT_TRUE(strict.Judge(nearest, kWide, kLinear).admitted);
    EXPECT_FALSE(strict.Judge(1.00001 * nearest, kWide, kLinear).admitted);
  }
  EXPECT_TRUE(gate.Judge(0, kWide, kLinear).admitted);
}

TEST(StabilityGate, AdvisesAnUnstableMassWithinTheNoiseLimitToo) {
  const StabilityGate gate(PaperLoop(), {.gain_margin_db = 3, .noise_limit = ForceNoiseLimit{1e-6, 0.01}});
  const StabilityReport unstable = gate.Judge(5, kWide, kLinear);
  EXPECT_FALSE(unstable.admitted);
  EXPECT_FALSE(unstable.noisy);
  EXPECT_FALSE(unstable.force_noise.has_value());
  EXPECT_LT(unstable.nearest_admitted_mass, 0.9 * gate.range().admitted.max);
  EXPECT_TRUE(gate.Judge(unstable.nearest_admitted_mass, kWide, kLinear).admitted);
  // A cut-off that made the mass stable would not do: it must also be quiet there.
  ASSERT_TRUE(unstable.admitting_cutoff_hz.has_value());
  model::LoopParameters slower = PaperLoop();
  slower.cutoff_hz = *unstable.admitting_cutoff_hz;
  EXPECT_TRUE(StabilityGate(slower, {.gain_margin_db = 3, .noise_limit = ForceNoiseLimit{1e-6, 0.01}})
                  .Judge(5, kWide, kLinear)
                  .admitted);
  EXPECT_LT(slower.cutoff_hz,
            StabilityGate(PaperLoop(), {.gain_margin_db = 3}).Judge(5, kWide, kLinear).admitting_cutoff_hz);
}

Requirements ManyHands() {
  return {.gain_margin_db = 3,
          .hand = model::HandEnvelope{.hand_stiffness = {.min = 100, .max = 2000},
                                      .hand_damping = {.min = 2, .max = 20},
                                      .hand_mass = {.min = 0, .max = 0},
                                      .include_released_hand = true}};
}

TEST(StabilityGate, AdmitsWhatEveryHandOfTheEnvelopeHolds) {
  const StabilityGate gate(PaperLoop(), ManyHands());
  const MassRange& range = gate.range();
  EXPECT_EQ(range.nominal.max, StabilityGate(PaperLoop(), {.gain_margin_db = 3}).range().nominal.max);
  EXPECT_LT(range.robust.max, range.nominal.max);
  EXPECT_GT(range.robust.min, range.nominal.min);
  EXPECT_NEAR(range.robust.max / range.admitted.max, 1.4125375446227544, 1e-12);
  std::mt19937_64 random(4);
  const auto uniform = [&](double min, double max) {
    return std::uniform_real_distribution<double>(min, max)(random);
  };
  for (int i = 0; i < 2000; ++i) {
    model::LoopParameters loop = PaperLoop();
    const bool released = i % 10 == 0;
    loop.hand_stiffness = released ? 0 : uniform(100, 2000);
    loop.hand_damping = released ? 0 : uniform(2, 20);
    const model::MWidth m_width = model::ComputeMWidth(loop);
    EXPECT_LE(m_width.lower.mass, range.robust.min);
    EXPECT_GE(m_width.upper.mass, range.robust.max);
  }
  // Tight: the loops that bind are in the envelope and give nothing away.
  for (const auto& [binding, edge] :
       {std::pair{range.min_binding, range.robust.min}, std::pair{range.max_binding, range.robust.max}}) {
    const model::MWidth worst = model::ComputeMWidth(binding.value());
    EXPECT_NEAR((edge < 0 ? worst.lower.mass : worst.upper.mass) / edge, 1, 0.01);
  }
}

TEST(StabilityGate, TellsTheWorstMarginsOfTheLoopAndOfThoseThatBind) {
  const StabilityGate alone(PaperLoop(), {.gain_margin_db = 3});
  EXPECT_EQ(alone.Judge(0.3, kWide, kLinear).margins.modulus.value,
            model::ComputeMargins(PaperLoop(), 0.3).modulus.value);
  const StabilityGate gate(PaperLoop(), ManyHands());
  for (const double mass : {0.9 * gate.range().admitted.min, 0.9 * gate.range().admitted.max}) {
    const model::Margins worst = gate.Judge(mass, kWide, kLinear).margins;
    EXPECT_TRUE(worst.stable);
    const double robust = mass < 0 ? gate.range().robust.min : gate.range().robust.max;
    EXPECT_EQ(worst.gain.value, robust / mass);
    EXPECT_GT(worst.gain.critical_hz, 0);
    const model::Margins nominal = model::ComputeMargins(PaperLoop(), mass);
    EXPECT_LT(worst.gain.value, nominal.gain.value);
    EXPECT_LE(worst.phase_rad.value, nominal.phase_rad.value);
    EXPECT_LE(worst.delay.seconds, nominal.delay.seconds);
    EXPECT_LE(worst.modulus.value, nominal.modulus.value);
  }
  EXPECT_FALSE(gate.Judge(5, kWide, kLinear).margins.stable);
  EXPECT_EQ(gate.Judge(0, kWide, kLinear).margins.gain.value, std::numeric_limits<double>::infinity());
}

TEST(StabilityGate, NamesTheHandThatBinds) {
  const StabilityGate gate(PaperLoop(), ManyHands());
  const StabilityReport lower = gate.Judge(-1, kWide, kLinear);
  EXPECT_THAT(lower.binding, HasSubstr("hand_stiffness at its greatest (2000)"));
  EXPECT_THAT(lower.binding, HasSubstr("proved stable"));
  const model::MWidth stiff = model::ComputeMWidth(gate.range().min_binding.value());
  EXPECT_NEAR(lower.critical_hz, stiff.lower.critical_hz, 1e-9);
  EXPECT_THAT(gate.Judge(5, kWide, kLinear).binding, HasSubstr("the released hand"));
}

TEST(StabilityGate, CountsEveryDelayUpToTheLoopsOwn) {
  model::LoopParameters late = PaperLoop();
  late.delay_s = 2.3e-3;
  const MassRange range = StabilityGate(late, {.gain_margin_db = 3}).range();
  for (int i = 0; i <= 100; ++i) {
    model::LoopParameters loop = late;
    loop.delay_s = late.delay_s * i / 100;
    const model::MWidth m_width = model::ComputeMWidth(loop);
    EXPECT_LE(m_width.lower.mass, range.robust.min);
    EXPECT_GE(m_width.upper.mass, range.robust.max);
  }
}

TEST(StabilityGate, OffersACutOffThatIsProvedForTheWholeEnvelope) {
  const StabilityGate gate(PaperLoop(), ManyHands());
  for (const double mass : {2.0, 4.0, -0.03}) {
    const StabilityReport refused = gate.Judge(mass, kWide, kLinear);
    ASSERT_FALSE(refused.admitted);
    ASSERT_TRUE(refused.admitting_cutoff_hz.has_value()) << mass;
    model::LoopParameters slower = PaperLoop();
    slower.cutoff_hz = *refused.admitting_cutoff_hz;
    EXPECT_TRUE(StabilityGate(slower, ManyHands()).Judge(mass, kWide, kLinear).admitted) << mass;
    // And not far below what would do.
    slower.cutoff_hz *= 1.05;
    EXPECT_FALSE(StabilityGate(slower, ManyHands()).Judge(mass, kWide, kLinear).admitted) << mass;
  }
}

TEST(StabilityGate, AdmitsNothingWhereOneHandOfTheEnvelopeHasNoMWidth) {
  Requirements requirements = ManyHands();
  requirements.hand->hand_damping.min = 0;
  requirements.device = model::DeviceTolerance{.device_mass = {.min = 0.06, .max = 0.08},
                                               .device_damping = {.min = 0, .max = 0.01}};
  const StabilityGate gate(PaperLoop(), requirements);
  EXPECT_FALSE(gate.range().nominal.empty());
  EXPECT_TRUE(gate.range().robust.empty());
  const StabilityReport report = gate.Judge(0.01, kWide, kLinear);
  EXPECT_FALSE(report.admitted);
  EXPECT_THAT(report.binding, HasSubstr("without damping"));
  EXPECT_EQ(report.critical_hz, 0);
  EXPECT_TRUE(gate.Judge(0, kWide, kLinear).admitted);
}

TEST(StabilityGate, VouchesForEveryEstimatorWithManyHands) {
  for (const model::EstimatorKind kind : model::kEstimatorKinds) {
    model::LoopParameters loop = PaperLoop();
    loop.estimator = kind;
    const StabilityGate gate(loop, ManyHands());
    const MassRange& range = gate.range();
    ASSERT_FALSE(range.robust.empty()) << model::Name(kind);
    EXPECT_LT(range.robust.max, range.nominal.max);
    EXPECT_GT(range.robust.min, range.nominal.min);
    EXPECT_EQ(range.min_binding->estimator, kind);
    EXPECT_FALSE(gate.Judge(1.01 * range.admitted.max, kWide, kLinear).admitted);
    EXPECT_TRUE(gate.Judge(0.99 * range.admitted.max, kWide, kLinear).admitted);
  }
}

TEST(StabilityGate, ProvesAnAccelerometersRobustIntervalToo) {
  model::LoopParameters loop = PaperLoop();
  loop.estimator = model::EstimatorKind::kAccelerometer;
  loop.accelerometer_bandwidth_hz = 100;
  const StabilityGate gate(loop, {.gain_margin_db = 3});
  EXPECT_NEAR(gate.range().robust.min / loop.device_mass, -0.885, 1e-3);
  const StabilityGate many(loop, ManyHands());
  EXPECT_GT(many.range().robust.min, gate.range().robust.min);
  EXPECT_LT(many.range().robust.max, gate.range().robust.max);
  EXPECT_EQ(many.range().min_binding->accelerometer_bandwidth_hz, 100);
  const StabilityReport report = many.Judge(0.9 * many.range().admitted.max, kWide, kLinear);
  EXPECT_TRUE(report.admitted);
  EXPECT_GT(report.margins.modulus.value, 0);
  EXPECT_GT(report.margins.delay.seconds, 0);
}

model::LoopParameters FilteredAccelerometer() {
  model::LoopParameters loop = PaperLoop();
  loop.estimator = model::EstimatorKind::kFilteredAccelerometer;
  loop.accelerometer_bandwidth_hz = 10;
  return loop;
}

TEST(StabilityGate, AdmitsWithAnAccelerometerWhatTheToleratedDelayHolds) {
  const double tolerance_s = 2.5e-4;
  const MassRange range =
      StabilityGate(FilteredAccelerometer(), {.gain_margin_db = 3, .delay_tolerance_s = tolerance_s}).range();
  for (int i = 0; i <= 50; ++i) {
    model::LoopParameters late = FilteredAccelerometer();
    late.delay_s = tolerance_s * i / 50;
    const model::MWidth m_width = model::ComputeMWidth(late);
    EXPECT_LE(m_width.lower.mass, range.robust.min);
    EXPECT_GE(m_width.upper.mass, range.robust.max);
  }
  // A gain margin does not stand in for it.
  const StabilityGate punctual(FilteredAccelerometer(), {.gain_margin_db = 3});
  EXPECT_GT(punctual.range().admitted.max, 3 * range.robust.max);
}

TEST(StabilityGate, OffersNoCutOffWithAnAccelerometerWhereItHadToBeProved) {
  const StabilityGate punctual(FilteredAccelerometer(), {.gain_margin_db = 3});
  const double mass = 1.1 * punctual.range().admitted.max;
  EXPECT_TRUE(punctual.Judge(mass, kWide, kLinear).admitting_cutoff_hz.has_value());
  const StabilityGate gate(FilteredAccelerometer(), {.gain_margin_db = 3, .delay_tolerance_s = 2.5e-4});
  const StabilityReport refused = gate.Judge(1.1 * gate.range().admitted.max, kWide, kLinear);
  EXPECT_FALSE(refused.admitted);
  EXPECT_FALSE(refused.admitting_cutoff_hz.has_value());
}

TEST(StabilityGate, RefusesAMassThatBuzzesWithTheCountsOfTheAccelerometer) {
  model::LoopParameters loop = PaperLoop();
  loop.estimator = model::EstimatorKind::kAccelerometer;
  loop.accelerometer_bandwidth_hz = 100;
  ForceNoiseLimit limit{.position_quantum = 1e-6, .max_force_noise = 0.01, .acceleration_quantum = 0.5};
  const double mass = 0.5 * StabilityGate(loop, {.gain_margin_db = 3}).range().admitted.max;
  const StabilityReport refused =
      StabilityGate(loop, {.gain_margin_db = 3, .noise_limit = limit}).Judge(mass, kWide, kLinear);
  EXPECT_FALSE(refused.admitted);
  EXPECT_TRUE(refused.noisy);
  EXPECT_THAT(refused.binding, testing::HasSubstr("accelerometer's counts of 0.5 m/s^2"));
  limit.acceleration_quantum = 0.01;
  EXPECT_TRUE(
      StabilityGate(loop, {.gain_margin_db = 3, .noise_limit = limit}).Judge(mass, kWide, kLinear).admitted);
}

TEST(StabilityGate, RefusesAnEnvelopeThatIsNone) {
  Requirements requirements = ManyHands();
  requirements.hand->hand_damping = {.min = 3, .max = 2};
  EXPECT_THROW(StabilityGate(PaperLoop(), requirements), std::invalid_argument);
}

TEST(StabilityGate, RefusesANoiseLimitThatIsNone) {
  for (const ForceNoiseLimit limit : {ForceNoiseLimit{0, 1}, ForceNoiseLimit{1e-6, 0}}) {
    EXPECT_THROW(StabilityGate(PaperLoop(), {.gain_margin_db = 3, .noise_limit = limit}),
                 std::invalid_argument);
  }
}

TEST(StabilityGate, RefusesParametersThatTheModelDoesNotSupport) {
  model::LoopParameters loop = PaperLoop();
  loop.period_s = 1;
  EXPECT_THROW(StabilityGate(loop, {.gain_margin_db = 3}), std::invalid_argument);
  for (const double margin_db : {-0.1, 61.0, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THROW(StabilityGate(PaperLoop(), {.gain_margin_db = margin_db}), std::invalid_argument);
  }
}

}  // namespace
}  // namespace mwidth::gate
