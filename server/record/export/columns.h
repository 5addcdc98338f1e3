// What an export has of each sample: one column for each quantity, with its unit and its meaning.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "server/exchange/crossing.h"

namespace mwidth::record {

/// A value out of a short list: a number for files of numbers, a word for files of text.
struct Coded {
  uint8_t code = 0;
  std::string_view word;
};

using Value = std::variant<uint64_t, int64_t, int32_t, bool, double, Coded>;

struct Column {
  /// Without its unit: "position".
  std::string name;
  /// As in the head of `mwidth stream --csv`: "position_rad".
  std::string csv_name;
  /// "rad", "N m"; "1" for counts and numbers.
  std::string units;
  std::string description;
  Value (*of)(const exchange::Sample&);
  /// The words of a Coded column, by their code; empty for all others.
  std::vector<std::string_view> words;
};

/// In the order of `mwidth stream --csv`, then what that leaves out. `rotary`: rad and N m, otherwise m and
/// N. What a sample carries for replay alone (the memory of its filter) is no column.
std::vector<Column> SampleColumns(bool rotary);

/// "idle", "ready", "rendering" or "fault"; "unknown" for anything else.
std::string_view StateWord(exchange::State state);

}  // namespace mwidth::record
