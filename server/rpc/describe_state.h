// What an axis is and does, as the API tells it.
#pragma once

#include "mwidth/v1/rendering.pb.h"
#include "server/gate/axis_gate.h"

namespace mwidth::rpc {

/// Fills an empty message with the present state. Any thread.
void Describe(gate::AxisGate& gate, v1::AxisState& message);

}  // namespace mwidth::rpc
