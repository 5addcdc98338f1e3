// The smallest crossing mass of whole boxes of loops, by branch and bound.
#pragma once

#include <cstddef>
#include <span>

#include "server/model/crossing_range.h"
#include "server/model/loop_parameters.h"
#include "server/model/plant_range.h"

namespace mwidth::model {

/// The edge on one side of zero that every plant of the boxes keeps.
struct WorstEdge {
  /// No plant of any box has a crossing on this side with a size |M| below this: proved.
  double proved = 0;
  /// Smallest nominal edge that was found, as a size; at least `proved`.
  double found = 0;
  /// Its loop, with mu as device_mass and beta as device_damping, and which box it is of.
  LoopParameters binding;
  std::size_t binding_box = 0;
  /// Boxes of frequencies and plants that were bounded.
  int boxes = 0;
  /// Loops whose nominal edges were computed.
  int nominal_queries = 0;
};

/// What all loops of a search have in common.
struct Sampling {
  double period_s = 0;
  double cutoff_hz = 0;
  EstimatorKind estimator = EstimatorKind::kFilteredDifference;
  double accelerometer_bandwidth_hz = 0;
};

struct SearchEffort {
  /// Ends the search once `proved` is at least (1 - tolerance) `found`.
  double tolerance = 0;
  /// Ends it after about so many boxes; what is proved by then is sound, too, if less tight.
  int max_boxes = 0;
};

/// Branch and bound, best first: the box of frequencies and plants with the smallest possible crossing is
/// halved, in the direction that raises the bounds of its halves most, until the smallest bound of all boxes
/// comes up to the smallest nominal edge found in them. Neither the choice of boxes nor the nominal edges can
/// make the result unsound, only less tight.
///
/// `boxes` is not empty; their mass is above 0, their damping above 0 unless their stiffness is exactly 0.
/// Any thread; allocates.
WorstEdge FindWorstEdge(std::span<const PlantBox> boxes, const Sampling& sampling, MassSign sign,
                        const SearchEffort& effort);

}  // namespace mwidth::model
