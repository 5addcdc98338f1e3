#include "server/gate/filter_request.h"

#include "server/gate/figures.h"
#include "server/gate/mass_request.h"

namespace mwidth::gate {

exchange::Filter FilterOf(const model::LoopParameters& loop) {
  return {.estimator = static_cast<uint8_t>(loop.estimator), .cutoff_hz = loop.cutoff_hz};
}

Refusal InadmissibleWithFilter(const StabilityReport& report, const AxisDescription& axis) {
  Refusal refusal = InadmissibleMass(report, axis);
  const std::string estimator = model::Name(report.loop.estimator);
  const std::string cutoff_hz = Figure(report.loop.cutoff_hz);
  refusal.message = "With the " + estimator + " estimator at " + cutoff_hz +
                    " Hz the mass that is set now would be refused. " + refusal.message +
                    " So does the filter: set another mass first, or ask for another filter.";
  refusal.metadata["estimator"] = estimator;
  refusal.metadata["cutoff_hz"] = cutoff_hz;
  return refusal;
}

}  // namespace mwidth::gate
