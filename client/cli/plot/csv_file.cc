#include "client/cli/plot/csv_file.h"

#include <stdexcept>
#include <utility>

namespace mwidth::plot {
namespace {

std::string Quoted(const std::string& cell) {
  if (cell.find_first_of(",\"\r\n") == std::string::npos) {
    return cell;
  }
  std::string quoted = "\"";
  for (const char c : cell) {
    quoted += c == '"' ? "\"\"" : std::string(1, c);
  }
  return quoted + "\"";
}

}  // namespace

CsvFile::CsvFile(std::filesystem::path file) : file_(std::move(file)), out_(file_, std::ios::binary) {
  if (!out_) {
    throw std::runtime_error("cannot write " + file_.string());
  }
}

void CsvFile::Row(const std::vector<std::string>& cells) {
  const char* separator = "";
  for (const auto& cell : cells) {
    out_ << separator << Quoted(cell);
    separator = ",";
  }
  out_ << "\n";
}

void CsvFile::Close() {
  out_.close();
  if (!out_) {
    throw std::runtime_error("cannot write " + file_.string());
  }
}

}  // namespace mwidth::plot
