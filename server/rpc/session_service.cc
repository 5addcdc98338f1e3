#include "server/rpc/session_service.h"

#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include "server/gate/axis_gate.h"
#include "server/gate/invalid_number.h"
#include "server/record/event_log.h"
#include "server/record/session/session_reader.h"
#include "server/record/session/session_recorder.h"
#include "server/rpc/convert_record.h"
#include "server/rpc/describe_state.h"
#include "server/rpc/on_axis.h"
#include "server/rpc/session_description.h"
#include "server/rpc/session_pace.h"
#include "server/rpc/session_playback.h"
#include "server/rpc/session_refusals.h"
#include "server/rpc/session_request.h"

namespace mwidth::rpc {
namespace {

using gate::RefusalCode;

constexpr uint32_t kDefaultBatch = 100;
constexpr uint32_t kMaxBatch = 1000;
constexpr int kMaxListed = 1000;
constexpr double kMinSpeed = 0.01;
constexpr double kMaxSpeed = 1000;
// How long the end of a session waits for the samples of its last ticks.
constexpr std::chrono::milliseconds kDrainPatience{500};
constexpr std::chrono::milliseconds kDrainStep{2};

// What `work` returns, or why the recorder would not.
template <typename T, typename Work>
gate::Result<T> OrRefusal(const Work& work) {
  try {
    return work();
  } catch (const record::SessionRefused& refused) {
    return ToRefusal(refused);
  }
}

record::SessionAxis AxisOf(const gate::AxisDescription& axis) {
  return {.name = axis.name,
          .rotary = axis.kind == model::AxisKind::kRotary,
          .period_s = axis.loop.period_s,
          .position_quantum = axis.position_quantum,
          .force_quantum = axis.force_quantum,
          .acceleration_quantum = axis.acceleration_quantum,
          .force_limit = axis.force_limit,
          .force_slew_limit = axis.force_slew_limit};
}

std::string StateAsJson(gate::AxisGate& gate) {
  v1::AxisState state;
  Describe(gate, state);
  google::protobuf::util::JsonPrintOptions options;
  options.preserve_proto_field_names = true;
  options.always_print_primitive_fields = true;
  std::string json;
  if (!google::protobuf::util::MessageToJsonString(state, &json, options).ok()) {
    throw std::runtime_error("cannot write the axis's state as JSON");
  }
  return json;
}

// Reads files at a low priority: decoding an hour takes a second that no loop must feel.
template <typename Handler>
grpc::Status Unfelt(const char* method, const Handler& handler) {
  return Guarded(method, [&] {
    return AtLowPriority([&]() -> grpc::Status {
      try {
        return handler();
      } catch (const record::SessionFileError& error) {
        return ToStatus(Unreadable(error.what()));
      }
    });
  });
}

gate::Result<PlaybackRequest> ReadRequest(const v1::ReadSessionRequest& request) {
  if (request.max_batch() > kMaxBatch) {
    return gate::InvalidNumber("max_batch", request.max_batch(), "0 to " + std::to_string(kMaxBatch));
  }
  if (request.speed() != 0 && !(request.speed() >= kMinSpeed && request.speed() <= kMaxSpeed)) {
    return gate::InvalidNumber("speed", request.speed(), "0.01 to 1000, or 0 for as fast as it is read");
  }
  PlaybackRequest read{.first_tick = request.first_tick(),
                       .max_batch = request.max_batch() == 0 ? kDefaultBatch : request.max_batch()};
  if (request.last_tick() != 0) {
    read.last_tick = request.last_tick();
  }
  return read;
}

}  // namespace

SessionService::SessionService(const AxisRegistry& axes, Recording recording)
    : axes_(axes), recording_(std::move(recording)) {}

gate::Result<record::SessionInfo> SessionService::Start(const Axis& axis, const v1::SessionLabels& sent) {
  const auto labels = ReadLabels(sent);
  if (!labels.ok()) {
    return labels.refusal();
  }
  if (axis.recorder == nullptr) {
    return NothingRecords();
  }
  record::SessionProvenance provenance = recording_.provenance;
  provenance.axis_state = StateAsJson(axis.gate);
  auto started = OrRefusal<record::SessionInfo>([&] {
    return axis.recorder->Start(*labels, AxisOf(axis.gate.description()), provenance,
                                axis.gate.Status().tick + 1);
  });
  if (started.ok()) {
    axis.events.Publish(record::EventKind::kSessionStarted, "Session " + started->id + " begins.",
                        {{"session_id", started->id}});
  }
  return started;
}

gate::Result<record::SessionInfo> SessionService::End(const Axis& axis, const std::string& session_id) {
  // With everything up to now: what the loop has done is on its way for a few milliseconds.
  const uint64_t newest = axis.gate.Status().tick;
  const auto patience = std::chrono::steady_clock::now() + kDrainPatience;
  while (std::chrono::steady_clock::now() < patience) {
    const auto active = axis.recorder->Active();
    if (!active || active->last_tick >= newest) {
      break;
    }
    std::this_thread::sleep_for(kDrainStep);
  }
  axis.events.Publish(record::EventKind::kSessionEnded, "Session " + session_id + " ends.",
                      {{"session_id", session_id}});
  return OrRefusal<record::SessionInfo>([&] { return axis.recorder->End(session_id); });
}

grpc::Status SessionService::StartSession(grpc::ServerContext*, const v1::StartSessionRequest* request,
                                          v1::StartSessionResponse* response) {
  return OnAxis(
      "StartSession", axes_, request->axis(),
      [&](const Axis& axis) { return Start(axis, request->labels()); },
      [&](const record::SessionInfo& info) { Convert(info, true, *response->mutable_session()); });
}

grpc::Status SessionService::EndSession(grpc::ServerContext*, const v1::EndSessionRequest* request,
                                        v1::EndSessionResponse* response) {
  return Guarded("EndSession", [&] {
    // Of several that end the same session, one does.
    const std::lock_guard ending(ending_);
    for (const Axis& axis : axes_.axes()) {
      const auto active = axis.recorder == nullptr ? std::nullopt : axis.recorder->Active();
      if (!active || active->id != request->session_id()) {
        continue;
      }
      const auto ended = End(axis, request->session_id());
      if (!ended.ok()) {
        return ToStatus(ended.refusal());
      }
      Convert(*ended, false, *response->mutable_session());
      if (const auto file = recording_.store.PathOf(ended->id)) {
        *response->mutable_session() = Describe(record::SessionStore::Examine(*file));
      }
      return grpc::Status::OK;
    }
    return ToStatus(UnknownSession());
  });
}

grpc::Status SessionService::AddMarker(grpc::ServerContext*, const v1::AddMarkerRequest* request,
                                       v1::AddMarkerResponse* response) {
  return OnAxis(
      "AddMarker", axes_, request->axis(),
      [&](const Axis& axis) -> gate::Result<record::RecordedMarker> {
        const auto marker = ReadMarker(*request, axis.clock.NowNs());
        if (!marker.ok()) {
          return marker.refusal();
        }
        if (axis.recorder == nullptr) {
          return NothingRecords();
        }
        return OrRefusal<record::RecordedMarker>([&] { return axis.recorder->AddMarker(*marker); });
      },
      [&](const record::RecordedMarker& recorded) {
        response->set_session_id(recorded.session_id);
        Convert(recorded.marker, *response->mutable_marker());
      });
}

std::optional<record::SessionInfo> SessionService::ActiveOf(const std::string& session_id) const {
  for (const Axis& axis : axes_.axes()) {
    auto active = axis.recorder == nullptr ? std::nullopt : axis.recorder->Active();
    if (active && active->id == session_id) {
      return active;
    }
  }
  return std::nullopt;
}

v1::Session SessionService::Describe(const record::StoredSession& stored) const {
  return rpc::Describe(stored, ActiveOf(stored.id));
}

grpc::Status SessionService::ListSessions(grpc::ServerContext*, const v1::ListSessionsRequest* request,
                                          v1::ListSessionsResponse* response) {
  return Unfelt("ListSessions", [&] {
    const auto is = [](const std::string& wanted, const std::string& label, const std::string& prefix) {
      return wanted.empty() || wanted == label || wanted == prefix + label;
    };
    for (const record::StoredSession& session : recording_.store.List()) {
      const record::SessionLabels labels = session.info ? session.info->labels : record::SessionLabels{};
      if (is(request->subject(), labels.subject, "sub-") && is(request->visit(), labels.visit, "ses-") &&
          is(request->task(), labels.task, "task-")) {
        if (response->sessions_size() == kMaxListed) {
          response->set_truncated(true);
          break;
        }
        *response->add_sessions() = Describe(session);
      }
    }
    return grpc::Status::OK;
  });
}

grpc::Status SessionService::GetSession(grpc::ServerContext*, const v1::GetSessionRequest* request,
                                        v1::GetSessionResponse* response) {
  return Unfelt("GetSession", [&] {
    const auto file = recording_.store.PathOf(request->session_id());
    if (!file) {
      return ToStatus(UnknownSession());
    }
    const record::StoredSession stored = record::SessionStore::Examine(*file);
    *response->mutable_session() = Describe(stored);
    if (response->session().state() == v1::SESSION_STATE_UNREADABLE) {
      return ToStatus(Unreadable(response->session().message()));
    }
    AddContents(stored, *response);
    return grpc::Status::OK;
  });
}

grpc::Status SessionService::ReadSession(grpc::ServerContext* context, const v1::ReadSessionRequest* request,
                                         grpc::ServerWriter<v1::ReadSessionResponse>* writer) {
  return Unfelt("ReadSession", [&] {
    const auto playback = ReadRequest(*request);
    if (!playback.ok()) {
      return ToStatus(playback.refusal());
    }
    const ComputationLimit::Place place(readers_);
    if (!place.taken()) {
      return ToStatus({.code = RefusalCode::kResourceExhausted,
                       .reason = gate::kTooManyStreams,
                       .message = "The server reads " + std::to_string(kMaxSessionReaders) +
                                  " sessions already, its limit: ask again when one of them is done."});
    }
    const auto file = recording_.store.PathOf(request->session_id());
    if (!file) {
      return ToStatus(UnknownSession());
    }
    record::SessionReader reader(*file);
    Pace pace(*context, request->speed());
    Play(reader, *playback, [&](const v1::ReadSessionResponse& record) {
      return (!record.has_batch() || pace.Await(record.batch().monotonic_ns(0))) && writer->Write(record);
    });
    return grpc::Status::OK;
  });
}

}  // namespace mwidth::rpc
