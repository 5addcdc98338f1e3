#include "client/cli/enum_words.h"

#include <algorithm>

namespace mwidth::cli {

std::string EnumWords(std::string_view name, std::string_view prefix, char separator) {
  std::string words(name.substr(name.starts_with(prefix) ? prefix.size() : 0));
  std::transform(words.begin(), words.end(), words.begin(), [separator](char c) {
    const bool upper = c >= 'A' && c <= 'Z';
    return c == '_' ? separator : upper ? static_cast<char>(c - 'A' + 'a') : c;
  });
  return words;
}

}  // namespace mwidth::cli
