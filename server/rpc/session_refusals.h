// Why a session is not begun, marked, ended or read.
#pragma once

#include <string>

#include <grpcpp/support/status.h>

#include "server/gate/refusal.h"
#include "server/record/session/session_store.h"

namespace mwidth::rpc {

/// FAILED_PRECONDITION, NO_SESSION: the server was started without recording.
gate::Refusal NothingRecords();
/// NOT_FOUND, UNKNOWN_SESSION.
gate::Refusal UnknownSession();
/// What the recorder would not do.
gate::Refusal ToRefusal(const record::SessionRefused& refused);
/// DATA_LOSS, UNREADABLE_SESSION.
gate::Refusal Unreadable(const std::string& why);

}  // namespace mwidth::rpc
