// Whether an axis moves along a line or about a joint.
#pragma once

#include <cstdint>

namespace mwidth::model {

/// Fixes the units of mass, position and force: kg, m, N or kg m^2, rad, N m. The equations are the same.
enum class AxisKind : uint8_t { kLinear, kRotary };

}  // namespace mwidth::model
