// What an analysis answers, as tables: for a person or, with all digits, for a file.
#pragma once

#include <mwidth/v1/stability.pb.h>

#include <string>
#include <vector>

#include "client/cli/plot/table.h"
#include "client/cli/units.h"

namespace mwidth::cli {

/// How a number becomes a cell: ForPeople or Exact (numbers.h).
using Format = std::string (*)(double);
/// Six significant digits.
std::string ForPeople(double value);

/// A row for each edge of each interval, with the loop that sets it; "none" where the interval is empty.
plot::Table MWidthTable(const v1::GetMWidthResponse& response, const Units& units, Format format);
/// A row for each margin.
plot::Table MarginsTable(const v1::StabilityMargins& margins, Format format);
/// A row for each point of the grid, x fastest; "none" for the edges of an empty interval or a loop out of
/// range.
plot::Table SweepTable(const v1::SweepMWidthRequest& request,
                       const std::vector<v1::SweepMWidthResponse>& rows, const Units& units, Format format);
/// A row for each frequency.
plot::Table BodeTable(const v1::GetFrequencyResponseResponse& response, Format format);
/// A row for each figure that there is.
plot::Table AccuracyTable(const v1::Accuracy& accuracy, const Units& units, Format format);

}  // namespace mwidth::cli
