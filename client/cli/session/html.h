// Text and numbers for a page.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace mwidth::cli::session {

/// `text`, which anybody may have written, as text of HTML or as a quoted attribute: it can neither end its
/// place nor begin a tag. Bytes that are no UTF-8, and control characters, become replacement characters.
std::string Escape(std::string_view text);

/// `value` to `digits` after the point with a true minus sign, "+" before positive ones where `sign`;
/// "–" where there is none, or where it is not finite.
std::string Fixed(std::optional<double> value, int digits, bool sign = false);

/// `value` to so many significant digits, without exponents from 1e-5 to 1e7.
std::string Significant(std::optional<double> value, int digits = 4);

/// "1 sample", "2 samples", "1 234 567 samples".
std::string Counted(uint64_t count, std::string_view noun);

/// "2026-11-22 06:32:15 UTC" of nanoseconds since 1970.
std::string UtcText(int64_t wall_ns);

}  // namespace mwidth::cli::session
