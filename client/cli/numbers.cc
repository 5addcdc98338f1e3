#include "client/cli/numbers.h"

#include <array>
#include <charconv>
#include <cmath>

namespace mwidth::cli {
namespace {

std::string Format(double value, std::chars_format format, int precision) {
  // Enough for a sign, 17 digits, a point and an exponent; to_chars cannot fail then.
  std::array<char, 40> text{};
  const char* const end = std::to_chars(text.data(), text.data() + text.size(), value, format, precision).ptr;
  return {text.data(), static_cast<size_t>(end - text.data())};
}

}  // namespace

std::string Rounded(double value, int digits) { return Format(value, std::chars_format::general, digits); }

std::string RoundedTowardZero(double value, int digits) {
  auto text = Rounded(value, digits);
  if (!std::isfinite(value) || std::abs(std::stod(text)) <= std::abs(value)) {
    return text;
  }
  // Rounding went outward: take off one unit of the last digit that `value` itself has.
  const auto scientific = Format(value, std::chars_format::scientific, 16);
  const auto exponent = std::stoi(scientific.substr(scientific.find('e') + 1));
  const auto unit = std::pow(10.0, exponent - digits + 1);
  return Rounded(std::stod(text) - std::copysign(unit, value), digits);
}

std::string Exact(double value) { return Format(value, std::chars_format::general, 17); }

}  // namespace mwidth::cli
