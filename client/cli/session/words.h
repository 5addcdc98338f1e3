// A session in words and tables, for a person.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "server/record/event.h"
#include "server/record/session/session_info.h"
#include "server/record/session/session_reader.h"

namespace mwidth::cli::session {

/// "2026-11-22 06:30:00 UTC"; "-" where there is none.
std::string Moment(const std::optional<int64_t>& wall_ns);
/// "1:02:03" or "12.345 s", of the ticks from the first sample to the last; "-" without samples.
std::string Duration(const record::SessionInfo& info);
/// "12 missed, 3 lost", or "none".
std::string GapText(const std::vector<record::Gap>& gaps);

/// Everything but the samples, one quantity a line, then tables.
std::string Report(const record::SessionReader& reader);

}  // namespace mwidth::cli::session
