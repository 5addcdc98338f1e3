#include <linux/capability.h>

#include <charconv>
#include <cstdint>
#include <limits>
#include <sstream>

#include "server/doctor/checks.h"

namespace mwidth::doctor {
namespace {

// What the loops may need of a CPU: at most half for polling before deadlines, the rest for the ticks.
constexpr double kLeastShare = 0.9;

/// The soft limit `name` of /proc/self/limits; "unlimited" is the largest number. None where it does not
/// stand.
std::optional<int64_t> SoftLimit(const HostFiles& host, const std::string& name) {
  std::istringstream lines(host.Text("proc/self/limits").value_or(""));
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with(name)) {
      continue;
    }
    std::istringstream columns(line.substr(name.size()));
    std::string soft;
    columns >> soft;
    int64_t limit = std::numeric_limits<int64_t>::max();
    if (soft != "unlimited" &&
        std::from_chars(soft.data(), soft.data() + soft.size(), limit).ec != std::errc()) {
      return std::nullopt;
    }
    return limit;
  }
  return std::nullopt;
}

bool HasCapability(const HostFiles& host, unsigned capability) {
  const std::string status = host.Text("proc/self/status").value_or("");
  const std::string key = "CapEff:\t";
  const std::size_t at = status.find(key);
  if (at == std::string::npos) {
    return false;
  }
  uint64_t effective = 0;
  std::from_chars(status.data() + at + key.size(), status.data() + status.size(), effective, 16);
  return (effective >> capability & 1U) != 0;
}

}  // namespace

Finding CheckPriority(const HostFiles& host, const Needs& needs) {
  Finding finding{.subject = "real-time priority", .verdict = Verdict::kOk, .seen = "", .advice = ""};
  const std::string wanted = "SCHED_FIFO priority " + std::to_string(needs.priority);
  const int64_t limit = SoftLimit(host, "Max realtime priority").value_or(0);
  if (HasCapability(host, CAP_SYS_NICE)) {
    finding.seen = wanted + " by CAP_SYS_NICE";
  } else if (limit >= needs.priority) {
    finding.seen = wanted + " within the limit of " + std::to_string(limit);
  } else {
    finding.verdict = Verdict::kProblem;
    finding.seen = wanted + " is beyond this process's limit of " + std::to_string(limit);
    finding.advice =
        "set 'rtprio 99' in /etc/security/limits.conf and log in anew, or LimitRTPRIO=99 in the service "
        "unit, "
        "or grant CAP_SYS_NICE; in a container, --cap-add=SYS_NICE --ulimit rtprio=99";
  }
  return finding;
}

Finding CheckLockedMemory(const HostFiles& host, const Needs&) {
  Finding finding{.subject = "locked memory", .verdict = Verdict::kOk, .seen = "", .advice = ""};
  const int64_t limit = SoftLimit(host, "Max locked memory").value_or(0);
  if (HasCapability(host, CAP_IPC_LOCK)) {
    finding.seen = "all, by CAP_IPC_LOCK";
  } else if (limit == std::numeric_limits<int64_t>::max()) {
    finding.seen = "unlimited";
  } else {
    finding.verdict = Verdict::kProblem;
    finding.seen = "limited to " + std::to_string(limit / 1024) + " KiB: a tick may wait for a page";
    finding.advice =
        "set 'memlock unlimited' in /etc/security/limits.conf and log in anew, or LimitMEMLOCK=infinity in "
        "the service unit, or grant CAP_IPC_LOCK";
  }
  return finding;
}

Finding CheckThrottling(const HostFiles& host, const Needs&) {
  Finding finding{.subject = "throttling", .verdict = Verdict::kOk, .seen = "", .advice = ""};
  const auto runtime_us = host.Number("proc/sys/kernel/sched_rt_runtime_us");
  const auto period_us = host.Number("proc/sys/kernel/sched_rt_period_us");
  if (!runtime_us || !period_us || *period_us <= 0) {
    finding.seen = "this kernel tells no limit";
  } else if (*runtime_us < 0) {
    finding.seen = "off: nothing would stop a thread that runs away";
  } else {
    const double share = static_cast<double>(*runtime_us) / static_cast<double>(*period_us);
    finding.seen = "real-time threads may use " + std::to_string(static_cast<int>(100 * share)) +
                   " % of each CPU, " + std::to_string(*runtime_us) + " of every " +
                   std::to_string(*period_us) + " us";
    if (share < kLeastShare) {
      finding.verdict = *runtime_us == 0 ? Verdict::kProblem : Verdict::kWarning;
      finding.advice = "sysctl -w kernel.sched_rt_runtime_us=950000 kernel.sched_rt_period_us=1000000";
    }
  }
  return finding;
}

Finding CheckQuota(const HostFiles& host, const Needs& needs) {
  Finding finding{.subject = "CPU quota", .verdict = Verdict::kOk, .seen = "none", .advice = ""};
  const std::string quota = host.Text("sys/fs/cgroup/cpu.max").value_or("max");
  if (quota.starts_with("max")) {
    return finding;
  }
  finding.verdict = needs.keep_cpus_awake ? Verdict::kProblem : Verdict::kWarning;
  finding.seen = "this control group may use '" + quota +
                 "' us: beyond it everything but the loops stands still" +
                 (needs.keep_cpus_awake ? ", and keep_cpus_awake uses it up" : "");
  finding.advice =
      "give the container or service whole CPUs (--cpuset-cpus, AllowedCPUs=) instead of a quota";
  return finding;
}

}  // namespace mwidth::doctor
