// A shipped axis in lock step, in the hand of a simulated person.
#pragma once

#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <string>
#include <utility>

#include "device/hand_motion.h"
#include "device/simulated_drive.h"
#include "server/config.h"
#include "server/exchange/crossing.h"
#include "server/gate/stability_gate.h"
#include "server/render/tick.h"

namespace mwidth::render {

/// What decides about a mass on the axis of a configuration.
struct CertifiedAxis {
  explicit CertifiedAxis(const server::AxisConfig& axis)
      : config(axis),
        stability(axis.loop, {.gain_margin_db = axis.required_gain_margin_db,
                              .noise_limit = {},
                              .hand = axis.hand_envelope,
                              .device = axis.device_tolerance}) {}

  LoopConfig MakeLoopConfig() const {
    LoopConfig loop;
    loop.period_s = config.loop.period_s;
    loop.estimator = config.loop.estimator;
    loop.cutoff_hz = config.loop.cutoff_hz;
    loop.force_limit = config.limits.force;
    loop.position_min = config.limits.position_min;
    loop.position_max = config.limits.position_max;
    loop.velocity_limit = config.limits.velocity;
    loop.force_slew_limit = config.limits.force_slew.value_or(std::numeric_limits<double>::infinity());
    loop.watch = config.watch;
    loop.hand_monitor = config.hand_monitor;
    return loop;
  }

  server::AxisConfig config;
  gate::StabilityGate stability;
};

/// `axis` held by the hand of `truth`, which moves as `motion`.
class HeldAxis {
 public:
  HeldAxis(const CertifiedAxis& axis, const model::LoopParameters& truth,
           std::unique_ptr<device::HandMotion> motion)
      : HeldAxis(axis, axis.MakeLoopConfig(), truth, std::move(motion)) {}
  HeldAxis(const CertifiedAxis& axis, const LoopConfig& loop, const model::LoopParameters& truth,
           std::unique_ptr<device::HandMotion> motion)
      : critical_hz_(axis.stability.lower_critical_hz()),
        period_ns_(std::llround(loop.period_s * 1e9)),
        drive_({.loop = truth,
                .position_quantum = axis.config.drive.position_quantum,
                .force_quantum = axis.config.drive.force_quantum},
               std::move(motion)),
        tick_(loop, drive_, *crossing_) {}

  /// As the gate would: 0.2 s to `mass`.
  void Render(double mass) {
    exchange::Settings settings{.sequence = ++sequence_,
                                .rendering = true,
                                .render_epoch = 1,
                                .mass = mass,
                                .ramp_s = 0.2,
                                .filter = {},
                                .critical_hz = critical_hz_,
                                .lease_deadline_ns = INT64_MAX};
    crossing_->settings.Post(settings);
  }
  /// One tick, after `missed` that were skipped.
  const exchange::Sample& Run(uint64_t missed = 0) {
    ticks_ += 1 + missed;
    tick_.Run(ticks_, static_cast<int64_t>(ticks_) * period_ns_, missed);
    crossing_->samples.Pop(sample_);
    return sample_;
  }
  exchange::FaultRecord Fault() {
    crossing_->status.Take(status_);
    return status_.fault;
  }
  uint64_t ticks() const { return ticks_; }

 private:
  double critical_hz_;
  int64_t period_ns_;
  device::SimulatedDrive drive_;
  std::unique_ptr<exchange::Crossing> crossing_ = std::make_unique<exchange::Crossing>();
  Tick tick_;
  exchange::Sample sample_;
  exchange::LoopStatus status_;
  uint64_t sequence_ = 0;
  uint64_t ticks_ = 0;
};

}  // namespace mwidth::render
