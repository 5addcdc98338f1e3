// A program run to its end, with what it printed.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace mwidth::testing {

struct Outcome {
  /// Exit code, or 128 and the number of the signal that ended it.
  int code = -1;
  std::string out;
  std::string err;
};

/// Runs `command` with `arguments`, MWIDTH_SERVER set to `server`, and waits for its end. `meanwhile` is
/// called with its process id once it runs.
Outcome RunProgram(const std::string& command, const std::vector<std::string>& arguments,
                   const std::string& server, const std::function<void(int pid)>& meanwhile = {});

}  // namespace mwidth::testing
