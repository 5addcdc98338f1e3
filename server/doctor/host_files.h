// The kernel's own account of a host, in /proc, /sys and /dev.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace mwidth::doctor {

/// Reads below a root folder, so that a test, or a copy of another host's files, can stand in for this host.
class HostFiles {
 public:
  explicit HostFiles(std::filesystem::path root) : root_(std::move(root)) {}

  /// A whole file, such as "proc/version", without the white space around it; none where it cannot be read.
  std::optional<std::string> Text(const std::string& file) const;
  /// A file that holds one whole number.
  std::optional<int64_t> Number(const std::string& file) const;
  /// Names of the folders in a folder, sorted, numbers by their value; empty where there is none.
  std::vector<std::string> Folders(const std::string& folder) const;
  /// Whether this user may write the file.
  bool MayWrite(const std::string& file) const;

 private:
  std::filesystem::path root_;
};

/// The kernel's lists of CPUs: "0-2,5" is 0, 1, 2, 5. What is no such list is no CPU.
std::vector<int> ParseCpuList(const std::string& list);

/// "1, 3": for a person.
std::string Listed(const std::vector<int>& numbers);
std::string Listed(const std::vector<std::string>& words);

}  // namespace mwidth::doctor
