// A file of comma-separated values.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace mwidth::plot {

/// Writes RFC 4180 rows, with line feeds. One thread.
class CsvFile {
 public:
  /// Replaces `file`. Throws std::runtime_error naming it where it cannot be written; so does Close.
  explicit CsvFile(std::filesystem::path file);

  /// Cells with a comma, a quote or a line break are quoted.
  void Row(const std::vector<std::string>& cells);
  /// To be called once all is written: what a full disk lost is known only then.
  void Close();

 private:
  std::filesystem::path file_;
  std::ofstream out_;
};

}  // namespace mwidth::plot
