#include "server/gate/loop_settings.h"

#include <gtest/gtest.h>

#include <memory>

namespace mwidth::gate {
namespace {

using exchange::Settings;
using exchange::State;

class LoopSettingsTest : public testing::Test {
 protected:
  Settings Taken() {
    EXPECT_TRUE(crossing->settings.Take(taken));
    return taken;
  }

  std::unique_ptr<exchange::Crossing> crossing = std::make_unique<exchange::Crossing>();
  LoopSettings loop{*crossing, {.estimator = 1, .cutoff_hz = 30}, 5};
  Settings taken;
};

TEST_F(LoopSettingsTest, NumbersEveryPost) {
  EXPECT_EQ(loop.SetDeadline(7).sequence, 1U);
  EXPECT_EQ(loop.SetMass(0.5, 1).sequence, 2U);
  const Settings settings = Taken();
  EXPECT_EQ(settings.sequence, 2U);
  EXPECT_EQ(settings.lease_deadline_ns, 7);
  EXPECT_EQ(settings.mass, 0.5);
  EXPECT_EQ(settings.ramp_s, 1);
  EXPECT_FALSE(settings.rendering);
}

TEST_F(LoopSettingsTest, BeginsANewEpochWithTheKeptMass) {
  loop.SetMass(0.5, 1);
  EXPECT_EQ(loop.Start().render_epoch, 1U);
  EXPECT_EQ(Taken().mass, 0.5);
  loop.Stop();
  EXPECT_EQ(loop.Start().render_epoch, 2U);
}

TEST_F(LoopSettingsTest, VoidsTheKeptMassWhenARenderingHasEnded) {
  loop.SetMass(0.5, 1);
  crossing->status.Post({.fault = {}, .renderings_ended = 1});
  loop.Start();
  EXPECT_EQ(Taken().mass, 0);
}

TEST_F(LoopSettingsTest, VoidsTheKeptMassWhenAFaultHasCome) {
  loop.SetMass(0.5, 1);
  crossing->status.Post({.fault = {.number = 1}});
  loop.Start();
  EXPECT_EQ(Taken().mass, 0);
}

TEST_F(LoopSettingsTest, KeepsAMassThatWasSetAfterTheLastEndAndFault) {
  crossing->status.Post({.fault = {.number = 3}, .renderings_ended = 8});
  loop.SetMass(0.5, 1);
  loop.Start();
  EXPECT_EQ(Taken().mass, 0.5);
}

TEST_F(LoopSettingsTest, EndsRenderingWithEveryKindOfStop) {
  const auto rendering = [this] {
    loop.SetMass(0.5, 7);
    loop.Start();
  };
  const auto expect_stopped = [this] {
    const Settings settings = Taken();
    EXPECT_FALSE(settings.rendering);
    EXPECT_EQ(settings.mass, 0);
    EXPECT_EQ(settings.ramp_s, Settings{}.ramp_s);
  };
  rendering();
  loop.Stop();
  expect_stopped();
  rendering();
  loop.EmergencyStop();
  expect_stopped();
  EXPECT_EQ(taken.emergency_stops, 1U);
  rendering();
  EXPECT_EQ(loop.ClearFault(4).cleared_fault_number, 4U);
  expect_stopped();
  EXPECT_EQ(taken.cleared_fault_number, 4U);
}

TEST_F(LoopSettingsTest, KnowsWhatTheLoopHasYetToFollow) {
  loop.Start();
  EXPECT_TRUE(loop.StartPending());
  crossing->status.Post({.state = State::kRendering, .fault = {}, .render_epoch = 1});
  EXPECT_FALSE(loop.StartPending());
  EXPECT_FALSE(loop.StopPending());
  loop.Stop();
  EXPECT_TRUE(loop.StopPending());
  crossing->status.Post({.state = State::kReady, .fault = {}, .render_epoch = 1});
  EXPECT_FALSE(loop.StopPending());
}

TEST_F(LoopSettingsTest, PostsTheFilterWithEverything) {
  loop.SetMass(0.5, 1);
  EXPECT_EQ(Taken().filter, (exchange::Filter{.estimator = 1, .cutoff_hz = 30}));
  EXPECT_EQ(taken.critical_hz, 5);
  loop.SetFilter({.estimator = 2, .cutoff_hz = 7}, 3);
  const Settings settings = Taken();
  EXPECT_EQ(settings.filter, (exchange::Filter{.estimator = 2, .cutoff_hz = 7}));
  EXPECT_EQ(settings.critical_hz, 3);
  EXPECT_EQ(settings.mass, 0.5);
}

TEST_F(LoopSettingsTest, ForgetsAVoidMassWithTheFilterThatItWasAdmittedFor) {
  loop.SetMass(0.5, 1);
  EXPECT_EQ(loop.KeptMass(), 0.5);
  crossing->status.Post({.fault = {}, .renderings_ended = 1});
  EXPECT_EQ(loop.KeptMass(), 0);
  loop.SetFilter({.estimator = 2, .cutoff_hz = 7}, 3);
  EXPECT_EQ(Taken().mass, 0);
}

}  // namespace
}  // namespace mwidth::gate
