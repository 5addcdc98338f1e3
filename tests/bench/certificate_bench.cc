// Robust certificates: proved anew, and looked up.
#include <benchmark/benchmark.h>

#include <array>
#include <cstddef>

#include "server/model/certificate_cache.h"
#include "tests/bench/rendering_loops.h"

namespace mwidth::bench {
namespace {

using model::CertificateCache;
using model::CertifyRobustInterval;
using model::LoopEnvelope;
using model::RobustCertificate;

/// The paper's loop for hands from slack to stiff, or none, a device known to 20 %, and any delay up to 1.5
/// ticks.
LoopEnvelope AnyHand() {
  const model::LoopParameters loop = PaperLoop();
  LoopEnvelope envelope = EnvelopeOf(loop);
  envelope.hand.hand_stiffness = {70, 3000};
  envelope.hand.hand_damping = {0.5, 50};
  envelope.hand.include_released_hand = true;
  envelope.device.device_mass = {0.8 * loop.device_mass, 1.2 * loop.device_mass};
  envelope.delay_bound_s = 1.5 * loop.period_s;
  return envelope;
}

void ColdCertificate(benchmark::State& state) {
  LoopEnvelope envelope = AnyHand();
  RobustCertificate certificate;
  for (auto _ : state) {  // NOLINT(clang-analyzer-deadcode.DeadStores): the loop is the measurement
    benchmark::DoNotOptimize(envelope);
    certificate = CertifyRobustInterval(envelope);
    benchmark::DoNotOptimize(certificate);
  }
  if (certificate.empty() || certificate.lower.gap() > 0.01 || certificate.upper.gap() > 0.01) {
    state.SkipWithError("the certificate is not within 1 %");
  }
  state.counters["boxes"] = certificate.boxes;
  state.counters["nominal_queries"] = certificate.nominal_queries;
}
BENCHMARK(ColdCertificate)->Unit(benchmark::kMicrosecond);

/// In a full cache, always the one asked for last but one.
void WarmCertificate(benchmark::State& state) {
  constexpr int kKept = 64;
  CertificateCache cache(kKept);
  std::array<LoopEnvelope, 2> asked{AnyHand(), EnvelopeOf(PaperLoop())};
  for (int i = 1; i < kKept; ++i) {
    asked[1].hand.hand_stiffness = {100.0 + i, 100.0 + i};
    cache.Get(asked[1]);
  }
  cache.Get(asked[0]);
  std::size_t next = 0;
  for (auto _ : state) {  // NOLINT(clang-analyzer-deadcode.DeadStores): the loop is the measurement
    next ^= 1;
    benchmark::DoNotOptimize(cache.Get(asked[next]));
  }
}
BENCHMARK(WarmCertificate);

}  // namespace
}  // namespace mwidth::bench
