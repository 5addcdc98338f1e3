// What an examination of the host found.
#pragma once

#include <cstdint>
#include <string>

namespace mwidth::doctor {

enum class Verdict : uint8_t {
  kOk,
  /// The loop runs, less punctually than it could.
  kWarning,
  /// The server would refuse to render on a real drive, or the loop would miss deadlines.
  kProblem,
};

/// One property of the host.
struct Finding {
  /// What was looked at: "kernel", "interrupts".
  std::string subject;
  Verdict verdict = Verdict::kOk;
  /// What was seen there.
  std::string seen;
  /// What to change; empty where nothing need be.
  std::string advice;
};

}  // namespace mwidth::doctor
