#include "tests/bench/streams/feeder.h"

#include <pthread.h>

#include <cmath>
#include <ctime>
#include <utility>

#include "server/exchange/clock.h"

namespace mwidth::bench {
namespace {

constexpr int64_t kPeriodNs = 1'000'000;

}  // namespace

exchange::Sample SampleOf(uint64_t tick, int64_t monotonic_ns) {
  const double phase = 0.002 * static_cast<double>(tick);
  exchange::Sample sample;
  sample.tick = tick;
  sample.monotonic_ns = monotonic_ns;
  sample.state = exchange::State::kRendering;
  sample.force_taken = true;
  sample.position_counts = static_cast<int64_t>(20'000 * std::sin(phase));
  sample.position = 1e-5 * static_cast<double>(sample.position_counts);
  sample.velocity = 0.4 * std::cos(phase);
  sample.acceleration = -0.8 * std::sin(phase);
  sample.mass = 0.05;
  sample.force = sample.mass * sample.acceleration;
  sample.force_counts = static_cast<int32_t>(1e4 * sample.force);
  return sample;
}

Feeder::Feeder(std::function<void(const exchange::Sample&)> take)
    : take_(std::move(take)), thread_([this] { Run(); }) {}

Feeder::~Feeder() {
  over_ = true;
  thread_.join();
}

double Feeder::CpuS() const {
  clockid_t clock{};
  timespec time{};
  // The thread runs as long as this object.
  pthread_getcpuclockid(const_cast<std::thread&>(thread_).native_handle(), &clock);
  clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

void Feeder::Run() {
  exchange::MonotonicClock clock(0);
  int64_t deadline_ns = clock.NowNs();
  for (uint64_t tick = 1; !over_; ++tick) {
    deadline_ns += kPeriodNs;
    clock.SleepUntilNs(deadline_ns);
    take_(SampleOf(tick, deadline_ns));
  }
}

}  // namespace mwidth::bench
