// How quantities of an axis are shown to people: degrees and millimetres, as they think of joints and slides.
#pragma once

#include <numbers>
#include <string>

#include "server/exchange/crossing.h"
#include "server/model/estimator_kind.h"

namespace mwidth::cli::session {

struct Display {
  /// Shown = recorded times this; of positions and velocities.
  double scale;
  const char* position;
  const char* velocity;
  int position_digits;
  const char* mass;
  const char* force;
  const char* damping;
  const char* stiffness;
};

inline const Display& DisplayOf(bool rotary) {
  static constexpr Display kLinear{.scale = 1000,
                                   .position = "mm",
                                   .velocity = "mm/s",
                                   .position_digits = 1,
                                   .mass = "kg",
                                   .force = "N",
                                   .damping = "N s/m",
                                   .stiffness = "N/m"};
  static constexpr Display kRotary{.scale = 180 / std::numbers::pi,
                                   .position = "°",
                                   .velocity = "°/s",
                                   .position_digits = 1,
                                   .mass = "kg m²",
                                   .force = "N m",
                                   .damping = "N m s/rad",
                                   .stiffness = "N m/rad"};
  return rotary ? kRotary : kLinear;
}

/// "filtered-difference, 20 Hz".
std::string FilterWords(const exchange::Filter& filter);

}  // namespace mwidth::cli::session
