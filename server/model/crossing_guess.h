// Where in a box of plants the smallest crossing mass probably lies.
#pragma once

#include <optional>

#include "server/model/crossing_range.h"
#include "server/model/estimator_range.h"
#include "server/model/loop_parameters.h"
#include "server/model/plant_range.h"

namespace mwidth::model {

/// The plant of `box` that has the smallest crossing mass at the frequency of `x` = sin^2(t/2), above 0, if
/// X, Y and V were everywhere as in the middle of `plant`: a linear programme of two equations. None where no
/// plant has a crossing there then. Only mu (as device_mass), beta (as device_damping), hand_stiffness and
/// delay_s are set. Not rigorous: a place to evaluate the nominal edge at. Precondition: `plant` is bounded.
/// Any thread.
std::optional<LoopParameters> GuessWorstPlant(double x, const PlantBox& box, const PlantRange& plant,
                                              const EstimatorRange& estimator, MassSign sign,
                                              double period_s) noexcept;

}  // namespace mwidth::model
