#include "server/render/loop.h"

#include <algorithm>
#include <cmath>

namespace mwidth::render {

Loop::Loop(device::Drive& drive, exchange::Crossing& crossing, exchange::Clock& clock,
           const LoopConfig& config)
    : clock_(clock),
      statistics_(crossing.tick_statistics),
      config_(Checked(config, drive.Info())),
      drive_(drive, clock),
      tick_(config_, drive_, crossing) {}

Loop::~Loop() { Stop(); }

RealtimeReport Loop::Start() {
  thread_ = std::thread([this] {
    report_ = EnterRealtime(config_.realtime);
    reported_.store(true, std::memory_order_release);
    reported_.notify_one();
    Run();
  });
  reported_.wait(false, std::memory_order_acquire);
  if (config_.realtime.priority > 0 && !config_.realtime.allow_deep_idle) {
    AddRefusal(cpu_latency_.emplace().refusal(), report_);
  }
  return report_;
}

void Loop::Stop() noexcept {
  BeginStop();
  if (thread_.joinable()) {
    thread_.join();
  }
  cpu_latency_.reset();
}

// Rt from the first sleep on.
void Loop::Run() noexcept {
  const int64_t period_ns = std::llround(config_.period_s * 1e9);
  int64_t deadline_ns = clock_.NowNs();
  for (uint64_t tick = 1;; ++tick) {
    deadline_ns += period_ns;
    clock_.SleepUntilNs(deadline_ns);
    const int64_t now_ns = clock_.NowNs();
    const int64_t wake_latency_ns = now_ns - deadline_ns;
    const int64_t missed = std::max<int64_t>(0, wake_latency_ns / period_ns);
    deadline_ns += missed * period_ns;
    tick += static_cast<uint64_t>(missed);
    tick_.Run(tick, now_ns, static_cast<uint64_t>(missed));
    RecordTimes(now_ns, wake_latency_ns, static_cast<uint64_t>(missed));
    if (stopping_.load(std::memory_order_relaxed)) {
      tick_.BeginStop();
      if (tick_.AtRest()) {
        break;
      }
    }
  }
  tick_.Close();
}

void Loop::RecordTimes(int64_t now_ns, int64_t wake_latency_ns, uint64_t missed_ticks) noexcept {
  const DriveTimes drive = drive_.TakeTimes();
  tick_.ReportLoopDelay(drive.loop_delay_ns);
  statistics_.Record({.wake_latency_ns = wake_latency_ns,
                      .io_ns = drive.io_ns,
                      .compute_ns = clock_.NowNs() - now_ns - drive.io_ns,
                      .loop_delay_ns = drive.loop_delay_ns,
                      .missed_ticks = missed_ticks});
}

}  // namespace mwidth::render
