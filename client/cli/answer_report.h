// What the server answers when a mass or a filter is asked for, in words for a person.
#pragma once

#include <mwidth/v1/rendering.pb.h>
#include <mwidth/v1/stability.pb.h>

#include <string>

#include "client/cpp/failure.h"

namespace mwidth::cli {

/// What was admitted and by which margins.
std::string AdmissionReport(const v1::SetMassResponse& response, const v1::AxisInfo& axis,
                            bool validate_only);
/// What was asked for, what would be admitted, the nearest such mass, the cut-off that would admit the
/// request, what sets the edge, and the margins that are left.
std::string RefusalReport(const client::Refusal& refusal, const v1::AxisInfo& axis);

/// The filter that runs now instead of that of `axis`, and what it admits.
std::string FilterReport(const v1::SetFilterResponse& response, const v1::AxisInfo& axis, bool validate_only);
/// The filter that was asked for, and why the mass that is set is not admitted with it.
std::string FilterRefusalReport(const client::Refusal& refusal, const v1::AxisInfo& axis);

}  // namespace mwidth::cli
