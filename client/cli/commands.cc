#include "client/cli/commands.h"

#include <iostream>

#include "client/cli/json.h"
#include "client/cli/report.h"
#include "client/cli/timing_report.h"
#include "client/cpp/client.h"

namespace mwidth::cli {

int RunState(const CommandLine& line) {
  const auto response = client::Client::Connect(line.server).State(line.axis);
  if (line.json) {
    std::cout << ToJson(response);
    return kDone;
  }
  std::cout << StateReport(response);
  for (int i = 0; line.timing && i < response.axes_size(); ++i) {
    std::cout << "\n" << TimingReport(response.axes(i));
  }
  return kDone;
}

int RunStop(const CommandLine& line) {
  const auto client = client::Client::Connect(line.server);
  const auto stopped = client.EmergencyStop(line.reason, line.axis);
  if (line.json) {
    std::cout << ToJson(stopped);
    return kDone;
  }
  for (int i = 0; i < stopped.states_size(); ++i) {
    std::cout << stopped.axes(i) << ": stopped, " << StateName(stopped.states(i)) << "\n";
  }
  std::cout << "Once it is safe: mwidth clear-fault\n";
  return kDone;
}

int RunClearFault(const CommandLine& line) {
  const auto client = client::Client::Connect(line.server);
  auto control = client.AcquireControl("mwidth clear-fault", line.axis);
  const auto response = control.ClearFault();
  if (line.json) {
    std::cout << ToJson(response);
  } else {
    std::cout << client.Axis(line.axis).info().name() << ": " << StateName(response.state()) << "\n";
  }
  return kDone;
}

}  // namespace mwidth::cli
