// State and M-width of an axis, in words and tables for a person.
#pragma once

#include <mwidth/v1/rendering.pb.h>
#include <mwidth/v1/stability.pb.h>

#include <string>

#include "client/cli/loop_words.h"

namespace mwidth::cli {

/// "rendering", "fault" and so on.
std::string StateName(v1::State state);
/// "linear" or "rotary".
std::string KindName(v1::AxisKind kind);

/// Every axis with its state, one quantity a line.
std::string StateReport(const v1::GetStateResponse& response);
/// Nominal, robust and admitted masses, absolute and as a multiple of the device's, the loop they belong to,
/// what is assumed around it, and what sets the robust edges.
std::string MWidthReport(const v1::GetMWidthResponse& response, const v1::AxisInfo& axis,
                         const Assumptions& assumptions);

}  // namespace mwidth::cli
