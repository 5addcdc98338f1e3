// Text of other people's making on a terminal.
#pragma once

#include <algorithm>
#include <string>

namespace mwidth::cli {

/// Line breaks would break tables, and escape sequences command terminals: each becomes a space.
inline std::string OneLine(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < ' ' || c == 0x7F; }, ' ');
  return text;
}

}  // namespace mwidth::cli
