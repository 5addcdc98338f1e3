#include "server/gate/figures.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace mwidth::gate {
namespace {

constexpr int kDigits = 6;

}  // namespace

std::string Figure(double value) {
  std::array<char, 32> text{};
  const int length = std::snprintf(text.data(), text.size(), "%.*g", kDigits, value);
  return {text.data(), static_cast<std::size_t>(length)};
}

std::string FigureTowardsZero(double value) {
  std::string rounded = Figure(value);
  const double excess = std::abs(std::strtod(rounded.c_str(), nullptr)) - std::abs(value);
  if (!(excess > 0)) {
    return rounded;
  }
  // Rounding went outwards, so one unit of the last digit takes it back inside.
  const double unit = std::pow(10.0, std::floor(std::log10(std::abs(value))) - (kDigits - 1));
  return Figure(std::copysign(std::abs(std::strtod(rounded.c_str(), nullptr)) - unit, value));
}

std::string MassUnit(model::AxisKind kind) { return kind == model::AxisKind::kLinear ? "kg" : "kg m^2"; }

std::string PositionUnit(model::AxisKind kind) { return kind == model::AxisKind::kLinear ? "m" : "rad"; }

std::string ForceUnit(model::AxisKind kind) { return kind == model::AxisKind::kLinear ? "N" : "N m"; }

}  // namespace mwidth::gate
