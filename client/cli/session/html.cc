#include "client/cli/session/html.h"

#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <ctime>

#include "client/cli/numbers.h"
#include "server/record/utf8.h"

namespace mwidth::cli::session {
namespace {

constexpr const char* kMinus = "\xE2\x88\x92";
constexpr const char* kNone = "\xE2\x80\x93";

std::string Escaped(char character) {
  switch (character) {
    case '&':
      return "&amp;";
    case '<':
      return "&lt;";
    case '>':
      return "&gt;";
    case '"':
      return "&quot;";
    case '\'':
      return "&#39;";
    case '\n':
    case '\t':
      return {character};
    default:
      return character < ' ' || character == '\x7f' ? record::kReplacementCharacter
                                                    : std::string(1, character);
  }
}

std::string WithTrueMinus(std::string text) {
  if (text.starts_with('-')) {
    // A zero has no sign for people.
    text.replace(0, 1, text.find_first_of("123456789") == std::string::npos ? "" : kMinus);
  }
  return text;
}

}  // namespace

std::string Escape(std::string_view text) {
  std::string escaped;
  while (!text.empty()) {
    const std::size_t length = record::Utf8CharacterLength(text);
    if (length == 0) {
      escaped += record::kReplacementCharacter;
    } else if (length == 1) {
      escaped += Escaped(text.front());
    } else {
      escaped += text.substr(0, length);
    }
    text.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return escaped;
}

std::string Fixed(std::optional<double> value, int digits, bool sign) {
  if (!value || !std::isfinite(*value)) {
    return kNone;
  }
  std::array<char, 400> text{};  // The largest double has 309 digits before its point.
  std::snprintf(text.data(), text.size(), sign ? "%+.*f" : "%.*f", digits, *value);
  return WithTrueMinus(text.data());
}

std::string Significant(std::optional<double> value, int digits) {
  if (!value || !std::isfinite(*value)) {
    return kNone;
  }
  return WithTrueMinus(Rounded(*value, digits));
}

std::string Counted(uint64_t count, std::string_view noun) {
  std::string text = std::to_string(count);
  for (auto at = static_cast<std::ptrdiff_t>(text.size()) - 3; at > 0; at -= 3) {
    text.insert(static_cast<std::size_t>(at), "\xE2\x80\xAF");  // A narrow space that does not break.
  }
  return text + " " + std::string(noun) + (count == 1 ? "" : "s");
}

std::string UtcText(int64_t wall_ns) {
  const auto seconds = std::chrono::floor<std::chrono::seconds>(std::chrono::nanoseconds(wall_ns));
  const auto time = static_cast<std::time_t>(seconds.count());
  std::tm parts{};
  gmtime_r(&time, &parts);
  std::array<char, 64> text{};
  return {text.data(), std::strftime(text.data(), text.size(), "%Y-%m-%d %H:%M:%S UTC", &parts)};
}

}  // namespace mwidth::cli::session
