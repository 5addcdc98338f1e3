// A session as JSON: for session.json beside exported samples, and for programs that ask the command line.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "server/record/event.h"
#include "server/record/session/session_info.h"
#include "server/record/session/session_reader.h"

namespace mwidth::record {

/// "open", "ended" or "recovered".
std::string_view StateWord(SessionState state);
/// "state_changed", "mass_refused" and so on, as in the API; "unknown" for a kind of a newer server.
std::string_view KindWord(EventKind kind);

/// Who, what, when and how many; times as text (UTC) and in nanoseconds. null: there is none (no end yet, no
/// limit).
nlohmann::ordered_json SummaryJson(const SessionInfo& info);
/// The summary, the axis's quanta and limits, and what was in force: configuration, command line, axis.
nlohmann::ordered_json SessionJson(const SessionInfo& info);

nlohmann::ordered_json ToJson(const std::vector<Event>& events);
nlohmann::ordered_json ToJson(const std::vector<Marker>& markers);
nlohmann::ordered_json ToJson(const std::vector<Gap>& gaps);
nlohmann::ordered_json ToJson(const std::vector<WallClockStep>& steps);
nlohmann::ordered_json ToJson(const std::vector<DamagedBlock>& damaged);

/// Indented, with a line break at its end; bytes that are no UTF-8 are replaced.
std::string Indented(const nlohmann::ordered_json& json);

}  // namespace mwidth::record
