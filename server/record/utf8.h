// Text from files and clients, which may be any bytes.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace mwidth::record {

/// U+FFFD.
inline constexpr const char* kReplacementCharacter = "\xEF\xBF\xBD";

/// Bytes of the well-formed UTF-8 character that begins `text`, which is not empty; 0 where none does
/// (Unicode, table 3-7).
std::size_t Utf8CharacterLength(std::string_view text);

/// `text` with a replacement character for each byte that is no UTF-8: what a message of the API may carry.
std::string WellFormedUtf8(std::string_view text);

}  // namespace mwidth::record
