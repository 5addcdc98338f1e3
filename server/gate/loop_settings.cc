#include "server/gate/loop_settings.h"

namespace mwidth::gate {

const exchange::LoopStatus& LoopSettings::NewestStatus() {
  crossing_.status.Take(status_);
  return status_;
}

Posted LoopSettings::SetDeadline(int64_t lease_deadline_ns) {
  settings_.lease_deadline_ns = lease_deadline_ns;
  return Post();
}

Posted LoopSettings::SetMass(double mass, double ramp_s) {
  // Taken before the post: a rendering that ends in between voids the mass.
  const exchange::LoopStatus& status = NewestStatus();
  renderings_ended_at_mass_ = status.renderings_ended;
  fault_number_at_mass_ = status.fault.number;
  settings_.mass = mass;
  settings_.ramp_s = ramp_s;
  return Post();
}

Posted LoopSettings::SetFilter(const exchange::Filter& filter, double critical_hz) {
  if (MassIsVoid()) {
    ForgetMass();
  }
  settings_.filter = filter;
  settings_.critical_hz = critical_hz;
  return Post();
}

double LoopSettings::KeptMass() { return MassIsVoid() ? 0 : settings_.mass; }

Posted LoopSettings::Start() {
  if (MassIsVoid()) {
    ForgetMass();
  }
  settings_.rendering = true;
  ++settings_.render_epoch;
  return Post();
}

Posted LoopSettings::Stop() {
  settings_.rendering = false;
  ForgetMass();
  return Post();
}

Posted LoopSettings::EmergencyStop() {
  ++settings_.emergency_stops;
  return Stop();
}

Posted LoopSettings::ClearFault(uint64_t fault_number) {
  settings_.cleared_fault_number = fault_number;
  return Stop();
}

bool LoopSettings::StartPending() {
  return settings_.rendering && settings_.render_epoch > NewestStatus().render_epoch;
}

bool LoopSettings::StopPending() {
  return !settings_.rendering && NewestStatus().state == exchange::State::kRendering;
}

bool LoopSettings::MassIsVoid() {
  const exchange::LoopStatus& status = NewestStatus();
  return status.renderings_ended != renderings_ended_at_mass_ || status.fault.number != fault_number_at_mass_;
}

void LoopSettings::ForgetMass() {
  settings_.mass = 0;
  settings_.ramp_s = exchange::Settings{}.ramp_s;
}

Posted LoopSettings::Post() {
  ++settings_.sequence;
  crossing_.settings.Post(settings_);
  return {.sequence = settings_.sequence,
          .render_epoch = settings_.render_epoch,
          .cleared_fault_number = settings_.cleared_fault_number};
}

}  // namespace mwidth::gate
