#include "server/config_table.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

namespace mwidth::server {
namespace {

std::string Describe(const Range& range) {
  std::ostringstream text;
  if (range.above_min) {
    text << "a number above " << range.min << " and at most " << range.max;
  } else {
    text << "a number from " << range.min << " to " << range.max;
  }
  return text.str();
}

std::string Shown(const toml::node& node) {
  std::ostringstream text;
  node.visit([&text](const auto& value) { text << value; });
  return text.str();
}

}  // namespace

ConfigTable::ConfigTable(const toml::table& table, std::filesystem::path file, std::string path)
    : table_(&table), file_(std::move(file)), path_(std::move(path)) {}

double ConfigTable::Number(std::string_view key, Range allowed) {
  return CheckedNumber(key, Require(key, Describe(allowed)), allowed);
}

double ConfigTable::NumberOr(std::string_view key, Range allowed, double otherwise) {
  return OptionalNumber(key, allowed).value_or(otherwise);
}

std::optional<double> ConfigTable::OptionalNumber(std::string_view key, Range allowed) {
  const toml::node* node = Find(key);
  return node == nullptr ? std::nullopt : std::optional(CheckedNumber(key, *node, allowed));
}

int ConfigTable::Integer(std::string_view key, Range allowed) {
  return CheckedInteger(key, Require(key, "a whole number, " + Describe(allowed)), allowed);
}

int ConfigTable::IntegerOr(std::string_view key, Range allowed, int otherwise) {
  return OptionalInteger(key, allowed).value_or(otherwise);
}

std::optional<int> ConfigTable::OptionalInteger(std::string_view key, Range allowed) {
  const toml::node* node = Find(key);
  return node == nullptr ? std::nullopt : std::optional(CheckedInteger(key, *node, allowed));
}

bool ConfigTable::BooleanOr(std::string_view key, bool otherwise) {
  const toml::node* node = Find(key);
  if (node == nullptr) {
    return otherwise;
  }
  if (!node->is_boolean()) {
    Refuse(key, "is " + Shown(*node) + "; allowed is true or false");
  }
  return **node->as_boolean();
}

std::optional<Range> ConfigTable::OptionalRange(std::string_view key, Range allowed) {
  const toml::node* node = Find(key);
  if (node == nullptr) {
    return std::nullopt;
  }
  const toml::array* ends = node->as_array();
  if (ends == nullptr || ends->size() != 2) {
    Refuse(key, "is " + Shown(*node) + "; allowed is [min, max]");
  }
  const Range range{CheckedNumber(key, *ends->get(0), allowed), CheckedNumber(key, *ends->get(1), allowed)};
  if (range.min > range.max) {
    Refuse(key, "is " + Shown(*node) + "; its first number must not be above its second");
  }
  return range;
}

std::string ConfigTable::String(std::string_view key) {
  const toml::node& node = Require(key, "a text in quotes");
  if (!node.is_string()) {
    Refuse(key, "is " + Shown(node) + "; allowed is a text in quotes");
  }
  return **node.as_string();
}

std::string ConfigTable::StringOr(std::string_view key, std::string otherwise) {
  return Find(key) == nullptr ? std::move(otherwise) : String(key);
}

std::string ConfigTable::OneOf(std::string_view key, const std::vector<std::string>& allowed) {
  std::string word = String(key);
  if (std::find(allowed.begin(), allowed.end(), word) == allowed.end()) {
    std::string names;
    for (const std::string& name : allowed) {
      names += (names.empty() ? "\"" : ", \"") + name + "\"";
    }
    Refuse(key, "is \"" + word + "\"; allowed are " + names);
  }
  return word;
}

std::string ConfigTable::OneOfOr(std::string_view key, const std::vector<std::string>& allowed,
                                 std::string otherwise) {
  return Find(key) == nullptr ? std::move(otherwise) : OneOf(key, allowed);
}

ConfigTable ConfigTable::Table(std::string_view key) {
  const toml::node& node = Require(key, "a table [" + FullName(key) + "]");
  if (!node.is_table()) {
    Refuse(key, "must be a table [" + FullName(key) + "]");
  }
  return {*node.as_table(), file_, FullName(key)};
}

std::optional<ConfigTable> ConfigTable::OptionalTable(std::string_view key) {
  return Find(key) == nullptr ? std::nullopt : std::optional(Table(key));
}

std::vector<ConfigTable> ConfigTable::Tables(std::string_view key) {
  const toml::node& node = Require(key, "at least one table [[" + FullName(key) + "]]");
  const toml::array* array = node.as_array();
  if (array == nullptr || array->empty() || !array->is_homogeneous(toml::node_type::table)) {
    Refuse(key, "must be one or more tables [[" + FullName(key) + "]]");
  }
  std::vector<ConfigTable> tables;
  for (const toml::node& item : *array) {
    tables.emplace_back(*item.as_table(), file_, FullName(key));
  }
  return tables;
}

void ConfigTable::Finish() const {
  for (const auto& [key, node] : *table_) {
    if (known_.contains(key.str())) {
      continue;
    }
    std::string allowed;
    for (const std::string& name : known_) {
      allowed += (allowed.empty() ? "" : ", ") + name;
    }
    Refuse(key.str(), "is not a key of " + (path_.empty() ? "this file" : "[" + path_ + "]") +
                          "; allowed are " + allowed);
  }
}

void ConfigTable::Refuse(std::string_view key, const std::string& problem) const {
  const toml::node* node = table_->get(key);
  const toml::source_position where = node == nullptr ? table_->source().begin : node->source().begin;
  std::ostringstream text;
  text << file_.string() << ":" << where.line << ": " << FullName(key) << " " << problem;
  throw ConfigError(text.str());
}

const toml::node* ConfigTable::Find(std::string_view key) {
  known_.emplace(key);
  return table_->get(key);
}

const toml::node& ConfigTable::Require(std::string_view key, const std::string& expected) {
  const toml::node* node = Find(key);
  if (node == nullptr) {
    Refuse(key, "is missing; give " + expected);
  }
  return *node;
}

double ConfigTable::CheckedNumber(std::string_view key, const toml::node& node, Range allowed) const {
  const std::optional<double> value = node.value<double>();
  const bool inside = value && std::isfinite(*value) && *value <= allowed.max &&
                      (allowed.above_min ? *value > allowed.min : *value >= allowed.min);
  if (!node.is_number() || !inside) {
    Refuse(key, "is " + Shown(node) + "; allowed is " + Describe(allowed));
  }
  return *value;
}

int ConfigTable::CheckedInteger(std::string_view key, const toml::node& node, Range allowed) const {
  if (!node.is_integer()) {
    Refuse(key, "is " + Shown(node) + "; allowed is a whole number, " + Describe(allowed));
  }
  return static_cast<int>(CheckedNumber(key, node, allowed));
}

std::string ConfigTable::FullName(std::string_view key) const {
  return path_.empty() ? std::string(key) : path_ + "." + std::string(key);
}

}  // namespace mwidth::server
