// The units of an axis, by its kind.
#pragma once

#include <mwidth/v1/rendering.pb.h>

namespace mwidth::cli {

/// For people, and for the column names of a CSV file.
struct Unit {
  const char* text;
  const char* suffix;
};

struct Units {
  Unit mass;
  Unit position;
  Unit velocity;
  Unit acceleration;
  Unit force;
  Unit damping;
  Unit stiffness;
};

/// Units of an axis of `kind`; of a linear one where the kind is unknown.
inline const Units& UnitsOf(v1::AxisKind kind) {
  static constexpr Units kLinear{.mass = {"kg", "kg"},
                                 .position = {"m", "m"},
                                 .velocity = {"m/s", "m_per_s"},
                                 .acceleration = {"m/s²", "m_per_s2"},
                                 .force = {"N", "n"},
                                 .damping = {"N s/m", "n_s_per_m"},
                                 .stiffness = {"N/m", "n_per_m"}};
  static constexpr Units kRotary{.mass = {"kg m²", "kg_m2"},
                                 .position = {"rad", "rad"},
                                 .velocity = {"rad/s", "rad_per_s"},
                                 .acceleration = {"rad/s²", "rad_per_s2"},
                                 .force = {"N m", "n_m"},
                                 .damping = {"N m s/rad", "n_m_s_per_rad"},
                                 .stiffness = {"N m/rad", "n_m_per_rad"}};
  return kind == v1::AXIS_KIND_ROTARY ? kRotary : kLinear;
}

}  // namespace mwidth::cli
