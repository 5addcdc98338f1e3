#include "client/cli/session/movement.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace mwidth::cli::session {
namespace {

constexpr double kPeriodS = 1e-3;
constexpr double kDegree = std::numbers::pi / 180;

record::SessionAxis Axis() {
  return {.name = "elbow",
          .rotary = true,
          .period_s = kPeriodS,
          .position_quantum = 1e-5,
          .force_quantum = 1e-3,
          .force_limit = 10};
}

// Flash and Hogan's reach of 30 degrees in 0.8 s, after 1 s of rest, held for 1 s.
double ReachAt(double time_s, double amplitude = 30 * kDegree) {
  const double u = std::clamp((time_s - 1) / 0.8, 0.0, 1.0);
  return amplitude * u * u * u * (10 - 15 * u + 6 * u * u);
}
double ReachAcceleration(double time_s) {
  const double u = std::clamp((time_s - 1) / 0.8, 0.0, 1.0);
  return 30 * kDegree / 0.64 * (60 * u - 180 * u * u + 120 * u * u * u);
}

template <typename Position>
Trial TrialOf(const Position& position, double mass = 0.1, double rendered = 0.1, double seconds = 2.8) {
  Trial trial;
  trial.filters.emplace_back(0, exchange::Filter{.estimator = 0, .cutoff_hz = 20});
  for (uint64_t k = 0; k < static_cast<uint64_t>(seconds / kPeriodS); ++k) {
    const double t = static_cast<double>(k) * kPeriodS;
    trial.tick.push_back(k + 100);
    trial.position.push_back(position(t));
    trial.mass.push_back(mass);
    trial.force.push_back(rendered * ReachAcceleration(t));
  }
  return trial;
}

Movements Find(const Trial& trial, const Task& task, std::optional<Device> device = Device{0.2, 0.1}) {
  std::string why;
  const auto motion = MotionOf(trial, Axis(), why);
  EXPECT_TRUE(motion.has_value()) << why;
  return FindMovements(*motion, task, device);
}

const Task kTask{.start = 0, .target = 30 * kDegree};

TEST(MovementTest, JudgesAReachWhoseFiguresAreKnown) {
  const auto movements = Find(TrialOf([](double t) { return ReachAt(t); }), kTask);
  ASSERT_EQ(movements.found.size(), 1);
  const Movement& reach = movements.found[0];
  // Velocity 30 u^2 (1-u)^2 amplitude/duration: its peak is 1.875 at the middle, 5 % of it at u = 0.0591 from
  // either end.
  const double peak = 1.875 * 30 * kDegree / 0.8;
  EXPECT_NEAR(reach.peak_velocity, peak, 2e-3 * peak);
  EXPECT_NEAR(reach.movement_time_s, 0.8 * (1 - 2 * 0.0591), 0.004);
  EXPECT_NEAR(reach.time_to_peak_s, reach.movement_time_s / 2, 0.003);
  EXPECT_NEAR(reach.overshoot, 0, 1e-4);
  EXPECT_NEAR(reach.end_error, 0, 0.01 * 30 * kDegree);
  EXPECT_TRUE(reach.came_to_rest);
  EXPECT_TRUE(reach.target_given);
  EXPECT_EQ(reach.mass, 0.1);
  // A mass that is rendered exactly is felt exactly.
  EXPECT_NEAR(*reach.perceived_mass, 0.3, 0.002);
  EXPECT_NEAR(*reach.error, 0, 0.007);
  // A filter of 20 Hz has a lag of 8 ms: at the reach's frequencies some percent of the virtual mass.
  EXPECT_LT(*reach.expected_error, -0.001);
  EXPECT_GT(*reach.expected_error, -0.02);
}

TEST(MovementTest, MeasuresOvershootAndUndershootInPartsOfTheWay) {
  const auto found = [](double amplitude) {
    return Find(TrialOf([amplitude](double t) { return ReachAt(t, amplitude); }), kTask).found.at(0);
  };
  EXPECT_NEAR(found(36 * kDegree).overshoot, 0.2, 1e-3);
  EXPECT_NEAR(found(27 * kDegree).overshoot, -0.1, 1e-3);
  EXPECT_NEAR(found(27 * kDegree).end_error, -3 * kDegree, 0.4 * kDegree);
}

TEST(MovementTest, TellsWhereTheTrialEndedBeforeTheMovement) {
  const auto found = [](double seconds) {
    return Find(TrialOf([](double t) { return ReachAt(t) + 0.02 * std::sin(6 * t) * (t > 1 ? t - 1 : 0); },
                        0.1, 0.1, seconds),
                kTask)
        .found.at(0);
  };
  EXPECT_FALSE(found(1.5).turned);
  EXPECT_FALSE(found(1.5).came_to_rest);
  EXPECT_TRUE(found(2.5).turned);
}

TEST(MovementTest, IsTheSameMirrored) {
  const auto there = Find(TrialOf([](double t) { return ReachAt(t, 33 * kDegree); }), kTask).found.at(0);
  const auto back = Find(TrialOf([](double t) { return -ReachAt(t, 33 * kDegree); }, 0.1, -0.1),
                         {.start = 0, .target = -30 * kDegree})
                        .found.at(0);
  EXPECT_NEAR(back.overshoot, there.overshoot, 1e-12);
  EXPECT_EQ(back.onset, there.onset);
  EXPECT_EQ(back.end, there.end);
  EXPECT_NEAR(back.peak_velocity, -there.peak_velocity, 1e-12);
  EXPECT_NEAR(*back.perceived_mass, *there.perceived_mass, 1e-12);
}

TEST(MovementTest, FindsEveryReachOfATrialAndLeavesOutThoseThatItCutsOff) {
  const auto to_and_fro = [](double t) {
    return 15 * kDegree * (1 - std::cos(2 * std::numbers::pi * t / 2));
  };
  // Three ways there; the first one begins with the trial.
  const auto with_task = Find(TrialOf(to_and_fro, 0.1, 0.1, 6), kTask);
  EXPECT_EQ(with_task.found.size(), 3);
  const auto late = Find(TrialOf([&](double t) { return to_and_fro(t + 0.3); }, 0.1, 0.1, 5.5), kTask);
  EXPECT_EQ(late.found.size(), 2);
  EXPECT_EQ(late.left_out, 1);
}

TEST(MovementTest, WithoutATargetTakesTheRestThatFollowsForIt) {
  const auto there_and_back = [](double t) { return ReachAt(t) - ReachAt(t - 1.5); };
  const auto movements = Find(TrialOf(there_and_back, 0.1, 0.1, 5), {});
  ASSERT_EQ(movements.found.size(), 2);
  EXPECT_FALSE(movements.found[0].target_given);
  EXPECT_NEAR(movements.found[0].target, 30 * kDegree, 0.3 * kDegree);
  EXPECT_NEAR(movements.found[0].overshoot, 0, 0.02);
  EXPECT_GT(movements.found[0].peak_velocity, 0);
  EXPECT_LT(movements.found[1].peak_velocity, 0);
  EXPECT_EQ(movements.left_out, 0);
}

TEST(MovementTest, WithoutATargetLeavesOutWhatComesBack) {
  // There and back without a rest in between, but for 3 degrees; then a reach.
  const auto wave = [](double t) {
    return ReachAt(t, 20 * kDegree) - ReachAt(t - 0.7, 17 * kDegree) + ReachAt(t - 3, 20 * kDegree);
  };
  const auto movements = Find(TrialOf(wave, 0.1, 0.1, 6), {});
  ASSERT_EQ(movements.found.size(), 1);
  EXPECT_NEAR(movements.found[0].start, 3 * kDegree, 0.1 * kDegree);
  EXPECT_EQ(movements.left_out, 0);  // Too short a way to be told of.
  const auto longer = [](double t) {
    return ReachAt(t, 20 * kDegree) - ReachAt(t - 0.7, 14 * kDegree) + ReachAt(t - 3, 20 * kDegree);
  };
  EXPECT_EQ(Find(TrialOf(longer, 0.1, 0.1, 6), {}).left_out, 1);
}

TEST(MovementTest, FindsNothingInAnArmThatRests) {
  const auto jitter = [](double t) { return 1e-5 * static_cast<double>(std::lround(t / kPeriodS) % 3); };
  EXPECT_TRUE(Find(TrialOf(jitter), {}).found.empty());
  EXPECT_TRUE(Find(TrialOf(jitter), kTask).found.empty());
  EXPECT_TRUE(Find(TrialOf([](double) { return 0.0; }), {}).found.empty());
}

TEST(MovementTest, TellsNoErrorOfAMassThatChanged) {
  Trial trial = TrialOf([](double t) { return ReachAt(t); });
  for (std::size_t k = 1400; k < trial.mass.size(); ++k) {
    trial.mass[k] = 0.2;
  }
  const Movement reach = Find(trial, kTask).found.at(0);
  EXPECT_FALSE(reach.mass.has_value());
  EXPECT_FALSE(reach.error.has_value());
  EXPECT_TRUE(reach.perceived_mass.has_value());
}

TEST(MovementTest, TellsNoMassWithoutADevice) {
  const Movement reach = Find(TrialOf([](double t) { return ReachAt(t); }), kTask, std::nullopt).found.at(0);
  EXPECT_FALSE(reach.perceived_mass.has_value());
  EXPECT_FALSE(reach.error.has_value());
  EXPECT_NEAR(reach.peak_force, 0.1 * 5.7735 * 30 * kDegree / 0.64, 0.01);
}

TEST(MotionTest, BridgesShortGapsAndRefusesLongOnes) {
  Trial trial = TrialOf([](double t) { return ReachAt(t); });
  const auto without = [&trial](std::size_t first, std::size_t count) {
    Trial torn = trial;
    for (auto* column : {&torn.position, &torn.force, &torn.mass}) {
      column->erase(column->begin() + static_cast<std::ptrdiff_t>(first),
                    column->begin() + static_cast<std::ptrdiff_t>(first + count));
    }
    torn.tick.erase(torn.tick.begin() + static_cast<std::ptrdiff_t>(first),
                    torn.tick.begin() + static_cast<std::ptrdiff_t>(first + count));
    return torn;
  };
  std::string why;
  const auto whole = MotionOf(trial, Axis(), why);
  const auto bridged = MotionOf(without(1300, 10), Axis(), why);
  ASSERT_TRUE(bridged.has_value());
  EXPECT_EQ(bridged->position.size(), whole->position.size());
  EXPECT_NEAR(bridged->position[1305], whole->position[1305], 1e-4);
  EXPECT_FALSE(MotionOf(without(1300, 11), Axis(), why).has_value());
  EXPECT_EQ(why, "too many ticks in a row have no position");
  trial.tick.resize(60);
  EXPECT_FALSE(MotionOf(trial, Axis(), why).has_value());
  EXPECT_FALSE(MotionOf(Trial{}, Axis(), why).has_value());
}

TEST(TaskTest, ReadsTargetsInEveryUnitOfTheAxis) {
  const auto target = [](const std::string& key, const std::string& value, bool rotary = true) {
    Trial trial;
    trial.metadata = {{key, value}};
    return TaskOf(trial, rotary).target;
  };
  EXPECT_NEAR(*target("target_deg", "30"), 30 * kDegree, 1e-15);
  EXPECT_EQ(target("target_rad", "0.5"), 0.5);
  EXPECT_EQ(target("target", "0.5"), 0.5);
  EXPECT_EQ(target("target_m", "0.1", false), 0.1);
  EXPECT_EQ(target("target", "-1e-1", false), -0.1);
  for (const char* wrong : {"", "thirty", "30 deg", "nan", "inf", " 30"}) {
    EXPECT_EQ(target("target_deg", wrong), std::nullopt) << wrong;
  }
  EXPECT_EQ(target("target_deg", "30", false), std::nullopt);
  EXPECT_EQ(target("target_m", "0.1"), std::nullopt);
  Trial trial;
  trial.metadata = {{"start_deg", "-10"}};
  EXPECT_NEAR(*TaskOf(trial, true).start, -10 * kDegree, 1e-15);
}

}  // namespace
}  // namespace mwidth::cli::session
