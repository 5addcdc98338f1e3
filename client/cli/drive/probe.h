// Looks at the drive of a configuration, without a server.
#pragma once

#include <string>
#include <vector>

namespace mwidth::drive {

/// What was asked of the drive, what it answered, and what to do before it can be armed (empty: nothing).
struct Finding {
  std::string subject;
  std::string seen;
  std::string advice;
};

struct Probe {
  std::string axis;
  std::vector<Finding> findings;
};

/// Reads, and commands nothing: the motor stays as it is. `name_or_file` as for mwidthd --config; `axis` may
/// be empty where there is one; `address` stands for the configured one unless it is empty, as for mwidthd
/// --drive. Throws std::runtime_error, with what to do, for a configuration without such a drive, and where
/// the drive cannot be reached or a server holds it.
Probe ProbeDrive(const std::string& name_or_file, const std::string& axis, const std::string& address);

}  // namespace mwidth::drive
