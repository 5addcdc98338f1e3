// Whether a loop renders a mass stably, with the margin that is asked of it, and what to do where it does
// not.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "server/gate/requirements.h"
#include "server/gate/stability_report.h"
#include "server/model/axis_kind.h"
#include "server/model/certificate_cache.h"
#include "server/model/loop_parameters.h"
#include "server/model/m_width.h"
#include "server/model/robust_interval.h"

namespace mwidth::gate {

/// Bounds that hold whatever the stability model says; edges included, 0 between them.
struct MassLimits {
  double min = 0;
  double max = 0;
};

/// The stability model's judgement for one loop and its assumptions. The M-width and the robust interval are
/// computed once, in the constructor; immutable since, so any thread.
///
/// The admitted interval is the robust one with its edges divided by g = 10^(required margin / 20): since the
/// M-width of every assumed loop holds every smaller mass of the same sign, a mass inside keeps a gain margin
/// above g in each of them (eq. 15). Where one loop is assumed, its M-width is the robust interval, exactly.
class StabilityGate {
 public:
  /// Throws std::invalid_argument where model::Validate refuses `loop` or what is assumed around it, or where
  /// a requirement is out of its range. Takes up to a second, with an accelerometer up to three,
  /// where several loops are assumed and `certificates`, not null, does not know them yet.
  StabilityGate(
      const model::LoopParameters& loop, const Requirements& requirements,
      std::shared_ptr<model::CertificateCache> certificates = std::make_shared<model::CertificateCache>());

  /// Judges a finite `mass`: is it inside the admitted interval, and quiet enough? A mass of 0 is always
  /// admitted, even where the M-width is empty: the force is then zero and the device is left to itself,
  /// which is the safe state to ramp to. `kind` names the units in `binding`. Some 2 ms; for a refused mass
  /// up to a second where several loops are assumed, for the cut-off that would admit it, which is not looked
  /// for where those read an accelerometer.
  StabilityReport Judge(double mass, const MassLimits& limits, model::AxisKind kind) const;

  const MassRange& range() const { return range_; }
  /// How the worst loop oscillates at the negative edge of the robust interval; 0 where that is empty.
  double lower_critical_hz() const;
  const model::LoopParameters& loop() const { return loop_; }

 private:
  void TakeNominal();
  void TakeRobust();
  /// Whether this gate would admit `mass` with another cut-off, as far as the loop itself goes: its edges are
  /// to hold `mass` grown by `factor`.
  bool AdmitsNominally(double cutoff_hz, double mass, double factor) const;
  std::optional<double> AdmittingCutoffHz(double mass) const;
  model::Margins WorstMargins(double mass) const;
  std::string Binding(const StabilityReport& report, model::AxisKind kind) const;

  model::LoopParameters loop_;
  Requirements requirements_;
  std::shared_ptr<model::CertificateCache> certificates_;
  model::MWidth m_width_;
  /// Null where one loop is assumed.
  std::shared_ptr<const model::RobustCertificate> certificate_;
  /// 10^(required margin / 20).
  double margin_factor_;
  MassRange range_;
};

}  // namespace mwidth::gate
