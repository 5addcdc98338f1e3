// The loops that benchmarks run on.
#pragma once

#include <vector>

#include "server/model/loop_parameters.h"

namespace mwidth::bench {

/// Table II of the paper with a 10 Hz filter at 1 kHz, and a delay.
model::LoopParameters PaperLoop(double delay_ticks = 0);

/// `count` loops without delay from the box over which the closed form must be exact; the same every time.
std::vector<model::LoopParameters> BoxLoops(int count);

}  // namespace mwidth::bench
