#include "tests/bench/loop/watched_clock.h"

#include <sys/resource.h>

#include <chrono>
#include <ctime>
#include <thread>

#include "tests/bench/loop/heap_calls.h"

namespace mwidth::bench {
namespace {

ThreadUsage UsageOfThisThread() noexcept {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  timespec cpu{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &cpu);
  return {.cpu_ns = cpu.tv_sec * 1'000'000'000L + cpu.tv_nsec,
          .page_faults = usage.ru_minflt + usage.ru_majflt,
          .involuntary_switches = usage.ru_nivcsw,
          .heap_calls = HeapCalls()};
}

ThreadUsage Since(const ThreadUsage& first, const ThreadUsage& last) noexcept {
  return {.cpu_ns = last.cpu_ns - first.cpu_ns,
          .page_faults = last.page_faults - first.page_faults,
          .involuntary_switches = last.involuntary_switches - first.involuntary_switches,
          .heap_calls = last.heap_calls - first.heap_calls};
}

}  // namespace

void WatchedClock::SleepUntilNs(int64_t deadline_ns) noexcept {
  deadline_ns_.store(deadline_ns, std::memory_order_relaxed);
  clock_.SleepUntilNs(deadline_ns);
  const Phase phase = phase_.load(std::memory_order_acquire);
  if (phase == Phase::kBefore || phase == Phase::kAfter) {
    return;
  }
  if (!begun_) {
    // Twice: the first call touches what it needs.
    first_ = UsageOfThisThread();
    first_ = UsageOfThisThread();
    first_deadline_ns_ = deadline_ns;
    begun_ = true;
    return;
  }
  lag_.Record(clock_.NowNs() - deadline_ns);
  ++watched_.ticks;
  if (phase == Phase::kEnd) {
    watched_.usage = Since(first_, UsageOfThisThread());
    const int64_t periods = (deadline_ns - first_deadline_ns_) / period_ns_;
    watched_.missed = static_cast<uint64_t>(periods) - watched_.ticks;
    phase_.store(Phase::kAfter, std::memory_order_release);
    phase_.notify_one();
  }
}

Watched WatchedClock::Watch(double duration_s) {
  phase_.store(Phase::kDuring, std::memory_order_release);
  std::this_thread::sleep_for(std::chrono::duration<double>(duration_s));
  phase_.store(Phase::kEnd, std::memory_order_release);
  phase_.wait(Phase::kEnd, std::memory_order_acquire);
  Watched watched = watched_;
  watched.lag = lag_.Figures();
  return watched;
}

}  // namespace mwidth::bench
