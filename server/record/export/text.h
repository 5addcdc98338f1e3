// Numbers, times and cells as text, the same on every machine.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "server/record/export/columns.h"

namespace mwidth::record {

/// The shortest text that reads back to the same double; "inf", "-inf" and "nan" as C and Python read them.
void AppendNumber(std::string& out, double value);
std::string Number(double value);

/// Booleans as 0 and 1, Coded as its word.
void AppendValue(std::string& out, const Value& value);

/// "2026-11-22T06:30:00.123456Z" of nanoseconds since 1970; microseconds, rounded down.
std::string UtcTime(int64_t wall_ns);

/// RFC 4180: quoted where it has a comma, a quote or a line break.
std::string CsvCell(std::string_view text);

/// A cell of a BIDS table: "n/a" where it is empty, control characters (tabs and line breaks among them)
/// become spaces; quoted where it begins with a quote, which readers would take for theirs.
std::string TsvCell(std::string_view text);

}  // namespace mwidth::record
