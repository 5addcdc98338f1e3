// What clients command, as events of the axis.
#pragma once

#include <string>

#include "server/gate/control_lease.h"
#include "server/gate/filter_request.h"
#include "server/gate/mass_request.h"
#include "server/gate/refusal.h"
#include "server/rpc/axis_registry.h"

namespace mwidth::rpc {

/// Each publishes one event, or none where nothing was commanded (validate_only) or the caller was turned
/// away for lack of a lease, which says nothing of the axis. Metadata of a mass or filter that is set: mass,
/// ramp_s, estimator, cutoff_hz, gain_margin_db, phase_margin_deg, delay_margin_s, modulus_margin, and the
/// min and max of admitted, robust and nominal masses, all with as many digits as there are; of a refusal:
/// its reason and its own metadata.
void TellControl(const Axis& axis, const gate::Result<gate::Lease>& lease);
/// `holder` gave control back.
void TellRelease(const Axis& axis, const std::string& holder);
void TellMass(const Axis& axis, const gate::MassRequest& request,
              const gate::Result<gate::MassGrant>& answer);
void TellFilter(const Axis& axis, bool validate_only, const gate::Result<gate::FilterGrant>& answer);
/// `by` and `reason` are printable.
void TellEmergencyStop(const Axis& axis, const std::string& by, const std::string& reason);

}  // namespace mwidth::rpc
