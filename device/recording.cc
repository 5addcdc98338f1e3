#include "device/recording.h"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>

namespace mwidth::device {
namespace {

constexpr std::string_view kTimeColumn = "time_s";
constexpr std::string_view kBlank = " \t\r";
// Spreadsheets put it before UTF-8.
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

std::string_view Trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kBlank);
  return first == std::string_view::npos ? std::string_view{}
                                         : text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

std::vector<std::string_view> Fields(std::string_view line) {
  std::vector<std::string_view> fields;
  while (true) {
    const std::size_t comma = line.find(',');
    fields.push_back(Trimmed(line.substr(0, comma)));
    if (comma == std::string_view::npos) {
      return fields;
    }
    line.remove_prefix(comma + 1);
  }
}

/// The file's rows, one at a time, with the two columns that count.
class Reader {
 public:
  Reader(const std::filesystem::path& file, model::AxisKind kind) : file_(file), stream_(file) {
    // A directory opens as a stream, and fails only when it is read.
    if (!stream_ || std::filesystem::is_directory(file)) {
      throw std::runtime_error(file_.string() + ": cannot be read (" +
                               std::generic_category().message(stream_ ? EISDIR : errno) +
                               "); expected a CSV file of recorded reaches");
    }
    ReadHeader(kind == model::AxisKind::kRotary ? "_rad" : "_m");
  }

  /// False at the end of the file. Blank lines are skipped.
  bool Next(double& time_s, double& position) {
    do {
      if (!std::getline(stream_, text_)) {
        return false;
      }
      ++line_;
    } while (Trimmed(text_).empty());
    const std::vector<std::string_view> fields = Fields(text_);
    if (fields.size() != names_.size()) {
      Fail(line_, std::to_string(fields.size()) + " columns; expected " + std::to_string(names_.size()) +
                      " as in the header");
    }
    time_s = Number(fields, time_column_);
    position = Number(fields, position_column_);
    return true;
  }

  int line() const { return line_; }

  [[noreturn]] void Fail(int line, const std::string& what) const {
    throw std::runtime_error(file_.string() + ":" + std::to_string(line) + ": " + what);
  }

 private:
  void ReadHeader(std::string_view position_ending) {
    std::getline(stream_, text_);
    if (text_.starts_with(kByteOrderMark)) {
      text_.erase(0, kByteOrderMark.size());
    }
    for (const std::string_view name : Fields(text_)) {
      names_.emplace_back(name);
    }
    time_column_ = TheOnly([](const std::string& name) { return name == kTimeColumn; },
                           "named " + std::string(kTimeColumn));
    position_column_ = TheOnly([=](const std::string& name) { return name.ends_with(position_ending); },
                               "for the position whose name ends in " + std::string(position_ending));
  }

  template <typename Predicate>
  std::size_t TheOnly(Predicate predicate, const std::string& what) const {
    const auto matches = std::count_if(names_.begin(), names_.end(), predicate);
    if (matches != 1) {
      Fail(1, std::to_string(matches) + " columns " + what + "; expected a header line with one");
    }
    return static_cast<std::size_t>(
        std::distance(names_.begin(), std::find_if(names_.begin(), names_.end(), predicate)));
  }

  double Number(const std::vector<std::string_view>& fields, std::size_t column) const {
    const std::string_view field = fields[column];
    double value = 0;
    const auto [end, error] = std::from_chars(field.begin(), field.end(), value);
    if (error != std::errc() || end != field.end() || !std::isfinite(value)) {
      Fail(line_, "column " + names_[column] + " is '" + std::string(field) + "'; expected a finite number");
    }
    return value;
  }

  std::filesystem::path file_;
  std::ifstream stream_;
  std::string text_;
  int line_ = 1;
  std::vector<std::string> names_;
  std::size_t time_column_ = 0;
  std::size_t position_column_ = 0;
};

std::string Seconds(double time_s) {
  std::ostringstream text;
  text << time_s << " s";
  return text.str();
}

}  // namespace

std::vector<Reach> ReadRecording(const std::filesystem::path& file, model::AxisKind kind) {
  Reader reader(file, kind);
  std::vector<Reach> reaches;
  int reach_line = 0;
  const auto check_length = [&] {
    if (!reaches.empty() && reaches.back().times_s.size() < Reach::kMinSamples) {
      reader.Fail(reach_line, "reach " + std::to_string(reaches.size()) + ", which begins here, has " +
                                  std::to_string(reaches.back().times_s.size()) +
                                  " samples; expected at least " + std::to_string(Reach::kMinSamples));
    }
  };
  double time_s = 0;
  double position = 0;
  while (reader.Next(time_s, position)) {
    if (time_s == 0) {
      check_length();
      reaches.emplace_back();
      reach_line = reader.line();
    } else if (reaches.empty()) {
      reader.Fail(reader.line(),
                  "the first time is " + Seconds(time_s) + "; expected 0, where a reach begins");
    } else if (time_s <= reaches.back().times_s.back()) {
      reader.Fail(reader.line(), "time " + Seconds(time_s) + " does not rise from " +
                                     Seconds(reaches.back().times_s.back()) +
                                     "; expected a later time, or 0 where a new reach begins");
    }
    reaches.back().times_s.push_back(time_s);
    reaches.back().positions.push_back(position);
  }
  if (reaches.empty()) {
    reader.Fail(reader.line(), "no samples; expected at least " + std::to_string(Reach::kMinSamples));
  }
  check_length();
  return reaches;
}

}  // namespace mwidth::device
