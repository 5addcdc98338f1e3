// Numbers and units as people read them in a refusal.
#pragma once

#include <string>

#include "server/model/axis_kind.h"

namespace mwidth::gate {

/// Six significant digits, such as "0.0697562".
std::string Figure(double value);

/// The same, rounded towards zero: a number that is admitted is still admitted as printed.
std::string FigureTowardsZero(double value);

/// "kg" or "kg m^2".
std::string MassUnit(model::AxisKind kind);
/// "m" or "rad".
std::string PositionUnit(model::AxisKind kind);
/// "N" or "N m".
std::string ForceUnit(model::AxisKind kind);

}  // namespace mwidth::gate
