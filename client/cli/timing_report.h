// How punctual the loop of an axis is, as a table.
#pragma once

#include <mwidth/v1/rendering.pb.h>

#include <string>

namespace mwidth::cli {

/// What the ticks of an axis took, in microseconds: one kind of duration a line.
std::string TimingReport(const v1::AxisState& axis);

}  // namespace mwidth::cli
