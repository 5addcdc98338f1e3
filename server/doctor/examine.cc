#include "server/doctor/examine.h"

#include "server/doctor/checks.h"

namespace mwidth::doctor {

std::vector<Finding> Examine(const HostFiles& host, const Needs& needs) {
  std::vector<Finding> findings;
  for (const auto check :
       {CheckKernel, CheckPriority, CheckLockedMemory, CheckThrottling, CheckQuota, CheckIsolation,
        CheckInterrupts, CheckGovernor, CheckIdleStates, CheckVirtualCpus, CheckClockSource}) {
    findings.push_back(check(host, needs));
  }
  return findings;
}

}  // namespace mwidth::doctor
