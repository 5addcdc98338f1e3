// What a drive says of itself, before anyone arms it.
#pragma once

#include <string>
#include <vector>

namespace mwidth::device {

/// One thing that was asked of a drive.
struct SurveyFinding {
  /// What was asked for: "position", "watchdog".
  std::string subject;
  /// What the drive answered, with its unit; or that it did not.
  std::string seen;
  /// What to do before the drive can be armed; empty where nothing need be done.
  std::string advice;
};

using SurveyReport = std::vector<SurveyFinding>;

}  // namespace mwidth::device
