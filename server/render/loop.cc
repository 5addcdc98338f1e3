#include "server/render/loop.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace mwidth::render {
namespace {

void Require(bool allowed, const char* field, double value, const char* what_is_allowed) {
  if (!allowed) {
    throw std::invalid_argument(std::string(field) + " is " + std::to_string(value) + ", allowed is " +
                                what_is_allowed);
  }
}

// Written so that a NaN is never allowed.
const LoopConfig& Checked(const LoopConfig& c, const device::DriveInfo& info) {
  Require(c.period_s >= 1e-4 && c.period_s <= 1e-2, "period_s", c.period_s, "0.0001 to 0.01");
  Require(model::Runs(c.estimator, c.period_s, c.cutoff_hz), "cutoff_hz", c.cutoff_hz,
          "what the estimator runs with: above 0, at most half the sample rate, for butterworth 0.49 of it");
  Require(c.force_limit > 0 && std::isfinite(c.force_limit), "force_limit", c.force_limit, "above 0");
  Require(std::isfinite(c.position_min), "position_min", c.position_min, "any number");
  Require(std::isfinite(c.position_max) && c.position_max > c.position_min, "position_max", c.position_max,
          "above position_min");
  Require(c.velocity_limit > 0 && std::isfinite(c.velocity_limit), "velocity_limit", c.velocity_limit,
          "above 0");
  Require(c.max_missed_ticks <= 16, "max_missed_ticks", c.max_missed_ticks, "0 to 16");
  Require(c.fault_ramp_s >= 0 && c.fault_ramp_s <= 0.05, "fault_ramp_s", c.fault_ramp_s, "0 to 0.05");
  Require(c.realtime.priority >= 0 && c.realtime.priority <= 99, "priority", c.realtime.priority, "0 to 99");
  Require(info.position_quantum > 0 && std::isfinite(info.position_quantum), "the drive's position_quantum",
          info.position_quantum, "above 0");
  Require(info.force_quantum > 0 && std::isfinite(info.force_quantum), "the drive's force_quantum",
          info.force_quantum, "above 0");
  return c;
}

}  // namespace

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
  statistics_.Record({.wake_latency_ns = wake_latency_ns,
                      .io_ns = drive.io_ns,
                      .compute_ns = clock_.NowNs() - now_ns - drive.io_ns,
                      .loop_delay_ns = drive.loop_delay_ns,
                      .missed_ticks = missed_ticks});
}

}  // namespace mwidth::render
