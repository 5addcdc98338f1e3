#include <chrono>
#include <iostream>
#include <limits>
#include <variant>

#include "client/cli/answer_report.h"
#include "client/cli/commands.h"
#include "client/cli/interrupt.h"
#include "client/cli/json.h"
#include "client/cli/report.h"
#include "client/cpp/client.h"

namespace mwidth::cli {
namespace {

using client::Refusal;
using client::Seconds;
using std::chrono::steady_clock;

// Prints the answer; true when the mass was admitted.
bool Report(const client::MassAnswer& answer, const v1::AxisInfo& axis, const CommandLine& line) {
  if (const auto* refusal = std::get_if<Refusal>(&answer)) {
    if (line.json) {
      std::cout << ToJson(refusal->status) << std::flush;
    } else {
      std::cerr << RefusalReport(*refusal, axis);
    }
    return false;
  }
  const auto& admitted = std::get<v1::SetMassResponse>(answer);
  std::cout << (line.json ? ToJson(admitted) : AdmissionReport(admitted, axis, line.validate_only))
            << std::flush;
  return true;
}

// Until the time is over or Ctrl-C; earlier, with what happened, where rendering ends for another reason.
int Hold(const client::Client& client, client::Control& control, const CommandLine& line,
         const std::stop_token& interrupted) {
  const auto start = steady_clock::now();
  const double hold_s = line.hold_s.value_or(std::numeric_limits<double>::infinity());
  while (!interrupted.stop_requested()) {
    const double left_s = hold_s - Seconds(steady_clock::now() - start).count();
    if (left_s <= 0) {
      break;
    }
    if (control.WaitForLoss(interrupted, Seconds(std::min(left_s, 0.2)))) {
      throw client::Error(*control.Loss());
    }
    const auto axis = client.Axis(line.axis);
    if (axis.state() != v1::STATE_RENDERING) {
      std::cerr << "Rendering has ended: " << StateName(axis.state())
                << (axis.has_fault() ? ", " + axis.fault().message() : "") << "\n";
      return kRefused;
    }
  }
  return kDone;
}

}  // namespace

int RunSetMass(const CommandLine& line) {
  const Interrupt interrupt;
  const auto client = client::Client::Connect(line.server);
  const auto axis = client.Axis(line.axis).info();
  auto control = client.AcquireControl("mwidth set-mass", line.axis);

  // Asked before anything moves: for a refused mass the drive is not even enabled.
  if (const auto answer = control.ValidateMass(line.mass);
      line.validate_only || std::holds_alternative<Refusal>(answer)) {
    return Report(answer, axis, line) ? kDone : kRefused;
  }
  control.StartRendering();
  const auto ramp = line.ramp_s ? std::optional<Seconds>(*line.ramp_s) : std::nullopt;
  if (!Report(control.SetMass(line.mass, ramp), axis, line)) {
    return kRefused;
  }
  if (!line.json && !line.hold_s) {
    std::cout << "Holding it until Ctrl-C.\n" << std::flush;
  }
  if (const int code = Hold(client, control, line, interrupt.token()); code != kDone) {
    return code;
  }
  control.StopRendering();
  if (!line.json) {
    std::cout << "Stopped: the mass is back to zero.\n";
  }
  return kDone;
}

}  // namespace mwidth::cli
