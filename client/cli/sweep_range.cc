#include "client/cli/sweep_range.h"

#include <algorithm>
#include <charconv>
#include <vector>

#include <CLI/CLI.hpp>

namespace mwidth::cli {
namespace {

constexpr uint32_t kDefaultCount = 21;

std::vector<std::string> SplitAt(const std::string& text, char separator) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == separator) {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

template <typename Number>
Number Parse(const std::string& range, const std::string& text) {
  Number number{};
  const auto* const end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, number);
  if (result.ec != std::errc() || result.ptr != end) {
    throw CLI::ValidationError(
        range, "'" + text + "' is not a number that can stand here; NAME=FIRST:LAST[:COUNT][:log]");
  }
  return number;
}

// "CUTOFF_HZ" of SWEEP_PARAMETER_CUTOFF_HZ, in lower case.
std::string LowerCase(std::string name) {
  std::transform(name.begin(), name.end(), name.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return name;
}

v1::SweepParameter ParseParameter(const std::string& range, std::string name) {
  std::replace(name.begin(), name.end(), '-', '_');
  std::string known;
  for (int i = v1::SweepParameter_MIN + 1; i <= v1::SweepParameter_MAX; ++i) {
    const auto parameter = static_cast<v1::SweepParameter>(i);
    if (ParameterName(parameter) == name) {
      return parameter;
    }
    known += (known.empty() ? "" : ", ") + ParameterName(parameter);
  }
  throw CLI::ValidationError(range, "'" + name + "' is none of " + known);
}

}  // namespace

std::string ParameterName(v1::SweepParameter parameter) {
  constexpr std::string_view kPrefix = "SWEEP_PARAMETER_";
  return LowerCase(v1::SweepParameter_Name(parameter).substr(kPrefix.size()));
}

v1::SweepRange ParseSweepRange(const std::string& text) {
  constexpr size_t kMostParts = 4;
  const auto sides = SplitAt(text, '=');
  auto parts = SplitAt(sides.back(), ':');
  v1::SweepRange range;
  range.set_count(kDefaultCount);
  if (sides.size() == 2 && parts.size() > 2 && parts.back() == "log") {
    range.set_logarithmic(true);
    parts.pop_back();
  }
  if (sides.size() != 2 || parts.size() < 2 || parts.size() >= kMostParts) {
    throw CLI::ValidationError(text,
                               "a range is NAME=FIRST:LAST[:COUNT][:log], such as cutoff-hz=1:100:50:log");
  }
  range.set_parameter(ParseParameter(text, sides.front()));
  range.set_min(Parse<double>(text, parts[0]));
  range.set_max(Parse<double>(text, parts[1]));
  if (parts.size() > 2) {
    range.set_count(Parse<uint32_t>(text, parts[2]));
  }
  return range;
}

}  // namespace mwidth::cli
