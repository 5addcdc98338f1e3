#include "server/rpc/session_description.h"

#include "server/record/session/session_reader.h"
#include "server/record/utf8.h"
#include "server/rpc/convert_record.h"

namespace mwidth::rpc {
namespace {

// gRPC's clients take 4 MB by default.
constexpr std::size_t kMaxNotesBytes = 2'000'000;

// Counts the ticks that are absent.
void CountAbsent(const std::filesystem::path& file, v1::Session& message) {
  const record::GapTotals totals = record::TotalsOf(record::SessionReader(file).NotedGaps());
  message.set_missed_ticks(totals.missed_ticks);
  message.set_lost_ticks(totals.lost_ticks);
}

}  // namespace

v1::Session Describe(const record::StoredSession& stored, const std::optional<record::SessionInfo>& active) {
  v1::Session message;
  message.set_session_id(record::WellFormedUtf8(stored.id));
  message.set_state(v1::SESSION_STATE_UNREADABLE);
  message.set_message(record::WellFormedUtf8(stored.problem));
  message.set_file_bytes(stored.file_bytes);
  if (!stored.info) {
    return message;
  }
  // As it stands, where it is recorded here: the file knows its samples when it ends.
  Convert(active.value_or(*stored.info), stored.recording, message);
  try {
    CountAbsent(stored.file, message);
  } catch (const record::SessionFileError& error) {
    message.set_state(v1::SESSION_STATE_UNREADABLE);
    message.set_message(record::WellFormedUtf8(error.what()));
  }
  return message;
}

void AddContents(const record::StoredSession& stored, v1::GetSessionResponse& response) {
  const record::SessionReader reader(stored.file);
  std::size_t bytes = 0;
  const auto fits = [&](const google::protobuf::Message& added) {
    bytes += added.ByteSizeLong();
    return bytes <= kMaxNotesBytes;
  };
  for (const record::Marker& marker : reader.Markers()) {
    Convert(marker, *response.add_markers());
    if (!fits(response.markers(response.markers_size() - 1))) {
      response.mutable_markers()->RemoveLast();
      response.set_truncated(true);
      break;
    }
  }
  for (const record::Event& event : reader.Events()) {
    Convert(stored.info->axis.name, event, *response.add_events());
    if (!fits(response.events(response.events_size() - 1))) {
      response.mutable_events()->RemoveLast();
      response.set_truncated(true);
      break;
    }
  }
  const record::SessionProvenance& provenance = stored.info->provenance;
  response.set_configuration(record::WellFormedUtf8(provenance.configuration));
  response.set_command_line(record::WellFormedUtf8(provenance.command_line));
  response.set_axis_state(record::WellFormedUtf8(provenance.axis_state));
}

}  // namespace mwidth::rpc
