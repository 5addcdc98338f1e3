// What a watch reports.
#pragma once

#include "server/exchange/crossing.h"

namespace mwidth::render {

/// An assumption that does not hold: which fault it is, what was seen, and the limit that it was held
/// against. Without a fault: all is well.
struct Breach {
  exchange::Fault fault = exchange::Fault::kNone;
  double value = 0;
  double limit = 0;
};

}  // namespace mwidth::render
