// What the recordings of a BIDS dataset share: its description, its participants and their scans.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace mwidth::record {

/// A table of text with a head, as BIDS has it. Columns and rows that it does not know are kept as they are.
class BidsTable {
 public:
  /// Without rows.
  explicit BidsTable(std::vector<std::string> columns) : columns_(std::move(columns)) {}
  /// Reads `file`, or begins anew with `columns` where there is none. Columns that it lacks are added, "n/a"
  /// in every row. Throws ExportRefused where it has no column columns[0], or rows of another length.
  static BidsTable Read(const std::filesystem::path& file, const std::vector<std::string>& columns);

  /// Fills the row whose columns[0] is that of `cells`, or adds one; other columns stay, of a new row "n/a".
  void Set(const std::map<std::string, std::string>& cells);
  std::string Text() const;

 private:
  std::vector<std::string> columns_;
  std::vector<std::vector<std::string>> rows_;
  /// columns[0] of Read.
  std::string key_;
};

/// dataset_description.json with this program in GeneratedBy; of an existing `file` everything else is kept.
/// Throws ExportRefused where it is no JSON object.
std::string DatasetDescription(const std::filesystem::path& file, const std::string& name);

/// For people who find the dataset.
std::string DatasetReadme();

/// Held while the shared files of `dataset`, a folder, are read and replaced: other exports into it wait.
class DatasetLock {
 public:
  explicit DatasetLock(const std::filesystem::path& dataset);
  DatasetLock(const DatasetLock&) = delete;
  DatasetLock& operator=(const DatasetLock&) = delete;
  ~DatasetLock();

 private:
  int descriptor_;
};

}  // namespace mwidth::record
