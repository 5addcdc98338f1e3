#include <iostream>
#include <variant>

#include "client/cli/answer_report.h"
#include "client/cli/commands.h"
#include "client/cli/json.h"
#include "client/cpp/client.h"

namespace mwidth::cli {

int RunSetFilter(const CommandLine& line) {
  const auto client = client::Client::Connect(line.server);
  const auto axis = client.Axis(line.axis).info();
  auto control = client.AcquireControl("mwidth set-filter", line.axis);
  const auto answer = line.validate_only ? control.ValidateFilter(line.estimator, line.cutoff_hz)
                                         : control.SetFilter(line.estimator, line.cutoff_hz);
  if (const auto* refusal = std::get_if<client::Refusal>(&answer)) {
    if (line.json) {
      std::cout << ToJson(refusal->status);
    } else {
      std::cerr << FilterRefusalReport(*refusal, axis);
    }
    return kRefused;
  }
  const auto& changed = std::get<v1::SetFilterResponse>(answer);
  std::cout << (line.json ? ToJson(changed) : FilterReport(changed, axis, line.validate_only));
  return kDone;
}

}  // namespace mwidth::cli
