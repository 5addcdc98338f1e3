// Between what is recorded and the messages of the API. Each Convert fills an empty message.
#pragma once

#include <string>

#include "mwidth/v1/session.pb.h"
#include "mwidth/v1/telemetry.pb.h"
#include "server/record/event.h"
#include "server/record/session/session_info.h"

namespace mwidth::rpc {

void Convert(const std::string& axis, const record::Event& event, v1::Event& message);
void Convert(const record::Marker& marker, v1::Marker& message);
/// All but the ticks that are absent, the size of the file and the message. `recording`: by this server, now.
void Convert(const record::SessionInfo& info, bool recording, v1::Session& message);

/// Nanoseconds since 1970.
google::protobuf::Timestamp WallTime(int64_t wall_ns);

}  // namespace mwidth::rpc
