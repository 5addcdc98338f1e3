// An adversary looks for a loop that a certificate overlooked.
//
// MWIDTH_ADVERSARY_POINTS sets how many loops it tries in each of 60 envelopes of each estimator (3000);
// 20000 make more than a million of each.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <limits>
#include <numbers>
#include <string>

#include "server/model/m_width.h"
#include "server/model/robust_interval.h"
#include "tests/server/model/closed_loop.h"
#include "tests/server/model/model_loops.h"

namespace mwidth::model {
namespace {

constexpr int kEnvelopes = 60;
using Seconds = std::chrono::duration<double>;

int PointsOfAnEnvelope() {
  const char* points = std::getenv("MWIDTH_ADVERSARY_POINTS");
  return points == nullptr ? 3000 : std::stoi(points);
}

// Position in an envelope: a number 0..1 for each of its six ranges.
using Place = std::array<double, 6>;

LoopParameters At(const LoopEnvelope& envelope, const Place& place, bool released) {
  const auto along = [](const ParameterRange& range, double way) {
    return std::min(range.min + way * (range.max - range.min), range.max);
  };
  LoopParameters loop{.device_mass = along(envelope.device.device_mass, place[0]),
                      .device_damping = along(envelope.device.device_damping, place[1]),
                      .hand_mass = along(envelope.hand.hand_mass, place[2]),
                      .hand_damping = along(envelope.hand.hand_damping, place[3]),
                      .hand_stiffness = along(envelope.hand.hand_stiffness, place[4]),
                      .period_s = envelope.period_s,
                      .cutoff_hz = envelope.cutoff_hz,
                      .delay_s = envelope.delay_bound_s * place[5],
                      .estimator = envelope.estimator,
                      .accelerometer_bandwidth_hz = envelope.accelerometer_bandwidth_hz};
  if (released) {
    loop.hand_damping = loop.hand_stiffness = 0;
    loop.hand_mass = envelope.hand.hand_mass.max * place[2];
  }
  return loop;
}

// Wide boxes and narrow ones, of hands from slack to stiff. In three of ten the device may have no damping,
// in one of ten the hand neither (and then no stiffness); half count the released hand.
LoopEnvelope RandomEnvelope(RandomLoops& random, int index, EstimatorKind estimator) {
  const auto range = [&random](double low, double high, double spread) {
    const double first = random.LogUniform(low, high);
    return ParameterRange{.min = first, .max = first * random.LogUniform(1, spread)};
  };
  LoopEnvelope envelope;
  envelope.estimator = estimator;
  envelope.period_s = random.LogUniform(1e-4, 4e-3);
  envelope.cutoff_hz = random.LogUniform(1, 0.48 / envelope.period_s);
  envelope.delay_bound_s = index % 4 == 0 ? 0 : envelope.period_s * random.Uniform(0, 3);
  envelope.device.device_mass = range(1e-2, 1e1, 1.3);
  envelope.device.device_damping = range(1e-4, 1, 10);
  envelope.hand.hand_damping = range(1e-2, 30, 20);
  envelope.hand.hand_stiffness = range(1, 3e3, 30);
  if (index % 3 == 0) {
    envelope.hand.hand_mass = {.min = 0, .max = random.LogUniform(1e-3, 1)};
  }
  // Above a tenth of the sample rate there is no hand.
  const double angle = 2 * std::numbers::pi / 10;
  const double stiffest = envelope.device.device_mass.min * std::pow(angle / envelope.period_s, 2);
  envelope.hand.hand_stiffness.max = std::min(envelope.hand.hand_stiffness.max, stiffest);
  envelope.hand.hand_stiffness.min =
      std::min(envelope.hand.hand_stiffness.min, envelope.hand.hand_stiffness.max);
  if (index % 10 < 3) {
    envelope.device.device_damping.min = 0;
  }
  if (index % 10 == 0) {
    envelope.hand.hand_damping.min = 0;
    envelope.hand.hand_stiffness = {};
  }
  envelope.hand.include_released_hand = index % 2 == 0;
  if (IsAccelerometer(estimator)) {
    envelope.accelerometer_bandwidth_hz = random.LogUniform(0.02, 2) / envelope.period_s;
  }
  return envelope;
}

// Tries loops of one envelope at random, and walks downhill from the best in ever smaller steps.
class Adversary {
 public:
  Adversary(const LoopEnvelope& envelope, RandomLoops& random) : envelope_(envelope), random_(random) {}

  void Search(int points) {
    for (int i = 0; i < points; ++i) {
      const bool walk = i % 2 == 1;
      Place place{};
      const bool upper = i % 4 == 1;
      const Found& from = upper ? upper_ : lower_;
      for (std::size_t k = 0; k < place.size(); ++k) {
        // Beyond an end is that end: a third of the random points are on each face.
        const double step = std::pow(10, random_.Uniform(-5, 0));
        place[k] = walk ? from.place[k] + step * random_.Uniform(-1, 1) : random_.Uniform(-0.5, 1.5);
        place[k] = std::clamp(place[k], 0.0, 1.0);
      }
      const bool released =
          envelope_.hand.include_released_hand && (walk ? from.released : random_.Uniform(0, 4) < 1);
      Try(place, released);
    }
  }

  double lower() const { return lower_.mass; }
  double upper() const { return upper_.mass; }
  LoopParameters worst_lower() const { return At(envelope_, lower_.place, lower_.released); }
  LoopParameters worst_upper() const { return At(envelope_, upper_.place, upper_.released); }

 private:
  struct Found {
    double mass;
    Place place{};
    bool released = false;
  };

  void Try(const Place& place, bool released) {
    const MWidth width = ComputeMWidth(At(envelope_, place, released));
    ASSERT_FALSE(width.empty());
    if (width.lower.mass > lower_.mass) {
      lower_ = {width.lower.mass, place, released};
    }
    if (width.upper.mass < upper_.mass) {
      upper_ = {width.upper.mass, place, released};
    }
  }

  const LoopEnvelope& envelope_;
  RandomLoops& random_;
  Found lower_{-std::numeric_limits<double>::infinity()};
  Found upper_{std::numeric_limits<double>::infinity()};
};

bool Holds(const ParameterRange& range, double value) { return range.min <= value && value <= range.max; }

void ExpectMember(const LoopEnvelope& envelope, const LoopParameters& loop) {
  const bool released =
      envelope.hand.include_released_hand && loop.hand_damping == 0 && loop.hand_stiffness == 0;
  EXPECT_TRUE(Holds(envelope.device.device_mass, loop.device_mass));
  EXPECT_TRUE(Holds(envelope.device.device_damping, loop.device_damping));
  EXPECT_TRUE(released || Holds(envelope.hand.hand_stiffness, loop.hand_stiffness));
  EXPECT_TRUE(released || Holds(envelope.hand.hand_damping, loop.hand_damping));
  EXPECT_TRUE(
      Holds({released ? 0 : envelope.hand.hand_mass.min, envelope.hand.hand_mass.max}, loop.hand_mass));
  EXPECT_TRUE(Holds({0, envelope.delay_bound_s}, loop.delay_s));
}

void ExpectStable(const LoopParameters& loop, double mass) {
  EXPECT_TRUE(IsStableByJury(ClosedLoop(loop).Characteristic(mass))) << mass;
}

class RobustIntervalOf : public testing::TestWithParam<EstimatorKind> {};

INSTANTIATE_TEST_SUITE_P(EveryEstimator, RobustIntervalOf, testing::ValuesIn(kAllEstimatorKinds),
                         [](const auto& kind) {
                           return "Kind" + std::to_string(static_cast<int>(kind.param));
                         });

TEST_P(RobustIntervalOf, WithstandsAnAdversaryAndIsTight) {
  RandomLoops random(51);
  int tried = 0;
  int tight = 0;
  double largest_gap = 0;
  double boxes = 0;
  Seconds proving{0};
  Seconds querying{0};
  for (int i = 0; i < kEnvelopes; ++i) {
    SCOPED_TRACE("envelope " + std::to_string(i));
    const LoopEnvelope envelope = RandomEnvelope(random, i, GetParam());
    ASSERT_FALSE(Validate(envelope).has_value());
    const auto start = std::chrono::steady_clock::now();
    const RobustCertificate certificate = CertifyRobustInterval(envelope);
    const auto proved = std::chrono::steady_clock::now();
    ASSERT_FALSE(certificate.empty());
    Adversary adversary(envelope, random);
    adversary.Search(PointsOfAnEnvelope());
    proving += proved - start;
    querying += std::chrono::steady_clock::now() - proved;
    tried += PointsOfAnEnvelope();
    // Sound: nobody is unstable inside, by the nominal edges and by Jury's criterion at the worst loops.
    EXPECT_GE(certificate.lower.mass, adversary.lower());
    EXPECT_LE(certificate.upper.mass, adversary.upper());
    constexpr double kInside = 1 - 1e-9;
    for (const LoopParameters& loop : {adversary.worst_lower(), adversary.worst_upper(),
                                       certificate.lower.binding, certificate.upper.binding}) {
      ExpectStable(loop, kInside * certificate.lower.mass);
      ExpectStable(loop, kInside * certificate.upper.mass);
    }
    // Tight: a loop of the envelope has an edge within 1 %, and the adversary found none much nearer.
    for (const RobustEdge* edge : {&certificate.lower, &certificate.upper}) {
      ExpectMember(envelope, edge->binding);
      largest_gap = std::max(largest_gap, edge->gap());
    }
    tight += std::max(certificate.lower.gap(), certificate.upper.gap()) <= 0.01 ? 1 : 0;
    boxes += certificate.boxes;
  }
  // With an accelerometer the effort may run out where some plants are damped away within a tick and some
  // not.
  EXPECT_GE(tight, IsAccelerometer(GetParam()) ? 50 : kEnvelopes);
  std::cout << Name(GetParam()) << ": " << tried << " loops in " << kEnvelopes << " envelopes, " << tight
            << " certificates within 1 %; largest gap " << largest_gap << "; " << boxes / kEnvelopes
            << " boxes, " << 1e3 * proving.count() / kEnvelopes << " ms, or "
            << proving.count() / kEnvelopes / (querying.count() / tried)
            << " loops of the adversary's, a certificate\n";
}

// Loops that nobody builds: natural frequencies above the sample rate, damped away within a tick, held by a
// hand of a thousand times the device's mass. There the effort may run out; what is proved must hold all the
// same.
LoopEnvelope AnyEnvelope(RandomLoops& random, EstimatorKind estimator) {
  const auto range = [&random](double low, double high) {
    const double first = random.LogUniform(low, high);
    const double second = random.LogUniform(low, high);
    return ParameterRange{.min = std::min(first, second), .max = std::max(first, second)};
  };
  LoopEnvelope envelope;
  envelope.estimator = estimator;
  envelope.period_s = random.LogUniform(1e-5, 1e-2);
  envelope.cutoff_hz = random.LogUniform(0.5, CutoffRangeOf(estimator).max / envelope.period_s);
  envelope.delay_bound_s = envelope.period_s * random.Uniform(0, 3);
  envelope.device.device_mass = range(1e-3, 1e1);
  envelope.device.device_damping = range(1e-4, 1e1);
  envelope.hand.hand_mass = range(1e-3, 1e0);
  envelope.hand.hand_damping = range(1e-2, 3e2);
  envelope.hand.hand_stiffness = range(1, 1e5);
  envelope.hand.include_released_hand = random.Uniform(0, 2) < 1;
  if (IsAccelerometer(estimator)) {
    envelope.accelerometer_bandwidth_hz = random.LogUniform(1e-3, 1e2) / envelope.period_s;
  }
  return envelope;
}

TEST_P(RobustIntervalOf, WithstandsAnAdversaryWhereItIsNotTight) {
  RandomLoops random(52);
  int tight = 0;
  constexpr int kWildEnvelopes = 16;
  for (int i = 0; i < kWildEnvelopes; ++i) {
    SCOPED_TRACE("envelope " + std::to_string(i));
    const LoopEnvelope envelope = AnyEnvelope(random, GetParam());
    const RobustCertificate certificate = CertifyRobustInterval(envelope);
    ASSERT_FALSE(certificate.empty());
    Adversary adversary(envelope, random);
    adversary.Search(PointsOfAnEnvelope());
    EXPECT_GE(certificate.lower.mass, adversary.lower());
    EXPECT_LE(certificate.upper.mass, adversary.upper());
    EXPECT_LT(certificate.lower.mass, 0);
    EXPECT_GT(certificate.upper.mass, 0);
    tight += std::max(certificate.lower.gap(), certificate.upper.gap()) < 0.01 ? 1 : 0;
  }
  std::cout << Name(GetParam()) << ": " << tight << " of " << kWildEnvelopes << " within 1 %\n";
}

}  // namespace
}  // namespace mwidth::model
