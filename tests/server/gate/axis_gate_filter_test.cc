// Changing the filter through the gate.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <limits>
#include <map>
#include <random>
#include <thread>
#include <utility>

#include "server/gate/axis_gate.h"
#include "server/model/m_width.h"
#include "tests/server/gate/axis_fixture.h"

namespace mwidth::gate {
namespace {

using exchange::State;
using model::EstimatorKind;
using testing::HasSubstr;

constexpr FilterRequest kKalman{.estimator = EstimatorKind::kKalman, .cutoff_hz = 12};

class AxisGateFilterTest : public AxisFixture {};

TEST_F(AxisGateFilterTest, ChangesAtOnceWhereNothingIsRendered) {
  const std::string lease = Acquire();
  const Result<FilterGrant> grant = gate.SetFilter(lease, kKalman);
  ASSERT_TRUE(grant.ok());
  EXPECT_EQ(grant->loop.estimator, EstimatorKind::kKalman);
  EXPECT_EQ(grant->loop.cutoff_hz, 12);
  EXPECT_EQ(grant->loop.device_mass, PaperAxis().loop.device_mass);
  EXPECT_EQ(grant->stability.requested_mass, 0);
  EXPECT_EQ(grant->tick, loop.status().tick);
  EXPECT_EQ(loop.status().filter, FilterOf(grant->loop));
}

TEST_F(AxisGateFilterTest, TellsTheLoopHowItOscillatesAtTheNegativeEdge) {
  const std::string lease = Render(-0.01);
  EXPECT_EQ(loop.settings().critical_hz, model::ComputeMWidth(PaperAxis().loop).lower.critical_hz);
  const Result<FilterGrant> grant = gate.SetFilter(lease, kKalman);
  ASSERT_TRUE(grant.ok());
  EXPECT_EQ(loop.settings().critical_hz, model::ComputeMWidth(grant->loop).lower.critical_hz);
}

TEST_F(AxisGateFilterTest, WaitsWhileTheLoopTakesTheMassToZeroAndKeepsTheMass) {
  const std::string lease = Render(0.3);
  loop.HoldFilter(4);
  const Result<FilterGrant> grant = gate.SetFilter(lease, kKalman);
  ASSERT_TRUE(grant.ok());
  EXPECT_EQ(grant->stability.requested_mass, 0.3);
  EXPECT_TRUE(grant->stability.admitted);
  EXPECT_EQ(loop.status().filter, FilterOf(grant->loop));
  EXPECT_EQ(loop.settings().mass, 0.3);
  loop.Tick();
  EXPECT_EQ(loop.status().mass, 0.3);
  EXPECT_EQ(loop.status().state, State::kRendering);
}

TEST_F(AxisGateFilterTest, JudgesMassesByTheNewFilterFromThenOn) {
  const std::string lease = Acquire();
  ASSERT_TRUE(gate.SetMass(lease, {.mass = 1.2, .validate_only = true}).ok());
  ASSERT_TRUE(gate.SetFilter(lease, kKalman).ok());
  EXPECT_EQ(gate.stability()->loop().estimator, EstimatorKind::kKalman);
  const Result<MassGrant> refused = gate.SetMass(lease, {.mass = 1.2});
  ExpectRefused(refused, RefusalCode::kFailedPrecondition, kUnstableMass);
  EXPECT_EQ(refused.refusal().stability->loop.estimator, EstimatorKind::kKalman);
  EXPECT_THAT(refused.refusal().message, HasSubstr("set the filter's cut-off to"));
  EXPECT_TRUE(gate.SetMass(lease, {.mass = refused.refusal().stability->nearest_admitted_mass}).ok());
}

TEST_F(AxisGateFilterTest, RefusesAFilterThatCannotCarryTheMassThatIsSet) {
  const std::string lease = Render(1.2);
  const auto before = loop.settings().sequence;
  const Result<FilterGrant> refused = gate.SetFilter(lease, kKalman);
  ExpectRefused(refused, RefusalCode::kFailedPrecondition, kUnstableMass);
  EXPECT_THAT(refused.refusal().message, HasSubstr("kalman estimator at 12 Hz"));
  EXPECT_THAT(refused.refusal().message, HasSubstr("So does the filter"));
  EXPECT_EQ(refused.refusal().stability->requested_mass, 1.2);
  loop.Tick();
  EXPECT_EQ(loop.settings().sequence, before);
  EXPECT_EQ(loop.status().mass, 1.2);
  EXPECT_EQ(gate.stability()->loop().estimator, EstimatorKind::kFilteredDifference);
  // What the refusal advises is granted, both ways.
  FilterRequest slower = kKalman;
  slower.cutoff_hz = refused.refusal().stability->admitting_cutoff_hz.value();
  EXPECT_TRUE(gate.SetFilter(lease, slower).ok());
  ASSERT_TRUE(gate.SetMass(lease, {.mass = refused.refusal().stability->nearest_admitted_mass}).ok());
  EXPECT_TRUE(gate.SetFilter(lease, kKalman).ok());
}

TEST_F(AxisGateFilterTest, JudgesWithoutChangingWhenAskedOnlyToValidate) {
  const std::string lease = Render(0.3);
  const auto before = loop.settings().sequence;
  FilterRequest request = kKalman;
  request.validate_only = true;
  const Result<FilterGrant> grant = gate.SetFilter(lease, request);
  ASSERT_TRUE(grant.ok());
  EXPECT_EQ(grant->tick, 0U);
  loop.Tick();
  EXPECT_EQ(loop.settings().sequence, before);
  EXPECT_EQ(gate.stability()->loop().estimator, EstimatorKind::kFilteredDifference);
}

TEST_F(AxisGateFilterTest, AsksForLeaseThenNumbersThenState) {
  loop.Tick();
  FilterRequest bad = kKalman;
  bad.cutoff_hz = std::numeric_limits<double>::quiet_NaN();
  ExpectRefused(gate.SetFilter("", bad), RefusalCode::kFailedPrecondition, kNoLease);
  const std::string lease = Acquire();
  EmergencyStop();
  const Result<FilterGrant> refused = gate.SetFilter(lease, bad);
  ExpectRefused(refused, RefusalCode::kInvalidArgument, kInvalidNumber);
  EXPECT_EQ(refused.refusal().metadata.at("field"), "cutoff_hz");
  bad = {.estimator = EstimatorKind::kFilteredAccelerometer, .cutoff_hz = 10};
  const Result<FilterGrant> unsensed = gate.SetFilter(lease, bad);
  ExpectRefused(unsensed, RefusalCode::kInvalidArgument, kInvalidNumber);
  EXPECT_THAT(unsensed.refusal().message, HasSubstr("no accelerometer"));
  bad = {.estimator = static_cast<EstimatorKind>(99), .cutoff_hz = 10};
  EXPECT_EQ(gate.SetFilter(lease, bad).refusal().metadata.at("field"), "estimator");
  ExpectRefused(gate.SetFilter(lease, kKalman), RefusalCode::kFailedPrecondition, kWrongState);
}

AxisDescription LateAxisWithAnAccelerometer() {
  AxisDescription axis = PaperAxis();
  axis.loop.delay_s = 3e-3;
  axis.loop.accelerometer_bandwidth_hz = 100;
  axis.acceleration_quantum = 0.01;
  axis.delay_tolerance_s = 2.5e-4;
  return axis;
}

class LateAxisFilterTest : public AxisFixture {
 protected:
  LateAxisFilterTest() : AxisFixture(LateAxisWithAnAccelerometer()) {}
};

TEST_F(LateAxisFilterTest, RefusesAnAccelerometerWhoseDelaysTheModelDoesNotKnow) {
  const std::string lease = Acquire();
  const Result<FilterGrant> refused =
      gate.SetFilter(lease, {.estimator = EstimatorKind::kAccelerometer, .cutoff_hz = 10});
  ExpectRefused(refused, RefusalCode::kInvalidArgument, kInvalidNumber);
  EXPECT_EQ(refused.refusal().metadata.at("field"), "delay_bound_s");
  EXPECT_TRUE(gate.SetFilter(lease, {.estimator = EstimatorKind::kButterworth, .cutoff_hz = 10}).ok());
}

TEST_F(AxisGateFilterTest, RefusesAChangeWhileAStopRampsDownAndOneThatAFaultOvertakes) {
  const std::string lease = Render(0.3);
  const std::string again = lease;
  silent = true;
  EXPECT_FALSE(gate.StopRendering(lease).ok());
  silent = false;
  ExpectRefused(gate.SetFilter(again, kKalman), RefusalCode::kFailedPrecondition, kWrongState);
  for (int i = 0; i < FakeLoop::kEndTicks; ++i) {
    loop.Tick();
  }
  ASSERT_TRUE(gate.SetMass(lease, {.mass = 0.3}).ok());
  ASSERT_TRUE(gate.StartRendering(lease).ok());
  loop.HoldFilter(8);
  meanwhile = [this] { loop.Trip(exchange::Fault::kVelocityLimit); };
  ExpectRefused(gate.SetFilter(lease, kKalman), RefusalCode::kFailedPrecondition, kWrongState);
}

TEST_F(AxisGateFilterTest, DoesNotHoldAVoidMassAgainstTheFilter) {
  const std::string lease = Render(1.2);
  loop.Trip(exchange::Fault::kVelocityLimit);
  loop.Tick();
  ASSERT_TRUE(gate.ClearFault(lease).ok());
  const Result<FilterGrant> grant = gate.SetFilter(lease, kKalman);
  ASSERT_TRUE(grant.ok());
  EXPECT_EQ(grant->stability.requested_mass, 0);
  ASSERT_TRUE(gate.StartRendering(lease).ok());
  EXPECT_EQ(loop.status().mass, 0);
}

// Masses and filters asked for at the same time by two threads, while the loop ticks: whatever is posted, its
// mass is admitted for its filter.
TEST(AxisGateFilterRace, NeverPostsAMassThatItsFilterDoesNotAdmit) {
  const auto crossing = std::make_unique<exchange::Crossing>();
  FakeClock clock;
  FakeLoop loop(*crossing, clock);
  AxisGate gate(PaperAxis(), *crossing, clock);
  std::atomic<bool> done{false};
  std::map<std::pair<int, double>, StabilityGate> judges;
  int checked = 0;
  std::thread ticker([&] {
    while (!done) {
      loop.Tick();
      const exchange::Settings& settings = loop.settings();
      if (settings.mass == 0) {
        continue;
      }
      model::LoopParameters parameters = PaperAxis().loop;
      parameters.estimator = static_cast<EstimatorKind>(settings.filter.estimator);
      parameters.cutoff_hz = settings.filter.cutoff_hz;
      const auto [judge, is_new] = judges.try_emplace({settings.filter.estimator, settings.filter.cutoff_hz},
                                                      parameters, Requirements{.gain_margin_db = 3});
      EXPECT_TRUE(
          judge->second.Judge(settings.mass, {.min = -50, .max = 50}, model::AxisKind::kLinear).admitted)
          << settings.mass;
      ++checked;
    }
  });
  const std::string lease = gate.AcquireControl("test", 60).value().id;
  int granted = 0;
  std::thread masses([&] {
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> mass(-0.15, 3);
    for (int i = 0; i < 300; ++i) {
      granted += gate.SetMass(lease, {.mass = mass(random)}).ok() ? 1 : 0;
    }
  });
  std::mt19937_64 random(4);
  int changed = 0;
  for (int i = 0; i < 300; ++i) {
    const FilterRequest request{.estimator = model::kEstimatorKinds.at(random() % 4),
                                .cutoff_hz = 5.0 + static_cast<double>(random() % 4) * 10};
    changed += gate.SetFilter(lease, request).ok() ? 1 : 0;
  }
  masses.join();
  done = true;
  ticker.join();
  EXPECT_GT(granted, 20);
  EXPECT_GT(changed, 20);
  EXPECT_GT(checked, 0);
}

}  // namespace
}  // namespace mwidth::gate
