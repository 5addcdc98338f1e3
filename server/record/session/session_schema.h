// The tables of a session's file; README.md describes them for those who read them without this code.
#pragma once

#include <map>
#include <string>

#include <SQLiteCpp/Database.h>

#include "server/record/session/session_info.h"

namespace mwidth::record {

/// "MWSF" in the header of the database, and the version of the tables (user_version).
inline constexpr int kSessionApplicationId = 0x4D575346;
inline constexpr int kSessionFormat = 1;

/// Creates the tables. Throws SQLite::Exception, as all here.
void CreateTables(SQLite::Database& database);

/// Replaces what `info` says, but the counts of samples, which the blocks have.
void WriteInfo(const SessionInfo& info, SQLite::Database& database);

/// What the file says of itself, but its id and the counts of samples. Also throws std::runtime_error where
/// something is missing or has another type.
SessionInfo ReadInfo(SQLite::Database& database);

/// Fills in the counts of samples, as blocks and tail, which never hold the same sample, tell them.
void CountSamples(SQLite::Database& database, SessionInfo& info);

/// A JSON object of strings, and back. Text that is no UTF-8 is mended; an object that is none is empty.
std::string MetadataText(const std::map<std::string, std::string>& metadata);
std::map<std::string, std::string> MetadataOf(const std::string& text);

}  // namespace mwidth::record
