// Numbers as text, in the C locale whatever the terminal's.
#pragma once

#include <string>

namespace mwidth::cli {

/// `value` with at most `digits` significant digits, for people: "0.35", "1.2e-05", "inf".
std::string Rounded(double value, int digits = 6);
/// The same, never farther from zero than `value`: what is printed as admitted must still be admitted when
/// somebody types it back.
std::string RoundedTowardZero(double value, int digits = 6);
/// `value` with 17 significant digits: reads back to the same double.
std::string Exact(double value);

}  // namespace mwidth::cli
