#include <algorithm>
#include <array>
#include <string_view>

#include "server/doctor/checks.h"

namespace mwidth::doctor {
namespace {

// Read in user space, by the vDSO.
constexpr std::array<std::string_view, 4> kFastClockSources = {"tsc", "arch_sys_counter", "kvm-clock",
                                                               "hyperv_clocksource_tsc_page"};

}  // namespace

Finding CheckKernel(const HostFiles& host, const Needs&) {
  Finding finding{.subject = "kernel", .verdict = Verdict::kOk, .seen = "", .advice = ""};
  const std::string version = host.Text("proc/version").value_or("");
  if (host.Number("sys/kernel/realtime") == 1 || version.find("PREEMPT_RT") != std::string::npos) {
    finding.seen = "PREEMPT_RT";
    return finding;
  }
  const bool preemptible = version.find("PREEMPT") != std::string::npos;
  finding.verdict = Verdict::kWarning;
  finding.seen = preemptible ? "preemptible, but not PREEMPT_RT: interrupts and drivers may hold a loop up"
                             : "not preemptible: any system call of another program may hold a loop up";
  finding.advice = "boot a PREEMPT_RT kernel (Debian: linux-image-rt-amd64)";
  if (preemptible) {
    finding.advice += "; without one, boot with preempt=full";
  }
  return finding;
}

Finding CheckClockSource(const HostFiles& host, const Needs&) {
  Finding finding{.subject = "clock source", .verdict = Verdict::kOk, .seen = "", .advice = ""};
  const std::string source =
      host.Text("sys/devices/system/clocksource/clocksource0/current_clocksource").value_or("unknown");
  finding.seen = source;
  if (std::find(kFastClockSources.begin(), kFastClockSources.end(), source) == kFastClockSources.end()) {
    finding.verdict = Verdict::kWarning;
    finding.seen += ": each look at the time may be a slow system call";
    finding.advice =
        "see why the kernel gave up the CPU's own counter (dmesg | grep -i clocksource), often unstable "
        "firmware or a hypervisor's setting";
  }
  return finding;
}

}  // namespace mwidth::doctor
