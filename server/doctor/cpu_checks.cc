#include <algorithm>

#include "server/doctor/checks.h"

namespace mwidth::doctor {
namespace {

constexpr std::size_t kMostNamed = 6;
const std::string kCpus = "sys/devices/system/cpu/";

bool Contains(const std::vector<int>& cpus, int cpu) {
  return std::find(cpus.begin(), cpus.end(), cpu) != cpus.end();
}

std::vector<int> CpuList(const HostFiles& host, const std::string& file) {
  return ParseCpuList(host.Text(file).value_or(""));
}

// The CPUs that loops run on: those that they are pinned to, or any.
std::vector<int> LoopCpus(const HostFiles& host, const Needs& needs) {
  if (needs.some_loop_unpinned || needs.cpus.empty()) {
    return CpuList(host, kCpus + "online");
  }
  std::vector<int> cpus = needs.cpus;
  std::sort(cpus.begin(), cpus.end());
  cpus.erase(std::unique(cpus.begin(), cpus.end()), cpus.end());
  return cpus;
}

// CPUs of loops that are not in `list`.
std::vector<int> Outside(const std::vector<int>& loops, const std::vector<int>& list) {
  std::vector<int> outside;
  for (const int cpu : loops) {
    if (!Contains(list, cpu) && !Contains(outside, cpu)) {
      outside.push_back(cpu);
    }
  }
  return outside;
}

std::vector<int> Shared(const std::vector<int>& loops) {
  std::vector<int> shared;
  for (const int cpu : loops) {
    if (std::count(loops.begin(), loops.end(), cpu) > 1 && !Contains(shared, cpu)) {
      shared.push_back(cpu);
    }
  }
  return shared;
}

// Where the interrupt is served, or, where the kernel does not tell, may be.
std::vector<int> ServedOn(const HostFiles& host, const std::string& interrupt) {
  const std::vector<int> effective = CpuList(host, interrupt + "effective_affinity_list");
  return effective.empty() ? CpuList(host, interrupt + "smp_affinity_list") : effective;
}

}  // namespace

Finding CheckIsolation(const HostFiles& host, const Needs& needs) {
  Finding finding{.subject = "isolation", .verdict = Verdict::kWarning, .seen = "", .advice = ""};
  const std::vector<int> missing = Outside(needs.cpus, CpuList(host, kCpus + "online"));
  const std::vector<int> shared = Shared(needs.cpus);
  const std::vector<int> open = Outside(needs.cpus, CpuList(host, kCpus + "isolated"));
  const std::vector<int> ticking = Outside(needs.cpus, CpuList(host, kCpus + "nohz_full"));
  if (!missing.empty()) {
    finding.verdict = Verdict::kProblem;
    finding.seen = "a loop is pinned to CPU " + Listed(missing) + ", which is not online";
    finding.advice = "set cpu in [axis.realtime] to one of " + host.Text(kCpus + "online").value_or("none");
  } else if (needs.some_loop_unpinned) {
    finding.seen = "a loop is not pinned to a CPU";
    finding.advice = "set cpu in [axis.realtime] to a CPU that nothing else uses";
  } else if (!shared.empty()) {
    finding.seen = "several loops share CPU " + Listed(shared);
    finding.advice = "give each loop a CPU of its own (cpu in [axis.realtime])";
  } else if (!open.empty()) {
    const std::string list = Listed(open);
    finding.seen = "CPU " + list + " of a loop is open to every other thread";
    finding.advice = "boot with isolcpus=managed_irq,domain,N nohz_full=N rcu_nocbs=N, where N is " + list;
  } else {
    finding.verdict = Verdict::kOk;
    finding.seen = "CPU " + Listed(needs.cpus) + " isolated" +
                   (ticking.empty() ? ", without the kernel's tick"
                                    : "; the kernel's tick goes on there (nohz_full would stop it)");
  }
  return finding;
}

Finding CheckInterrupts(const HostFiles& host, const Needs& needs) {
  Finding finding{.subject = "interrupts", .verdict = Verdict::kOk, .seen = "", .advice = ""};
  if (needs.cpus.empty()) {
    finding.seen = "not looked at: no loop is pinned to a CPU";
    return finding;
  }
  std::vector<std::string> near;
  for (const std::string& number : host.Folders("proc/irq")) {
    const std::string interrupt = "proc/irq/" + number + "/";
    const std::vector<std::string> devices = host.Folders(interrupt);
    const std::vector<int> cpus = ServedOn(host, interrupt);
    const bool meets_a_loop =
        std::any_of(cpus.begin(), cpus.end(), [&needs](int cpu) { return Contains(needs.cpus, cpu); });
    // Without a device behind it, it never comes.
    if (meets_a_loop && !devices.empty()) {
      near.push_back(number + " (" + Listed(devices) + ")");
    }
  }
  const std::string loops = "CPU " + Listed(LoopCpus(host, {.cpus = needs.cpus}));
  if (near.empty()) {
    finding.seen = "none on " + loops;
    return finding;
  }
  finding.verdict = Verdict::kWarning;
  const std::size_t count = near.size();
  near.resize(std::min(count, kMostNamed));
  finding.seen = std::to_string(count) + " may be served on " + loops + ": " + Listed(near) +
                 (count > kMostNamed ? ", ..." : "");
  finding.advice =
      "write other CPUs to /proc/irq/NUMBER/smp_affinity_list, boot with irqaffinity=, and keep irqbalance "
      "off these CPUs (IRQBALANCE_BANNED_CPULIST); the drive's own link is the exception";
  return finding;
}

Finding CheckGovernor(const HostFiles& host, const Needs& needs) {
  Finding finding{.subject = "CPU governor", .verdict = Verdict::kOk, .seen = "", .advice = ""};
  std::vector<std::string> slow;
  bool scaled = false;
  for (const int cpu : LoopCpus(host, needs)) {
    const auto governor = host.Text(kCpus + "cpu" + std::to_string(cpu) + "/cpufreq/scaling_governor");
    scaled |= governor.has_value();
    if (governor && *governor != "performance") {
      slow.push_back("CPU " + std::to_string(cpu) + " " + *governor);
    }
  }
  if (slow.empty()) {
    finding.seen = scaled ? "performance" : "none: this kernel does not change the CPUs' speed";
    return finding;
  }
  finding.verdict = Verdict::kWarning;
  finding.seen = Listed(slow) + ": ticks begin at a low speed";
  finding.advice = "cpupower frequency-set -g performance (Debian: linux-cpupower)";
  return finding;
}

Finding CheckIdleStates(const HostFiles& host, const Needs& needs) {
  const std::string device = "dev/cpu_dma_latency";
  Finding finding{.subject = "idle states", .verdict = Verdict::kOk, .seen = "", .advice = ""};
  int64_t slowest_us = 0;
  for (const int cpu : LoopCpus(host, needs)) {
    const std::string states = kCpus + "cpu" + std::to_string(cpu) + "/cpuidle/";
    for (const std::string& state : host.Folders(states)) {
      if (host.Number(states + state + "/disable").value_or(0) == 0) {
        slowest_us = std::max(slowest_us, host.Number(states + state + "/latency").value_or(0));
      }
    }
  }
  finding.seen = "the slowest takes " + std::to_string(slowest_us) + " us to wake from";
  if (needs.allow_deep_idle) {
    if (slowest_us > 0) {
      finding.verdict = Verdict::kWarning;
      finding.advice = "take allow_deep_idle out of [axis.realtime]";
    }
  } else if (!host.MayWrite(device)) {
    finding.verdict = Verdict::kProblem;
    finding.seen += ", and this process may not write /" + device + " to stay out of it";
    finding.advice = "let this user write it (a udev rule), or pass it into the container (--device /" +
                     device + "); or set allow_deep_idle = true in [axis.realtime]";
  } else {
    finding.seen += "; the server holds CPUs out of it through /" + device;
  }
  return finding;
}

Finding CheckVirtualCpus(const HostFiles& host, const Needs& needs) {
  Finding finding{.subject = "virtual CPUs", .verdict = Verdict::kOk, .seen = "", .advice = ""};
  const bool is_virtual = host.Text("proc/cpuinfo").value_or("").find(" hypervisor") != std::string::npos;
  if (!is_virtual) {
    finding.seen = "none: the CPUs tell of no hypervisor";
  } else if (needs.keep_cpus_awake) {
    finding.seen = "kept awake; what the hypervisor itself takes away cannot be had back";
  } else {
    finding.verdict = Verdict::kWarning;
    finding.seen = "a hypervisor takes a CPU away when it halts, and gives it back late";
    finding.advice = "set keep_cpus_awake = true in [server]; for a person's arm, use a host of its own";
  }
  return finding;
}

}  // namespace mwidth::doctor
