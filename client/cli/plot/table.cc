#include "client/cli/plot/table.h"

#include <algorithm>
#include <sstream>

#include "client/cli/numbers.h"
#include "client/cli/plot/csv_file.h"
#include "client/cli/plot/gnuplot.h"

namespace mwidth::plot {
namespace {

// Characters of UTF-8 text: every byte but those that continue one.
size_t Length(const std::string& text) {
  constexpr unsigned kMark = 0xC0;
  constexpr unsigned kContinues = 0x80;
  return static_cast<size_t>(std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & kMark) != kContinues;
  }));
}

// What each column needs.
std::vector<size_t> Widths(const Table& table) {
  std::vector<size_t> widths;
  for (size_t i = 0; i < table.columns.size(); ++i) {
    widths.push_back(Length(table.columns[i]));
    for (const auto& row : table.rows) {
      widths[i] = std::max(widths[i], Length(row.at(i)));
    }
  }
  return widths;
}

void AppendRow(const std::vector<std::string>& row, const std::vector<size_t>& widths, std::string& text) {
  for (size_t i = 0; i < row.size(); ++i) {
    text += row[i];
    text += i + 1 < row.size() ? std::string(widths[i] + 2 - Length(row[i]), ' ') : "\n";
  }
}

}  // namespace

std::string ToText(const Table& table) {
  const auto widths = Widths(table);
  std::string text;
  AppendRow(table.columns, widths, text);
  for (const auto& row : table.rows) {
    AppendRow(row, widths, text);
  }
  return text;
}

void WriteCsv(const Table& table, const std::filesystem::path& file) {
  CsvFile csv(file);
  csv.Row(table.columns);
  for (const auto& row : table.rows) {
    csv.Row(row);
  }
  csv.Close();
}

void Draw(const Table& table, const std::filesystem::path& file) {
  constexpr int kCharacterWidth = 8;
  constexpr int kLineHeight = 24;
  const auto widths = Widths(table);
  int height = kLineHeight;
  std::ostringstream script;
  // Labels by pixel, from the top: a plot of nothing that carries text.
  const auto label = [&script](const std::string& text, int x, int y) {
    script << "set label " << GnuplotString(text) << " at screen " << x << "./width, screen 1 - " << y
           << "./height\n";
  };
  const auto line = [&](const std::vector<std::string>& row) {
    height += kLineHeight;
    int x = kLineHeight;
    for (size_t i = 0; i < row.size(); ++i) {
      label(row[i], x, height);
      x += kCharacterWidth * static_cast<int>(widths[i] + 2);
    }
    return x;
  };
  label(table.title, kLineHeight, height);
  const int width =
      std::max(line(table.columns), kCharacterWidth * static_cast<int>(Length(table.title) + 6));
  for (const auto& row : table.rows) {
    line(row);
  }
  height += kLineHeight;
  const auto size = "width = " + std::to_string(width) + "\nheight = " + std::to_string(height) + "\n";
  RunGnuplot(size + script.str() + "unset border\nunset tics\nunset key\nplot [0:1][0:1] 2\n", file, width,
             height);
}

}  // namespace mwidth::plot
