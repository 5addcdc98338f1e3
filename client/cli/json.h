// Answers of the server as JSON, for programs.
#pragma once

#include <google/protobuf/message.h>

#include <string>

namespace mwidth::cli {

/// protobuf's JSON mapping with the field names of the proto files, every plain field present; `one_line` for
/// streams. 64-bit integers are strings there, and so are "Infinity" and "NaN". Ends with a newline.
std::string ToJson(const google::protobuf::Message& message, bool one_line = false);

}  // namespace mwidth::cli
