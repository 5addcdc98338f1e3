// Hands outside the envelope, under masses that are admitted for it: whether the monitor tells them before
// anything else happens, and whether it leaves alone whoever is inside.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "server/model/m_width.h"
#include "tests/server/render/held_axis.h"

namespace mwidth::render {
namespace {

using exchange::Fault;
using exchange::State;

constexpr uint64_t kSeed = 20120709;

bool TellsOfTheHand(Fault fault) {
  return fault == Fault::kGrowingOscillation || fault == Fault::kEnergyExcess;
}

CertifiedAxis Shipped(const std::string& name) {
  return CertifiedAxis(server::LoadConfig(std::string(CONFIG_DIR "/") + name + ".toml").axes.front());
}

// People who hold half to twice as stiffly, and up to three times as damped.
CertifiedAxis WithEnvelope(const std::string& name) {
  server::AxisConfig axis = Shipped(name).config;
  const model::LoopParameters& loop = axis.loop;
  axis.hand_envelope = {.hand_stiffness = {0.5 * loop.hand_stiffness, 2 * loop.hand_stiffness},
                        .hand_damping = {loop.hand_damping, 3 * loop.hand_damping},
                        .hand_mass = {0.5 * loop.hand_mass, 1.5 * loop.hand_mass},
                        .include_released_hand = false};
  return CertifiedAxis(axis);
}

class Random {
 public:
  double Between(double min, double max) { return std::uniform_real_distribution<>(min, max)(engine_); }
  double Between(const model::ParameterRange& range) { return Between(range.min, range.max); }
  // Reaches like the shipped ones, up to as far and about as fast.
  std::unique_ptr<device::HandMotion> Reach(const server::AxisConfig& axis) {
    const double middle = axis.kind == model::AxisKind::kRotary ? 1.2 : 0.0;
    const double side = Between(0, 1) < 0.5 ? -1 : 1;
    const auto& shipped = std::get<server::HandMotionConfig>(axis.drive.behind);
    return std::make_unique<device::MinimumJerkReach>(
        device::ReachParameters{.start_position = middle,
                                .amplitude = side * Between(0.5, 1) * shipped.amplitude,
                                .duration_s = Between(0.7, 1.2),
                                .hold_s = Between(0.3, 1.5)});
  }

 private:
  std::mt19937_64 engine_{kSeed};
};

// What became of one hand.
struct Outcome {
  exchange::FaultRecord fault;
  // Largest force until then, in parts of the limit.
  double force = 0;
  bool saturated = false;
  bool forceless_afterwards = true;
};

Outcome RenderUntilFault(const CertifiedAxis& axis, HeldAxis& held, double mass, double seconds) {
  held.Render(mass);
  Outcome outcome;
  const auto ticks = static_cast<uint64_t>(seconds / axis.config.loop.period_s);
  while (held.ticks() < ticks && outcome.fault.fault == Fault::kNone) {
    const exchange::Sample& sample = held.Run();
    outcome.force = std::max(outcome.force, std::abs(sample.force) / axis.config.limits.force);
    outcome.saturated = outcome.saturated || sample.saturated;
    outcome.fault = held.Fault();
    outcome.forceless_afterwards = sample.force == 0;
  }
  for (int i = 0; i < 300; ++i) {
    const exchange::Sample& sample = held.Run();
    outcome.forceless_afterwards =
        outcome.forceless_afterwards && sample.force == 0 && sample.state == State::kFault;
  }
  return outcome;
}

// Figures for README.md.
class Figures {
 public:
  void Add(const Outcome& outcome, double periods) {
    forces_.push_back(outcome.force);
    periods_.push_back(periods);
    energy_ += outcome.fault.fault == Fault::kEnergyExcess ? 1 : 0;
  }
  void Print(const std::string& name) {
    std::printf(
        "%s: %zu hands, %d told by their energy; largest force in parts of the limit: median %.2f, 95 %% "
        "%.2f, most %.2f; periods before a limit would have been hit: median %.1f, 5 %% %.1f, least %.1f\n",
        name.c_str(), forces_.size(), energy_, Quantile(forces_, 0.5), Quantile(forces_, 0.95),
        Quantile(forces_, 1), Quantile(periods_, 0.5), Quantile(periods_, 0.05), Quantile(periods_, 0));
  }

 private:
  static double Quantile(std::vector<double> values, double share) {
    std::sort(values.begin(), values.end());
    return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
  }
  std::vector<double> forces_;
  std::vector<double> periods_;
  int energy_ = 0;
};

class UncertifiedHandTest : public testing::TestWithParam<const char*> {
 protected:
  struct Pair {
    model::LoopParameters hand;
    double mass = 0;
  };
  // An admitted mass and a hand that makes it unstable, beyond what the loop's rounding could decide.
  Pair Unstable(const CertifiedAxis& axis, model::ParameterRange stiffness, double most_damping) {
    const model::LoopParameters& certified = axis.config.loop;
    Pair pair{.hand = certified};
    do {
      pair.mass = random.Between(0.4, 1) * axis.stability.range().admitted.min;
      pair.hand.hand_stiffness = certified.hand_stiffness * random.Between(stiffness);
      pair.hand.hand_damping = certified.hand_damping * random.Between(0, most_damping);
      pair.hand.hand_mass = certified.hand_mass * random.Between(0.5, 1.5);
    } while (model::ComputeMWidth(pair.hand).lower.mass < 0.95 * pair.mass);
    return pair;
  }
  // Renders admitted masses with `hands` that are unstable, and expects each to be told in time.
  void ExpectTold(const CertifiedAxis& axis, int hands, model::ParameterRange stiffness,
                  double most_damping) {
    Figures figures;
    for (int i = 0; i < hands; ++i) {
      const auto [hand, mass] = Unstable(axis, stiffness, most_damping);
      const Random as_it_was = random;
      HeldAxis held(axis, hand, random.Reach(axis.config));
      const Outcome outcome = RenderUntilFault(axis, held, mass, 120);
      const std::string who = "hand " + std::to_string(i) + ": k " + std::to_string(hand.hand_stiffness) +
                              ", b " + std::to_string(hand.hand_damping) + ", mass " + std::to_string(mass);
      ASSERT_TRUE(TellsOfTheHand(outcome.fault.fault)) << who;
      EXPECT_FALSE(outcome.saturated) << who;
      EXPECT_LT(outcome.force, 1) << who;
      EXPECT_TRUE(outcome.forceless_afterwards) << who;
      figures.Add(outcome, PeriodsToSpare(axis, hand, mass, as_it_was, outcome.fault.tick));
    }
    figures.Print(testing::UnitTest::GetInstance()->current_test_info()->name());
  }
  // From `tick` until the same hand would have reached a limit, unwatched.
  static double PeriodsToSpare(const CertifiedAxis& axis, const model::LoopParameters& hand, double mass,
                               Random as_it_was, uint64_t tick) {
    LoopConfig unwatched = axis.MakeLoopConfig();
    unwatched.hand_monitor.enabled = false;
    HeldAxis held(axis, unwatched, hand, as_it_was.Reach(axis.config));
    held.Render(mass);
    while (held.ticks() < tick + 60'000 && !held.Run().saturated && held.Fault().fault == Fault::kNone) {
    }
    const double hz = model::ComputeMWidth(hand).lower.critical_hz;
    return static_cast<double>(held.ticks() - tick) * axis.config.loop.period_s * hz;
  }

  Random random;
};

TEST_P(UncertifiedHandTest, WithMuchLessDampingIsToldBeforeAnyLimit) {
  ExpectTold(Shipped(GetParam()), 150, {1, 1}, 0.7);
}

TEST_P(UncertifiedHandTest, WithLessDampingAndOtherStiffnessIsToldBeforeAnyLimit) {
  ExpectTold(Shipped(GetParam()), 150, {0.5, 2.5}, 0.7);
}

TEST_P(UncertifiedHandTest, ThatIsTooStiffIsToldBeforeAnyLimit) {
  ExpectTold(Shipped(GetParam()), 50, {2.5, 5}, 1);
}

TEST_P(UncertifiedHandTest, OutsideAnEnvelopeIsToldBeforeAnyLimit) {
  ExpectTold(WithEnvelope(GetParam()), 100, {0.5, 2}, 0.7);
}

TEST_P(UncertifiedHandTest, NoHandInsideAnEnvelopeIsTakenForOneOutside) {
  const CertifiedAxis axis = WithEnvelope(GetParam());
  const model::HandEnvelope& envelope = axis.config.hand_envelope.value();
  for (int i = 0; i < 40; ++i) {
    model::LoopParameters hand = axis.config.loop;
    hand.hand_stiffness = random.Between(envelope.hand_stiffness);
    hand.hand_damping = i % 2 == 0 ? envelope.hand_damping.min : random.Between(envelope.hand_damping);
    hand.hand_mass = random.Between(envelope.hand_mass);
    const double mass = random.Between(0.6, 1) * axis.stability.range().admitted.min;
    HeldAxis held(axis, hand, random.Reach(axis.config));
    held.Render(mass);
    for (int tick = 0; tick < 30'000; ++tick) {
      ASSERT_TRUE(tick == 0 || held.Run().state == State::kRendering)
          << "hand " << i << ", mass " << mass << ", fault " << static_cast<int>(held.Fault().fault);
    }
  }
}

TEST_P(UncertifiedHandTest, IsToldThoughTicksAreMissed) {
  const CertifiedAxis axis = Shipped(GetParam());
  for (int i = 0; i < 20; ++i) {
    const auto [hand, mass] = Unstable(axis, {1, 1}, 0.7);
    HeldAxis held(axis, hand, random.Reach(axis.config));
    held.Render(mass);
    while (held.ticks() < 120'000 && held.Fault().fault == Fault::kNone) {
      held.Run(random.Between(0, 1) < 0.02 ? 2 : 0);
    }
    EXPECT_TRUE(TellsOfTheHand(held.Fault().fault)) << "hand " << i;
  }
}

INSTANTIATE_TEST_SUITE_P(OfShippedAxes, UncertifiedHandTest, testing::Values("paper", "elbow"),
                         [](const auto& axis) { return std::string(axis.param); });

// A rotary motion on a linear axis.
class Scaled final : public device::HandMotion {
 public:
  Scaled(std::unique_ptr<device::HandMotion> motion, double scale)
      : motion_(std::move(motion)), middle_(motion_->PositionAt(0)), scale_(scale) {}
  double PositionAt(double time_s) const noexcept override {
    return scale_ * (motion_->PositionAt(time_s) - middle_);
  }

 private:
  std::unique_ptr<device::HandMotion> motion_;
  double middle_;
  double scale_;
};

struct Played {
  std::string name;
  std::unique_ptr<device::HandMotion> motion;
  double length_s;
};

// All recordings of the folder MWIDTH_RECORDINGS, or else built-in reaches, as `axis` moves.
std::vector<Played> Motions(const CertifiedAxis& axis) {
  constexpr double kMetresPerRadian = 0.1;
  std::vector<Played> motions;
  const char* folder = std::getenv("MWIDTH_RECORDINGS");  // NOLINT(concurrency-mt-unsafe): one thread
  if (folder == nullptr) {
    Random random;
    for (int i = 0; i < 4; ++i) {
      motions.push_back({"reaches " + std::to_string(i), random.Reach(axis.config), 60});
    }
    return motions;
  }
  for (const auto& file : std::filesystem::directory_iterator(folder)) {
    if (file.path().extension() != ".csv") {
      continue;
    }
    auto recorded = std::make_unique<device::RecordedMotion>(file.path(), model::AxisKind::kRotary);
    const double length_s = recorded->first_pass_s();
    std::unique_ptr<device::HandMotion> motion = std::move(recorded);
    if (axis.config.kind == model::AxisKind::kLinear) {
      motion = std::make_unique<Scaled>(std::move(motion), kMetresPerRadian);
    }
    motions.push_back({file.path().filename(), std::move(motion), length_s});
  }
  return motions;
}

class CertifiedHandTest : public testing::TestWithParam<const char*> {};

TEST_P(CertifiedHandTest, IsLeftAloneInEveryMotionAtEveryMass) {
  const CertifiedAxis axis = Shipped(GetParam());
  const gate::Interval& admitted = axis.stability.range().admitted;
  double seconds = 0;
  for (const double share : {-0.999, -0.9, -0.8, -0.7, -0.5, -0.3, -0.1, 0.0, 0.1, 0.5, 0.9}) {
    const double mass = share * (share < 0 ? -admitted.min : admitted.max);
    for (Played& played : Motions(axis)) {
      HeldAxis held(axis, axis.config.loop, std::move(played.motion));
      held.Render(mass);
      const auto ticks = static_cast<uint64_t>(played.length_s / axis.config.loop.period_s);
      held.Run();
      while (held.ticks() < ticks && held.Run().state == State::kRendering) {
      }
      EXPECT_EQ(held.ticks(), ticks) << played.name << ", mass " << mass << ", fault "
                                     << static_cast<int>(held.Fault().fault);
      seconds += played.length_s;
    }
  }
  std::printf("%s: %.0f s without an alarm\n", GetParam(), seconds);
}

INSTANTIATE_TEST_SUITE_P(OfShippedAxes, CertifiedHandTest, testing::Values("paper", "elbow"),
                         [](const auto& axis) { return std::string(axis.param); });

}  // namespace
}  // namespace mwidth::render
