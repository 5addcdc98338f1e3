#include <iomanip>
#include <iostream>

#include "client/cli/commands.h"
#include "client/cli/json.h"
#include "client/cli/one_line.h"
#include "client/cpp/client.h"

namespace mwidth::cli {

int RunEvents(const CommandLine& line) {
  v1::StreamEventsRequest request;
  request.set_axis(line.axis);
  if (line.events_after) {
    request.set_after_number(*line.events_after);
  }
  client::Client::Connect(line.server).WatchEvents(request, [&](const v1::StreamEventsResponse& response) {
    if (line.json) {
      std::cout << ToJson(response, /*one_line=*/true);
    } else {
      if (response.lost_before() > 0) {
        std::cout << "(" << response.lost_before() << " events are forgotten)\n";
      }
      const v1::Event& event = response.event();
      std::cout << std::setw(5) << event.number() << "  tick " << event.tick() << "  " << event.message()
                << "\n";
    }
    std::cout.flush();
    return std::cout.good();
  });
  return kDone;
}

}  // namespace mwidth::cli
