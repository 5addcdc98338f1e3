// One check for each property of a host. Sources of the criteria: the kernel's
// Documentation/scheduler/sched-rt-group, power/pm_qos_interface, timers/no_hz and
// admin-guide/kernel-parameters, and proc(5).
#pragma once

#include "server/doctor/finding.h"
#include "server/doctor/host_files.h"
#include "server/doctor/needs.h"

namespace mwidth::doctor {

/// Can a running kernel path hold a loop up?
Finding CheckKernel(const HostFiles& host, const Needs& needs);
/// Is the time read without a system call?
Finding CheckClockSource(const HostFiles& host, const Needs& needs);

/// May this process have the priority that its loops ask for?
Finding CheckPriority(const HostFiles& host, const Needs& needs);
/// May it lock its memory?
Finding CheckLockedMemory(const HostFiles& host, const Needs& needs);
/// Does the kernel leave real-time threads their time?
Finding CheckThrottling(const HostFiles& host, const Needs& needs);
/// Is the rest of the server stopped when its container has used up its share?
Finding CheckQuota(const HostFiles& host, const Needs& needs);

/// Have the loops CPUs to themselves?
Finding CheckIsolation(const HostFiles& host, const Needs& needs);
/// Are devices served elsewhere than on the loops' CPUs?
Finding CheckInterrupts(const HostFiles& host, const Needs& needs);
/// Do the CPUs keep their speed?
Finding CheckGovernor(const HostFiles& host, const Needs& needs);
/// Do idle CPUs wake at once?
Finding CheckIdleStates(const HostFiles& host, const Needs& needs);
/// Does a hypervisor take away CPUs that halt?
Finding CheckVirtualCpus(const HostFiles& host, const Needs& needs);

}  // namespace mwidth::doctor
