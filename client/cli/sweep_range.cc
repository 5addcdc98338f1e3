#include "client/cli/sweep_range.h"

#include <algorithm>
#include <charconv>
#include <vector>

#include <CLI/CLI.hpp>

#include "client/cli/enum_words.h"

namespace mwidth::cli {
namespace {

constexpr uint32_t kDefaultCount = 21;
constexpr const char* kSweepForm = "NAME=FIRST:LAST[:COUNT][:log]";

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
Number Parse(const std::string& name, const std::string& text, const char* form) {
  Number number{};
  const auto* const end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, number);
  if (result.ec != std::errc() || result.ptr != end) {
    throw CLI::ValidationError(name, "'" + text + "' is not a number that can stand here; " + form);
  }
  return number;
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
  return EnumWords(v1::SweepParameter_Name(parameter), "SWEEP_PARAMETER_", '_');
}

v1::ParameterRange ParseParameterRange(const std::string& option, const std::string& text) {
  constexpr const char* kForm = "MIN:MAX, such as 100:2000";
  const auto parts = SplitAt(text, ':');
  if (parts.size() != 2) {
    throw CLI::ValidationError(option, "'" + text + "' is no range: " + kForm);
  }
  v1::ParameterRange range;
  range.set_min(Parse<double>(option, parts[0], kForm));
  range.set_max(Parse<double>(option, parts[1], kForm));
  return range;
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
  range.set_min(Parse<double>(text, parts[0], kSweepForm));
  range.set_max(Parse<double>(text, parts[1], kSweepForm));
  if (parts.size() > 2) {
    range.set_count(Parse<uint32_t>(text, parts[2], kSweepForm));
  }
  return range;
}

}  // namespace mwidth::cli
