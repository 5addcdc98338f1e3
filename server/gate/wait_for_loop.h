// How a request waits for the loop.
#pragma once

#include <functional>

namespace mwidth::gate {

/// Calls its argument until it returns true or patience ends, and returns the last answer. Injected, so that
/// tests choose how time passes.
using WaitForLoop = std::function<bool(const std::function<bool()>& done)>;

/// Looks every half millisecond for at most 1 s of real time: far longer than any loop's period plus the ramp
/// to zero, short enough for a person. Blocks the calling thread; no lock may be held.
bool WaitUpToOneSecond(const std::function<bool()>& done);

}  // namespace mwidth::gate
