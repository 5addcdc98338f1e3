#include "server/doctor_command.h"

#include <algorithm>
#include <iostream>
#include <vector>

#include "server/doctor/examine.h"
#include "server/doctor/report.h"

namespace mwidth::server {
namespace {

doctor::Needs NeedsOf(const Config& config) {
  doctor::Needs needs{.cpus = PinnedCpus(config), .keep_cpus_awake = config.keep_cpus_awake};
  needs.allow_deep_idle = true;
  for (const AxisConfig& axis : config.axes) {
    needs.priority = std::max(needs.priority, axis.realtime.priority);
    needs.some_loop_unpinned |= !axis.realtime.cpu.has_value();
    needs.allow_deep_idle &= axis.realtime.allow_deep_idle;
  }
  return needs;
}

}  // namespace

int RunDoctor(const Config& config, const std::filesystem::path& root, bool json) {
  const std::vector<doctor::Finding> findings = Examine(doctor::HostFiles(root), NeedsOf(config));
  std::cout << (json ? JsonReport(findings) : TextReport(findings));
  return Count(findings, doctor::Verdict::kProblem) == 0 ? 0 : 1;
}

}  // namespace mwidth::server
