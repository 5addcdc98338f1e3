// One table of the configuration file, read key by key: each key has a type and a range, and no other key may
// stand.
#pragma once

#include <toml++/toml.h>
#include <filesystem>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>

namespace mwidth::server {

/// A configuration that cannot be used. what() names the file, the line, the key and what is allowed.
class ConfigError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// An inclusive range of numbers, unless `above_min` leaves its lower end out.
struct Range {
  double min;
  double max;
  bool above_min = false;
};

/// Reads the keys of one TOML table and, in Finish, refuses those that nobody read. Throws ConfigError naming
/// file, line, key and what is allowed.
class ConfigTable {
 public:
  /// `path` is the table's full name, such as "axis.loop", empty for the file itself.
  ConfigTable(const toml::table& table, std::filesystem::path file, std::string path);

  double Number(std::string_view key, Range allowed);
  double NumberOr(std::string_view key, Range allowed, double otherwise);
  std::optional<double> OptionalNumber(std::string_view key, Range allowed);
  int Integer(std::string_view key, Range allowed);
  int IntegerOr(std::string_view key, Range allowed, int otherwise);
  std::optional<int> OptionalInteger(std::string_view key, Range allowed);
  bool BooleanOr(std::string_view key, bool otherwise);
  /// `[min, max]`, both in `allowed` and in order.
  std::optional<Range> OptionalRange(std::string_view key, Range allowed);
  std::string String(std::string_view key);
  std::string StringOr(std::string_view key, std::string otherwise);
  /// One of the words in `allowed`.
  std::string OneOf(std::string_view key, const std::vector<std::string>& allowed);
  std::string OneOfOr(std::string_view key, const std::vector<std::string>& allowed, std::string otherwise);
  /// A table below this one; it must stand.
  ConfigTable Table(std::string_view key);
  /// The same, if it stands.
  std::optional<ConfigTable> OptionalTable(std::string_view key);
  /// The array of tables `key`, such as [[axis]]; at least one.
  std::vector<ConfigTable> Tables(std::string_view key);
  void Finish() const;

  /// Throws ConfigError for `key` at its line (the table's where it does not stand).
  [[noreturn]] void Refuse(std::string_view key, const std::string& problem) const;

 private:
  const toml::node* Find(std::string_view key);
  const toml::node& Require(std::string_view key, const std::string& expected);
  double CheckedNumber(std::string_view key, const toml::node& node, Range allowed) const;
  int CheckedInteger(std::string_view key, const toml::node& node, Range allowed) const;
  std::string FullName(std::string_view key) const;

  const toml::table* table_;
  std::filesystem::path file_;
  std::string path_;
  std::set<std::string, std::less<>> known_;
};

}  // namespace mwidth::server
