// Bounds on the virtual masses at which a box of loops has a root on an arc of the unit circle.
//
// The equation of plant_range.h is two real ones. With V = R + j sin(t) I, and M = m or M = -m,
//
//   k T^2/u - mu X = +-m R      beta T Y = +-m u I
//
// and, where strong damping makes X and Y move together, the first plus half of the second. At one
// frequency k and mu stand in the first alone and beta in the second: the range of m is then exact but for
// the widths of X, Y and V, so that a box of hands needs no division into small ones. At z = 1 and z = -1 the
// second equation, divided by sin(t) = 0, is none.
#pragma once

#include <limits>

#include "server/model/estimator_range.h"
#include "server/model/interval.h"
#include "server/model/plant_range.h"

namespace mwidth::model {

enum class MassSign { kNegative, kPositive };

/// V = R + j sin(t) I over an arc.
struct LoopRange {
  Interval re;    ///< R
  Interval u_im;  ///< u I: of an accelerometer I alone has no bound at standstill
};

/// V for a plant's shares of the latest forces, or for what an accelerometer sees of it. Any thread.
LoopRange LoopFactor(const EstimatorRange& estimator, const Arc& arc, const PlantRange& plant,
                     int delay_ticks) noexcept;

/// The sizes |M| of crossing masses lie in lo..hi; there are none where lo > hi.
struct CrossingSizes {
  double lo = 0;
  double hi = std::numeric_limits<double>::infinity();

  bool none() const { return lo > hi; }
};

/// Every |M| with a root on `arc`, for any plant of `plant` and any loop factor in `factor`. Any thread.
CrossingSizes BoundCrossings(const Arc& arc, const PlantRange& plant, const LoopRange& factor,
                             MassSign sign) noexcept;

/// Takes from `box` what alpha and kappa cannot be at a crossing on `arc` with a size in `sizes`, which is
/// not none. True where a good part is gone, so that Enclose is worth repeating. Any thread.
bool Narrow(PlantBox& box, const Arc& arc, const PlantRange& plant, const LoopRange& factor, MassSign sign,
            const CrossingSizes& sizes) noexcept;

}  // namespace mwidth::model
