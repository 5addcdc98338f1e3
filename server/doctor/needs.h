// What a configuration wants of its host.
#pragma once

#include <vector>

namespace mwidth::doctor {

struct Needs {
  /// Largest SCHED_FIFO priority of the loops.
  int priority = 0;
  /// CPUs that loops are pinned to, one for each of those loops.
  std::vector<int> cpus;
  /// A loop is pinned to none.
  bool some_loop_unpinned = false;
  bool keep_cpus_awake = false;
  /// True where no loop asks for idle CPUs that wake at once.
  bool allow_deep_idle = false;
};

}  // namespace mwidth::doctor
