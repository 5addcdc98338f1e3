#include "server/exchange/clock.h"

#include <cerrno>
#include <ctime>

#include "server/exchange/cpu_pause.h"

namespace mwidth::exchange {
namespace {

constexpr int64_t kNsPerSecond = 1'000'000'000;
// The simulated clock really sleeps only in steps of this length: shorter sleeps cost more than they pace.
constexpr int64_t kPacingStepNs = 2'000'000;

}  // namespace

int64_t MonotonicClock::NowNs() const noexcept {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * kNsPerSecond + now.tv_nsec;
}

void MonotonicClock::SleepUntilNs(int64_t deadline_ns) noexcept {
  const int64_t wake_ns = deadline_ns - spin_ns_;
  const timespec wake{.tv_sec = wake_ns / kNsPerSecond, .tv_nsec = wake_ns % kNsPerSecond};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &wake, nullptr) == EINTR) {
  }
  if (spin_ns_ > 0) {
    while (NowNs() < deadline_ns) {
      PauseCpu();
    }
  }
}

SimulatedClock::SimulatedClock(double speed)
    : speed_(speed), now_ns_(real_.NowNs()), real_origin_ns_(now_ns_), origin_ns_(now_ns_) {}

int64_t SimulatedClock::NowNs() const noexcept { return now_ns_.load(std::memory_order_acquire); }

void SimulatedClock::SleepUntilNs(int64_t deadline_ns) noexcept {
  const int64_t real_ns = real_.NowNs();
  const auto due_ns =
      real_origin_ns_ + static_cast<int64_t>(static_cast<double>(deadline_ns - origin_ns_) / speed_);
  if (due_ns - real_ns > kPacingStepNs) {
    real_.SleepUntilNs(due_ns);
  } else if (due_ns < real_ns) {
    real_origin_ns_ = real_ns;
    origin_ns_ = deadline_ns;
  }
  now_ns_.store(deadline_ns, std::memory_order_release);
}

}  // namespace mwidth::exchange
