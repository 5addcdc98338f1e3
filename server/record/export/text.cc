#include "server/record/export/text.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cstdio>

namespace mwidth::record {
namespace {

template <typename Number>
void Append(std::string& out, Number value) {
  // Enough for a sign, 17 digits, a point and an exponent, and for any 64-bit integer; to_chars cannot fail.
  std::array<char, 32> text{};
  const char* const end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  out.append(text.data(), static_cast<size_t>(end - text.data()));
}

std::string Quoted(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    quoted.append(c == '"' ? 2 : 1, c);
  }
  return quoted + '"';
}

struct Appender {
  std::string& out;
  void operator()(double value) const { AppendNumber(out, value); }
  void operator()(bool value) const { out += value ? '1' : '0'; }
  void operator()(const Coded& value) const { out += value.word; }
  template <typename Integer>
  void operator()(Integer value) const {
    Append(out, value);
  }
};

}  // namespace

void AppendNumber(std::string& out, double value) { Append(out, value); }

std::string Number(double value) {
  std::string text;
  AppendNumber(text, value);
  return text;
}

void AppendValue(std::string& out, const Value& value) { std::visit(Appender{out}, value); }

std::string UtcTime(int64_t wall_ns) {
  using std::chrono::floor;
  const std::chrono::sys_time<std::chrono::microseconds> time{
      floor<std::chrono::microseconds>(std::chrono::nanoseconds(wall_ns))};
  const auto day = floor<std::chrono::days>(time);
  const std::chrono::year_month_day date{day};
  const std::chrono::hh_mm_ss clock{time - day};
  std::array<char, 64> text{};
  const int length = std::snprintf(
      text.data(), text.size(), "%04d-%02u-%02uT%02d:%02d:%02d.%06dZ", static_cast<int>(date.year()),
      static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()),
      static_cast<int>(clock.hours().count()), static_cast<int>(clock.minutes().count()),
      static_cast<int>(clock.seconds().count()), static_cast<int>(clock.subseconds().count()));
  return {text.data(), static_cast<size_t>(length)};
}

std::string CsvCell(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) {
    return std::string(text);
  }
  return Quoted(text);
}

std::string TsvCell(std::string_view text) {
  std::string cell(text);
  std::replace_if(
      cell.begin(), cell.end(), [](unsigned char c) { return c < 0x20 || c == 0x7F; }, ' ');
  if (cell.find_first_not_of(' ') == std::string::npos) {
    return "n/a";
  }
  return cell.starts_with('"') ? Quoted(cell) : cell;
}

}  // namespace mwidth::record
