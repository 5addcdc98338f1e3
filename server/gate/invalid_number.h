// The refusal of a number.
#pragma once

#include <string>

#include "server/gate/refusal.h"
#include "server/model/loop_parameters.h"

namespace mwidth::gate {

/// INVALID_ARGUMENT (INVALID_NUMBER) with field, value and what is allowed, in words and as metadata.
/// `allowed` completes "it must be ...".
Refusal InvalidNumber(const std::string& field, double value, const std::string& allowed);

/// The same of what the model does not allow; `prefix` goes before the parameter's name, such as "x.".
Refusal InvalidNumber(const model::ParameterError& error, const std::string& prefix = "");

}  // namespace mwidth::gate
