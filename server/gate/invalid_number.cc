#include "server/gate/invalid_number.h"

#include "server/gate/figures.h"

namespace mwidth::gate {

Refusal InvalidNumber(const std::string& field, double value, const std::string& allowed) {
  const model::ParameterError error{field, value, allowed};
  return {.code = RefusalCode::kInvalidArgument,
          .reason = kInvalidNumber,
          .message = error.Message() + ".",
          .metadata = {{"field", field}, {"value", Figure(value)}, {"allowed", allowed}}};
}

Refusal InvalidNumber(const model::ParameterError& error, const std::string& prefix) {
  return InvalidNumber(prefix + error.parameter, error.value, error.allowed);
}

}  // namespace mwidth::gate
