// Ranges of parameters, as they are typed.
#pragma once

#include <mwidth/v1/stability.pb.h>

#include <string>

namespace mwidth::cli {

/// "cutoff-hz=1:100", "cutoff-hz=1:100:50", "cutoff-hz=1:100:50:log": parameter, first and last value, number
/// of values (default 21), equal ratios instead of equal steps. Throws CLI::ValidationError that says what is
/// wrong.
v1::SweepRange ParseSweepRange(const std::string& text);

/// "100:2000": least and greatest value. Throws CLI::ValidationError of `option` that says what is wrong.
v1::ParameterRange ParseParameterRange(const std::string& option, const std::string& text);

/// "cutoff_hz": the parameter's field in LoopParameters.
std::string ParameterName(v1::SweepParameter parameter);

}  // namespace mwidth::cli
