// What a stored session says of itself, as the API tells it.
#pragma once

#include <optional>

#include "mwidth/v1/session.pb.h"
#include "server/record/session/session_info.h"
#include "server/record/session/session_store.h"

namespace mwidth::rpc {

/// With the file's size and the ticks that are absent; `active` is the session as it stands, where this
/// server records it now. SESSION_STATE_UNREADABLE, and why, where the file cannot be read.
v1::Session Describe(const record::StoredSession& stored, const std::optional<record::SessionInfo>& active);

/// Adds markers, events, configuration and the axis's state to an answer, as much as a client's message may
/// have. Precondition: stored.info. Throws record::SessionFileError.
void AddContents(const record::StoredSession& stored, v1::GetSessionResponse& response);

}  // namespace mwidth::rpc
