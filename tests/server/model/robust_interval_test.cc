#include "server/model/robust_interval.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <thread>
#include <vector>

#include "server/model/certificate_cache.h"
#include "server/model/m_width.h"
#include "tests/server/model/model_loops.h"

namespace mwidth::model {
namespace {

LoopEnvelope TableTwoEnvelope() {
  LoopEnvelope envelope = EnvelopeOf(TableTwo());
  envelope.hand.hand_stiffness = {.min = 100, .max = 1000};
  envelope.hand.hand_damping = {.min = 2, .max = 8};
  envelope.device.device_mass = {.min = 0.065, .max = 0.075};
  envelope.delay_bound_s = 1.5e-3;
  return envelope;
}

TEST(RobustInterval, OfOneLoopIsItsMWidth) {
  RandomLoops random(41);
  for (int i = 0; i < 300; ++i) {
    LoopParameters loop = random.Next();
    loop.delay_s = 0;
    loop.estimator = kAllEstimatorKinds.at(static_cast<std::size_t>(i) % kAllEstimatorKinds.size());
    const MWidth nominal = ComputeMWidth(loop);
    const RobustCertificate certificate = CertifyRobustInterval(EnvelopeOf(loop));
    EXPECT_NEAR(certificate.lower.mass, nominal.lower.mass, -1e-6 * nominal.lower.mass);
    EXPECT_NEAR(certificate.upper.mass, nominal.upper.mass, 1e-6 * nominal.upper.mass);
  }
}

TEST(RobustInterval, OfAFreeMassWithoutFrictionIsTheClosedForm) {
  LoopParameters loop = TableTwo();
  loop.device_damping = loop.hand_damping = loop.hand_stiffness = 0;
  const double a = std::exp(-2 * std::numbers::pi * loop.cutoff_hz * loop.period_s);
  const RobustCertificate certificate = CertifyRobustInterval(EnvelopeOf(loop));
  EXPECT_NEAR(certificate.lower.mass / loop.device_mass, -1, 1e-6);
  EXPECT_NEAR(certificate.upper.mass / loop.device_mass, 2 / (1 - a), 1e-6 * 2 / (1 - a));
}

TEST(RobustInterval, KeepsItsAssumptionsAndSaysWhatBinds) {
  const LoopEnvelope envelope = TableTwoEnvelope();
  const RobustCertificate certificate = CertifyRobustInterval(envelope);
  EXPECT_EQ(certificate.assumed, envelope);
  EXPECT_GT(certificate.boxes, 0);
  for (const RobustEdge* edge : {&certificate.lower, &certificate.upper}) {
    EXPECT_LE(edge->gap(), 5e-3);
    EXPECT_GE(edge->gap(), 0);
    EXPECT_GE(edge->binding.hand_stiffness, 100);
    EXPECT_LE(edge->binding.hand_stiffness, 1000);
    EXPECT_GT(edge->binding_edge.critical_hz, 0);
  }
  EXPECT_EQ(certificate.lower.binding_edge.mass, ComputeMWidth(certificate.lower.binding).lower.mass);
  const std::string binding = DescribeBinding(certificate, certificate.lower);
  EXPECT_NE(binding.find("hand_damping at its least (2)"), std::string::npos) << binding;
  EXPECT_EQ(binding.find("hand_mass"), std::string::npos) << binding;
}

TEST(RobustInterval, SplitsWhatBindsBetweenHandAndDevice) {
  LoopEnvelope envelope = TableTwoEnvelope();
  envelope.hand.hand_mass = {.min = 0.01, .max = 0.03};
  const RobustCertificate certificate = CertifyRobustInterval(envelope);
  EXPECT_EQ(certificate.upper.binding.device_mass, 0.065);
  EXPECT_EQ(certificate.upper.binding.hand_mass, 0.01);
}

// The critical mass need not be worst at a corner: here a hand of middling stiffness is.
TEST(RobustInterval, FindsTheWorstHandInsideTheBox) {
  LoopEnvelope envelope;
  double corners = 0;
  double robust = 0;
  RandomLoops random(42);
  // The first box of a seeded sequence whose worst lower edge lies well off the corners.
  for (int i = 0; i < 200 && !(robust < 0.9 * corners); ++i) {
    envelope = EnvelopeOf(TableTwo());
    envelope.cutoff_hz = random.LogUniform(2, 50);
    envelope.hand.hand_stiffness.min = random.LogUniform(1, 3e4);
    envelope.hand.hand_stiffness.max = envelope.hand.hand_stiffness.min * random.LogUniform(1, 100);
    envelope.hand.hand_damping.min = random.LogUniform(1, 100);
    envelope.hand.hand_damping.max = envelope.hand.hand_damping.min * random.LogUniform(1, 10);
    corners = std::numeric_limits<double>::infinity();
    for (const double stiffness : {envelope.hand.hand_stiffness.min, envelope.hand.hand_stiffness.max}) {
      for (const double damping : {envelope.hand.hand_damping.min, envelope.hand.hand_damping.max}) {
        LoopParameters loop = TableTwo();
        loop.cutoff_hz = envelope.cutoff_hz;
        loop.hand_stiffness = stiffness;
        loop.hand_damping = damping;
        corners = std::min(corners, -ComputeMWidth(loop).lower.mass);
      }
    }
    robust = -CertifyRobustInterval(envelope).lower.binding_edge.mass;
  }
  EXPECT_LT(robust, 0.9 * corners);
}

TEST(RobustInterval, CountsTheReleasedHand) {
  LoopEnvelope envelope = TableTwoEnvelope();
  envelope.hand.hand_mass = {.min = 0.1, .max = 0.2};
  const RobustCertificate held = CertifyRobustInterval(envelope);
  envelope.hand.include_released_hand = true;
  const RobustCertificate released = CertifyRobustInterval(envelope);
  LoopParameters free = TableTwo();
  free.device_mass = 0.065;
  free.hand_stiffness = free.hand_damping = 0;
  free.delay_s = 1.5e-3;
  const MWidth nominal = ComputeMWidth(free);
  EXPECT_GE(released.lower.mass, held.lower.mass);
  EXPECT_LE(released.upper.mass, held.upper.mass);
  EXPECT_GE(released.lower.mass, nominal.lower.mass);
  EXPECT_LE(released.upper.mass, nominal.upper.mass);
  EXPECT_EQ(DescribeBinding(released, released.upper).rfind("the released hand", 0), 0U);
}

TEST(RobustInterval, IsEmptyWhereAHeldMassHasNoDamping) {
  LoopEnvelope envelope = TableTwoEnvelope();
  envelope.device.device_damping = {.min = 0, .max = 0.01};
  envelope.hand.hand_damping.min = 0;
  const RobustCertificate certificate = CertifyRobustInterval(envelope);
  EXPECT_TRUE(certificate.empty());
  EXPECT_FALSE(certificate.Contains(0));
  EXPECT_NE(certificate.empty_reason.find("hand_damping.min"), std::string::npos);
}

TEST(CertificateCache, LooksUpWhatItProved) {
  CertificateCache cache(2);
  LoopEnvelope envelope = TableTwoEnvelope();
  const auto first = cache.Get(envelope);
  EXPECT_EQ(cache.Get(envelope), first);
  envelope.cutoff_hz = 11;
  EXPECT_NE(cache.Get(envelope), first);
  EXPECT_EQ(cache.Get(TableTwoEnvelope()), first);
  envelope.cutoff_hz = 12;
  cache.Get(envelope);  // the certificate of 11 Hz was used least recently
  EXPECT_EQ(cache.Get(TableTwoEnvelope()), first);
}

TEST(CertificateCache, ServesSeveralThreads) {
  CertificateCache cache;
  std::vector<std::shared_ptr<const RobustCertificate>> got(4);
  std::vector<std::thread> threads;
  for (auto& certificate : got) {
    threads.emplace_back([&cache, &certificate] { certificate = cache.Get(TableTwoEnvelope()); });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  for (const auto& certificate : got) {
    EXPECT_EQ(certificate, got[0]);
  }
}

}  // namespace
}  // namespace mwidth::model
