// Values of the API's enums as words.
#pragma once

#include <string>
#include <string_view>

namespace mwidth::cli {

/// "STATE_READY" without its prefix, in lower case, `separator` between its words.
std::string EnumWords(std::string_view name, std::string_view prefix, char separator);

}  // namespace mwidth::cli
