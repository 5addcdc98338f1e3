#include "server/rpc/convert_record.h"

#include <google/protobuf/util/time_util.h>

#include <map>

#include "server/record/utf8.h"

namespace mwidth::rpc {
namespace {

// Of files that anything may have been written into.
std::string Text(const std::string& text) { return record::WellFormedUtf8(text); }

template <typename Map>
void Copy(const std::map<std::string, std::string>& from, Map& to) {
  for (const auto& [key, value] : from) {
    to[Text(key)] = Text(value);
  }
}

v1::SessionState Convert(record::SessionState state, bool recording) {
  switch (state) {
    case record::SessionState::kOpen:
      // Of another server that lives, or of one that died: what it is turns out when it is recovered.
      return recording ? v1::SESSION_STATE_RECORDING : v1::SESSION_STATE_RECOVERED;
    case record::SessionState::kEnded:
      return v1::SESSION_STATE_ENDED;
    case record::SessionState::kRecovered:
      return v1::SESSION_STATE_RECOVERED;
  }
  return v1::SESSION_STATE_UNSPECIFIED;
}

}  // namespace

google::protobuf::Timestamp WallTime(int64_t wall_ns) {
  return google::protobuf::util::TimeUtil::NanosecondsToTimestamp(wall_ns);
}

void Convert(const std::string& axis, const record::Event& event, v1::Event& message) {
  message.set_axis(axis);
  message.set_number(event.number);
  // The numbers of the two agree: both are in files and on the wire for good.
  message.set_kind(static_cast<v1::EventKind>(event.kind));
  message.set_tick(event.tick);
  message.set_monotonic_ns(event.monotonic_ns);
  message.set_message(Text(event.message));
  Copy(event.metadata, *message.mutable_metadata());
}

void Convert(const record::Marker& marker, v1::Marker& message) {
  message.set_number(marker.number);
  message.set_label(Text(marker.label));
  message.set_kind(Text(marker.kind));
  Copy(marker.metadata, *message.mutable_metadata());
  message.set_monotonic_ns(marker.monotonic_ns);
  message.set_error_ns(marker.error_ns);
  message.set_arrival_ns(marker.arrival_ns);
  message.set_client_ns(marker.client_ns);
}

void Convert(const record::SessionInfo& info, bool recording, v1::Session& message) {
  message.set_session_id(Text(info.id));
  message.set_axis(Text(info.axis.name));
  v1::SessionLabels& labels = *message.mutable_labels();
  labels.set_subject(Text(info.labels.subject));
  labels.set_visit(Text(info.labels.visit));
  labels.set_task(Text(info.labels.task));
  labels.set_run(static_cast<uint32_t>(info.labels.run));
  labels.set_operator_(Text(info.labels.operator_name));
  Copy(info.labels.metadata, *labels.mutable_metadata());
  message.set_state(Convert(info.state, recording));
  *message.mutable_start_time() = WallTime(info.start_wall_ns);
  if (info.end_wall_ns) {
    *message.mutable_end_time() = WallTime(*info.end_wall_ns);
  }
  message.set_start_monotonic_ns(info.start_monotonic_ns);
  message.set_period_s(info.axis.period_s);
  message.set_samples(info.sample_count);
  message.set_first_tick(info.first_tick);
  message.set_last_tick(info.last_tick);
  message.set_software_version(Text(info.provenance.software_version));
}

}  // namespace mwidth::rpc
