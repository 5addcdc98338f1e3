// What acceleration_range.h bounds, with its slopes by a = 2 alpha and kappa: so that what the terms of e0,
// e1 and e2 have in common cancels, to first order, before anything is bounded.
//
// As long as h' >= 0 all through the tick for every plant of a box, h', h, Phi, d, eta and gamma all fall
// with a and with kappa: their slopes are convolutions of h', h, h_1 and y with each other, none of which is
// negative then, with a sign of minus. So do the sizes of the slopes fall, and two corners of the box bound
// everything. h' falls and h rises with v; so eta falls, and gamma and d rise. Each slope changes with v by
// at most 1 per tick.
#pragma once

#include <array>
#include <optional>

#include "server/model/acceleration_range.h"

namespace mwidth::model {

/// e0, e1 and e2 of acceleration_range.h; none where some plant may turn around within a tick (h' < 0) or
/// hardly moves any more at its end, where the sensor is so fast, from a rate of 64 per tick, that rounding
/// is not looked at here, and for a single plant, of which there is nothing to cancel. Any thread.
std::optional<std::array<Interval, 3>> EncloseRiseBySlopes(const SensedPlants& plants,
                                                           const Interval& rate) noexcept;

}  // namespace mwidth::model
