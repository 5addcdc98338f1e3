#include "client/cli/commands.h"

#include <iostream>

#include "client/cli/json.h"
#include "client/cli/report.h"
#include "client/cpp/client.h"

namespace mwidth::cli {

int RunState(const CommandLine& line) {
  const auto response = client::Client::Connect(line.server).State(line.axis);
  std::cout << (line.json ? ToJson(response) : StateReport(response));
  return kDone;
}

int RunStop(const CommandLine& line) {
  const auto client = client::Client::Connect(line.server);
  // First the stop, then everything that is only for people.
  const auto states = client.EmergencyStop(line.reason, line.axis);
  const auto response = client.State(line.axis);
  if (line.json) {
    v1::EmergencyStopResponse stopped;
    for (const auto state : states) {
      stopped.add_states(state);
    }
    std::cout << ToJson(stopped);
    return kDone;
  }
  for (size_t i = 0; i < states.size(); ++i) {
    std::cout << response.axes(static_cast<int>(i)).info().name() << ": stopped, " << StateName(states[i])
              << "\n";
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
