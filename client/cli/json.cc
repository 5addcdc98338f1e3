#include "client/cli/json.h"

#include <google/protobuf/util/json_util.h>

#include <stdexcept>

namespace mwidth::cli {

std::string ToJson(const google::protobuf::Message& message, bool one_line) {
  google::protobuf::util::JsonPrintOptions options;
  options.preserve_proto_field_names = true;
  options.always_print_primitive_fields = true;
  options.add_whitespace = !one_line;
  std::string text;
  // Only a detail of an unknown type can fail: a newer server's, say.
  if (const auto status = google::protobuf::util::MessageToJsonString(message, &text, options);
      !status.ok()) {
    throw std::runtime_error("cannot write this answer as JSON: " + std::string(status.message()));
  }
  if (!text.ends_with('\n')) {
    text += '\n';
  }
  return text;
}

}  // namespace mwidth::cli
