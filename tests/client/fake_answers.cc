#include "tests/client/fake_answers.h"

#include <google/rpc/error_details.pb.h>
#include <google/rpc/status.pb.h>

#include <algorithm>
#include <cmath>

namespace mwidth::testing {

v1::LoopParameters Loop() {
  v1::LoopParameters loop;
  loop.set_device_mass(0.05);
  loop.set_device_damping(0.1);
  loop.set_hand_mass(0);
  loop.set_hand_damping(0.5);
  loop.set_hand_stiffness(20);
  loop.set_period_s(0.001);
  loop.set_cutoff_hz(10);
  loop.set_delay_s(0.0005);
  loop.set_estimator(v1::ESTIMATOR_KIND_FILTERED_DIFFERENCE);
  return loop;
}

v1::MWidth Width() {
  v1::MWidth width;
  width.mutable_nominal()->set_min(-0.07);
  width.mutable_nominal()->set_max(0.5);
  *width.mutable_robust() = width.nominal();
  *width.mutable_min_binding() = Loop();
  *width.mutable_max_binding() = Loop();
  width.mutable_admitted()->set_min(kAdmittedMin);
  width.mutable_admitted()->set_max(kAdmittedMax);
  width.set_min_critical_hz(3.25);
  width.set_max_critical_hz(60.5);
  width.set_required_gain_margin_db(3);
  return width;
}

v1::StabilityReport Report(double mass) {
  v1::StabilityReport report;
  report.set_requested_mass(mass);
  *report.mutable_m_width() = Width();
  *report.mutable_loop() = Loop();
  report.set_gain_margin_db(20 * std::log10((mass < 0 ? -0.07 : 0.5) / mass));
  report.set_critical_hz(mass < 0 ? 3.25 : 60.5);
  auto& margins = *report.mutable_margins();
  margins.set_gain_db(report.gain_margin_db());
  margins.set_gain_hz(report.critical_hz());
  margins.set_phase_deg(41.5);
  margins.set_phase_hz(22);
  margins.set_delay_s(0.003);
  margins.set_delay_at_least(true);
  margins.set_modulus(0.25);
  margins.set_modulus_hz(31);
  report.set_binding("The delay of the loop sets this edge.");
  report.set_nearest_admitted_mass(std::clamp(mass, kAdmittedMin, kAdmittedMax));
  if (mass > kAdmittedMax) {
    report.set_admitting_cutoff_hz(4.5);
  }
  return report;
}

grpc::Status Failure(grpc::StatusCode code, const std::string& reason, const std::string& message,
                     const v1::StabilityReport* report) {
  google::rpc::Status status;
  status.set_code(code);
  status.set_message(message);
  google::rpc::ErrorInfo info;
  info.set_domain("mwidth");
  info.set_reason(reason);
  status.add_details()->PackFrom(info);
  if (report != nullptr) {
    status.add_details()->PackFrom(*report);
  }
  return {code, message, status.SerializeAsString()};
}

}  // namespace mwidth::testing
