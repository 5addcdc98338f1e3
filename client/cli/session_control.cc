// session start, end and mark: what the server is asked; everything else of `mwidth session` reads files.
#include <iostream>

#include "client/cli/commands.h"
#include "client/cli/json.h"
#include "client/cpp/client.h"

namespace mwidth::cli {
namespace {

template <typename Message>
void Print(const CommandLine& line, const Message& answer, const std::string& text) {
  if (line.json) {
    std::cout << ToJson(answer);
  } else {
    std::cout << text << "\n";
  }
}

// The session that records the axis, or, where the axis is not named, the only one that records.
std::string RecordingSession(const client::Client& client, const CommandLine& line) {
  const auto listed = client.ListSessions();
  std::string found;
  for (const v1::Session& session : listed.sessions()) {
    if (session.state() != v1::SESSION_STATE_RECORDING ||
        (!line.axis.empty() && session.axis() != line.axis)) {
      continue;
    }
    if (!found.empty()) {
      throw client::Error(grpc::Status(grpc::StatusCode::FAILED_PRECONDITION,
                                       "several sessions are being recorded: name one, " + found + " say"));
    }
    found = session.session_id();
  }
  if (found.empty()) {
    throw client::Error(grpc::Status(grpc::StatusCode::FAILED_PRECONDITION,
                                     "no session is being recorded: mwidth session start"));
  }
  return found;
}

}  // namespace

int RunSessionStart(const CommandLine& line) {
  const auto client = client::Client::Connect(line.server);
  const auto session = client.StartSession(line.session.labels, line.axis);
  Print(
      line, session,
      "recording " + session.session_id() + "\nOnce it is done: mwidth session end " + session.session_id());
  return kDone;
}

int RunSessionEnd(const CommandLine& line) {
  const auto client = client::Client::Connect(line.server);
  const auto session = client.EndSession(line.session.sessions.empty() ? RecordingSession(client, line)
                                                                       : line.session.sessions.front());
  const uint64_t absent = session.missed_ticks() + session.lost_ticks();
  Print(line, session,
        session.session_id() + ": " + std::to_string(session.samples()) + " samples" +
            (absent == 0 ? "" : ", " + std::to_string(absent) + " ticks without one") + ", " +
            std::to_string(session.file_bytes()) + " bytes");
  return kDone;
}

int RunSessionMark(const CommandLine& line) {
  v1::AddMarkerRequest request;
  request.set_axis(line.axis);
  request.set_label(line.session.marker);
  request.set_kind(line.session.marker_kind);
  request.mutable_metadata()->insert(line.session.marker_metadata.begin(),
                                     line.session.marker_metadata.end());
  const auto marker = client::Client::Connect(line.server).AddMarker(request);
  Print(line, marker, "marker " + std::to_string(marker.number()));
  return kDone;
}

}  // namespace mwidth::cli
