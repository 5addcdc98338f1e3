// Answers of the server, in words and tables for a person.
#pragma once

#include <mwidth/v1/rendering.pb.h>
#include <mwidth/v1/stability.pb.h>

#include <string>

#include "client/cli/units.h"

namespace mwidth::cli {

/// "rendering", "fault" and so on.
std::string StateName(v1::State state);
/// "linear" or "rotary".
std::string KindName(v1::AxisKind kind);
/// "from -0.05 to 0.35 kg", edges rounded inward, or why there is none.
std::string IntervalText(const v1::Interval& interval, const Units& units);

/// Every axis with its state, one quantity a line.
std::string StateReport(const v1::GetStateResponse& response);
/// Nominal, robust and admitted masses, absolute and as a multiple of the device's, and the loop they belong
/// to.
std::string MWidthReport(const v1::GetMWidthResponse& response, const v1::AxisInfo& axis);
/// What was admitted and by which margin.
std::string AdmissionReport(const v1::SetMassResponse& response, const v1::AxisInfo& axis,
                            bool validate_only);
/// What was asked for, what would be admitted, the nearest such mass, the cut-off that would admit the
/// request, and what sets the edge.
std::string RefusalReport(const v1::StabilityReport& report, const v1::AxisInfo& axis);

}  // namespace mwidth::cli
