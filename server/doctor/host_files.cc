#include "server/doctor/host_files.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <sstream>
#include <system_error>

namespace mwidth::doctor {
namespace {

// More CPUs than any kernel names; a list beyond that is no list of CPUs.
constexpr int kMostCpus = 8192;
constexpr const char* kWhiteSpace = " \t\n";

std::string Trimmed(const std::string& text) {
  const std::size_t begin = text.find_first_not_of(kWhiteSpace);
  return begin == std::string::npos ? "" : text.substr(begin, text.find_last_not_of(kWhiteSpace) - begin + 1);
}

// All of the text as one number.
template <typename Integer>
std::optional<Integer> NumberIn(const std::string& text) {
  Integer number = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number);
  return error == std::errc() && stop == end ? std::optional(number) : std::nullopt;
}

}  // namespace

std::optional<std::string> HostFiles::Text(const std::string& file) const {
  std::error_code error;
  std::ifstream in(root_ / file);
  if (!in || std::filesystem::is_directory(root_ / file, error)) {
    return std::nullopt;
  }
  // Not all that can be opened there can be read; what cannot is left out.
  std::ostringstream text;
  text << in.rdbuf();
  return Trimmed(text.str());
}

std::optional<int64_t> HostFiles::Number(const std::string& file) const {
  const std::optional<std::string> text = Text(file);
  return text ? NumberIn<int64_t>(*text) : std::nullopt;
}

std::vector<std::string> HostFiles::Folders(const std::string& folder) const {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(root_ / folder, error)) {
    if (entry.is_directory(error)) {
      names.push_back(entry.path().filename());
    }
  }
  std::sort(names.begin(), names.end(), [](const std::string& a, const std::string& b) {
    const auto number_a = NumberIn<int>(a);
    const auto number_b = NumberIn<int>(b);
    return number_a && number_b ? *number_a < *number_b : a < b;
  });
  return names;
}

bool HostFiles::MayWrite(const std::string& file) const {
  return faccessat(AT_FDCWD, (root_ / file).c_str(), W_OK, AT_EACCESS) == 0;
}

std::vector<int> ParseCpuList(const std::string& list) {
  std::vector<int> cpus;
  std::istringstream ranges(list);
  for (std::string range; std::getline(ranges, range, ',');) {
    const std::size_t dash = range.find('-');
    const std::optional<int> first = NumberIn<int>(range.substr(0, dash));
    const std::optional<int> last = dash == std::string::npos ? first : NumberIn<int>(range.substr(dash + 1));
    if (!first || !last || *last >= kMostCpus) {
      return {};
    }
    for (int cpu = *first; cpu <= *last; ++cpu) {
      cpus.push_back(cpu);
    }
  }
  return cpus;
}

std::string Listed(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) {
    text += (text.empty() ? "" : ", ") + word;
  }
  return text;
}

std::string Listed(const std::vector<int>& numbers) {
  std::vector<std::string> words;
  words.reserve(numbers.size());
  for (const int number : numbers) {
    words.push_back(std::to_string(number));
  }
  return Listed(words);
}

}  // namespace mwidth::doctor
