#include "server/record/export/bids_dataset.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <system_error>

#include "server/record/export/file_set.h"
#include "server/record/export/session_json.h"

namespace mwidth::record {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// The first version of BIDS that knows motion.
constexpr const char* kBidsVersion = "1.9.0";

std::string ReadText(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  if (!in) {
    throw std::system_error(errno, std::generic_category(), "cannot read " + file.string());
  }
  return text.str();
}

std::vector<std::string> Cells(const std::string& line) {
  std::vector<std::string> cells{""};
  for (const char c : line) {
    if (c == '\t') {
      cells.emplace_back();
    } else {
      cells.back() += c;
    }
  }
  return cells;
}

std::vector<std::vector<std::string>> Lines(std::string text) {
  if (text.starts_with("\xEF\xBB\xBF")) {
    text.erase(0, 3);
  }
  std::vector<std::vector<std::string>> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    if (line.ends_with('\r')) {
      line.pop_back();
    }
    if (!line.empty()) {
      lines.push_back(Cells(line));
    }
  }
  return lines;
}

std::string Joined(const std::vector<std::string>& cells) {
  std::string text;
  for (const std::string& cell : cells) {
    text += cell + '\t';
  }
  text.back() = '\n';
  return text;
}

}  // namespace

BidsTable BidsTable::Read(const fs::path& file, const std::vector<std::string>& columns) {
  BidsTable table(columns);
  table.key_ = columns.front();
  if (!fs::exists(file)) {
    return table;
  }
  auto lines = Lines(ReadText(file));
  if (lines.empty() || std::find(lines[0].begin(), lines[0].end(), table.key_) == lines[0].end()) {
    throw ExportRefused(file.string() + " has no column " + table.key_ +
                        ": it is no table that a session can be added to");
  }
  table.columns_ = lines[0];
  for (size_t i = 1; i < lines.size(); ++i) {
    if (lines[i].size() != table.columns_.size()) {
      throw ExportRefused(file.string() + ", line " + std::to_string(i + 1) + ": " +
                          std::to_string(lines[i].size()) + " cells where the head has " +
                          std::to_string(table.columns_.size()));
    }
    table.rows_.push_back(std::move(lines[i]));
  }
  for (const std::string& column : columns) {
    if (std::find(table.columns_.begin(), table.columns_.end(), column) == table.columns_.end()) {
      table.columns_.push_back(column);
      std::for_each(table.rows_.begin(), table.rows_.end(), [](auto& row) { row.emplace_back("n/a"); });
    }
  }
  return table;
}

void BidsTable::Set(const std::map<std::string, std::string>& cells) {
  const auto index = [this](const std::string& column) {
    return static_cast<size_t>(std::find(columns_.begin(), columns_.end(), column) - columns_.begin());
  };
  const size_t key = index(key_);
  auto row =
      std::find_if(rows_.begin(), rows_.end(), [&](const auto& r) { return r[key] == cells.at(key_); });
  if (row == rows_.end()) {
    row = rows_.insert(rows_.end(), std::vector<std::string>(columns_.size(), "n/a"));
  }
  for (const auto& [column, cell] : cells) {
    row->at(index(column)) = cell;
  }
}

std::string BidsTable::Text() const {
  std::string text = Joined(columns_);
  for (const auto& row : rows_) {
    text += Joined(row);
  }
  return text;
}

std::string DatasetDescription(const fs::path& file, const std::string& name) {
  Json json = Json::object();
  if (fs::exists(file)) {
    json = Json::parse(ReadText(file), nullptr, /*allow_exceptions=*/false);
    if (!json.is_object()) {
      throw ExportRefused(file.string() + " is no JSON object: mend it, or export into another folder");
    }
  } else {
    json = {{"Name", name}, {"BIDSVersion", kBidsVersion}, {"DatasetType", "raw"}};
  }
  Json& programs = json["GeneratedBy"];
  const Json self{{"Name", "mwidth"}, {"Version", MWIDTH_VERSION}, {"Description", "mwidth session export"}};
  if (!programs.is_array()) {
    programs = Json::array();
  }
  const bool known = std::any_of(programs.begin(), programs.end(), [&self](const Json& program) {
    return program.is_object() && program.contains("Name") && program["Name"] == self["Name"] &&
           program.contains("Version") && program["Version"] == self["Version"];
  });
  if (!known) {
    programs.push_back(self);
  }
  return Indented(json);
}

std::string DatasetReadme() {
  return R"(Reaches with a robot joint that renders a virtual mass, recorded by mwidth and exported as Motion-BIDS.

Each row of motion.tsv is one tick of the control loop, evenly spaced; a tick without a sample is a row of n/a, and
events.tsv has it in a row of trial_type "gap". channels.tsv says what the columns are. Torque and force act on the
device against the positive direction: they are positive against positive acceleration at a positive mass. Onsets in
events.tsv count from the first sample, whose time is acq_time in scans.tsv (UTC).

sourcedata/mwidth has what BIDS has no place for: the configuration of the server, what its loop was certified for, the
clock's steps, and blocks of the recording that were damaged.

Add here what the study was about, and its authors and license to dataset_description.json.
)";
}

DatasetLock::DatasetLock(const fs::path& dataset)
    : descriptor_(::open(dataset.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  if (descriptor_ < 0) {
    throw std::system_error(errno, std::generic_category(), "cannot open " + dataset.string());
  }
  // Where the file system knows no locks, two exports at the same time are the user's to avoid.
  while (::flock(descriptor_, LOCK_EX) != 0 && errno == EINTR) {
  }
}

DatasetLock::~DatasetLock() { ::close(descriptor_); }

}  // namespace mwidth::record
