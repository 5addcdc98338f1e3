#include "server/rpc/session_refusals.h"

namespace mwidth::rpc {

using gate::Refusal;
using gate::RefusalCode;

Refusal NothingRecords() {
  return {.code = RefusalCode::kFailedPrecondition,
          .reason = gate::kNoSession,
          .message = "This server records no sessions."};
}

Refusal UnknownSession() {
  return {.code = RefusalCode::kNotFound,
          .reason = gate::kUnknownSession,
          .message = "There is no session of that id: ListSessions tells which there are."};
}

Refusal ToRefusal(const record::SessionRefused& refused) {
  const auto refusal = [&refused](RefusalCode code, const char* reason) {
    return Refusal{.code = code, .reason = reason, .message = refused.what()};
  };
  switch (refused.reason()) {
    case record::SessionRefusal::kSessionOpen:
      return refusal(RefusalCode::kFailedPrecondition, gate::kSessionOpen);
    case record::SessionRefusal::kSessionExists:
      return refusal(RefusalCode::kFailedPrecondition, gate::kSessionExists);
    case record::SessionRefusal::kNoSession:
      return refusal(RefusalCode::kFailedPrecondition, gate::kNoSession);
    case record::SessionRefusal::kStorageFull:
      return refusal(RefusalCode::kResourceExhausted, gate::kStorageFull);
    case record::SessionRefusal::kStorageFailed:
      break;
  }
  return refusal(RefusalCode::kUnavailable, gate::kStorageFailed);
}

Refusal Unreadable(const std::string& why) {
  return {.code = RefusalCode::kDataLoss, .reason = gate::kUnreadableSession, .message = why};
}

}  // namespace mwidth::rpc
