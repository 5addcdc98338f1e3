#include "server/rpc/describe_state.h"

#include <memory>

#include "server/rpc/convert.h"
#include "server/rpc/convert_analysis.h"
#include "server/rpc/convert_statistics.h"

namespace mwidth::rpc {

void Describe(gate::AxisGate& gate, v1::AxisState& message) {
  const gate::AxisDescription& axis = gate.description();
  const exchange::LoopStatus status = gate.Status();
  const std::shared_ptr<const gate::StabilityGate> stability = gate.stability();
  Convert(axis, *message.mutable_info());
  Convert(stability->loop(), *message.mutable_info()->mutable_loop());
  message.set_state(Convert(status.state));
  if (status.state == exchange::State::kFault) {
    Convert(status.fault, *message.mutable_fault());
  }
  message.set_tick(status.tick);
  message.set_position(status.position);
  message.set_velocity(status.velocity);
  message.set_force(status.force);
  message.set_mass(status.mass);
  message.set_target_mass(status.target_mass);
  message.set_missed_ticks(status.missed_ticks);
  message.set_saturated_ticks(status.saturated_ticks);
  message.set_slew_limited_ticks(status.slew_limited_ticks);
  message.set_dropped_samples(gate.dropped_samples());
  message.set_controller(gate.Controller());
  message.set_realtime(axis.realtime);
  message.set_realtime_message(axis.realtime_message);
  Convert(stability->range(), *message.mutable_m_width());
  Convert(gate.tick_statistics(), *message.mutable_tick_statistics());
}

}  // namespace mwidth::rpc
