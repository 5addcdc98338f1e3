// What a loop's ticks took, as a message.
#pragma once

#include "mwidth/v1/rendering.pb.h"
#include "server/exchange/tick_statistics.h"

namespace mwidth::rpc {

/// Fills an empty message with the figures of this moment.
void Convert(const exchange::TickStatistics& statistics, v1::TickStatistics& message);

}  // namespace mwidth::rpc
