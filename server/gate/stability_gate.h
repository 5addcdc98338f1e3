// Whether a loop renders a mass stably, with the margin that is asked of it, and what to do where it does
// not.
#pragma once

#include <optional>
#include <string>

#include "server/gate/force_noise_limit.h"
#include "server/gate/stability_report.h"
#include "server/model/axis_kind.h"
#include "server/model/loop_parameters.h"
#include "server/model/m_width.h"

namespace mwidth::gate {

/// Bounds that hold whatever the stability model says; edges included, 0 between them.
struct MassLimits {
  double min = 0;
  double max = 0;
};

/// The stability model's judgement for one loop. The M-width is computed once, in the constructor; immutable
/// since, so any thread.
///
/// The admitted interval is the robust one with its edges divided by g = 10^(required margin / 20): since the
/// M-width holds every smaller mass of the same sign, a mass inside keeps a gain margin above g (eq. 15). The
/// assumptions of an axis are today its parameters alone, the delay at its configured bound, so that the
/// robust interval is the nominal one.
class StabilityGate {
 public:
  /// Throws std::invalid_argument where model::Validate refuses `loop`, the margin is not 0..60 dB, or a
  /// number of the limit is not above 0.
  StabilityGate(const model::LoopParameters& loop, double required_gain_margin_db,
                std::optional<ForceNoiseLimit> noise_limit = std::nullopt);

  /// Judges a finite `mass`: is it inside the admitted interval, and quiet enough? A mass of 0 is always
  /// admitted, even where the M-width is empty: the force is then zero and the device is left to itself,
  /// which is the safe state to ramp to. `kind` names the units in `binding`.
  StabilityReport Judge(double mass, const MassLimits& limits, model::AxisKind kind) const;

  const MassRange& range() const { return range_; }
  const model::LoopParameters& loop() const { return loop_; }

 private:
  /// Whether `loop`, which differs from this gate's in its filter alone, would be admitted with `mass`.
  bool Admits(const model::LoopParameters& loop, double mass) const;
  std::string Binding(const StabilityReport& report, model::AxisKind kind) const;

  model::LoopParameters loop_;
  model::MWidth m_width_;
  /// 10^(required margin / 20).
  double margin_factor_;
  std::optional<ForceNoiseLimit> noise_limit_;
  MassRange range_;
};

}  // namespace mwidth::gate
