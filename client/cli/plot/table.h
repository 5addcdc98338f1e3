// A table of words and numbers, for the terminal, a file or a picture.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>
#include <vector>

namespace mwidth::plot {

/// Every row has as many cells as there are columns.
struct Table {
  std::string title;
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows = {};
};

/// In aligned columns, UTF-8 counted by characters.
std::string ToText(const Table& table);
/// Column names, then the rows. Throws std::runtime_error where the file cannot be written.
void WriteCsv(const Table& table, const std::filesystem::path& file);
/// As a picture, under the same conditions as a chart (chart.h).
void Draw(const Table& table, const std::filesystem::path& file);

}  // namespace mwidth::plot
