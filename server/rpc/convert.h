// Between the plain structs of the gate and the messages of the API. Each Convert fills an empty message.
#pragma once

#include <optional>

#include "mwidth/v1/rendering.pb.h"
#include "mwidth/v1/stability.pb.h"
#include "server/exchange/crossing.h"
#include "server/gate/axis_description.h"
#include "server/gate/control_lease.h"
#include "server/gate/stability_report.h"
#include "server/model/envelope.h"
#include "server/model/loop_parameters.h"
#include "server/model/margins.h"

namespace mwidth::rpc {

v1::State Convert(exchange::State state);
void Convert(const exchange::FaultRecord& fault, v1::FaultInfo& message);
void Convert(const model::LoopParameters& loop, v1::LoopParameters& message);
void Convert(const model::HandEnvelope& hand, v1::HandEnvelope& message);
void Convert(const model::DeviceTolerance& device, v1::DeviceTolerance& message);
void Convert(const model::Margins& margins, v1::StabilityMargins& message);
void Convert(const gate::MassRange& range, v1::MWidth& message);
void Convert(const gate::StabilityReport& report, v1::StabilityReport& message);
/// All but the loop, of which the filter may have changed since.
void Convert(const gate::AxisDescription& axis, v1::AxisInfo& message);
/// The expiry is told by the wall clock: the time to live from now, which is when a lease is granted or
/// renewed.
void Convert(const gate::Lease& lease, v1::ControlLease& message);

/// None where it is unspecified, or not one that this server knows.
std::optional<model::EstimatorKind> Estimator(v1::EstimatorKind estimator);

/// `own` with the fields that are set in `overrides` in place of its own. The result is not validated; an
/// estimator that is none is left out.
model::LoopParameters Override(model::LoopParameters own, const v1::LoopParameters& overrides);

/// In seconds; not validated, and never NaN: a malformed duration is out of any range that the gate allows,
/// or close to what was meant.
double Seconds(const google::protobuf::Duration& duration);

}  // namespace mwidth::rpc
