#include "server/record/session/session_rows.h"

#include "server/record/session/sample_codec.h"
#include "server/record/session/session_schema.h"

namespace mwidth::record {

SessionRows::SessionRows(SQLite::Database& database)
    : begin_(database, "BEGIN IMMEDIATE"),
      commit_(database, "COMMIT"),
      block_(database, "INSERT INTO blocks VALUES(?, ?, ?, ?, ?, ?)"),
      tail_(database, "INSERT INTO tail VALUES(?, ?, ?, ?, ?, ?)"),
      clear_tail_(database, "DELETE FROM tail"),
      event_(
          database,
          "INSERT INTO events(number, kind, tick, monotonic_ns, message, metadata) VALUES(?, ?, ?, ?, ?, ?)"),
      marker_(database, "INSERT INTO markers VALUES(?, ?, ?, ?, ?, ?, ?, ?)"),
      gap_(database,
           "INSERT INTO gaps(after_tick, before_tick, missed_ticks, lost_ticks, reason) VALUES(?, ?, ?, ?, "
           "?)"),
      step_(database, "INSERT INTO wall_clock_steps(monotonic_ns, offset_ns) VALUES(?, ?)") {}

void SessionRows::Execute(SQLite::Statement& statement) {
  // Not reset(), which tells an error of the last time once more.
  statement.tryReset();
  statement.exec();
  statement.tryReset();
}

void SessionRows::Insert(SQLite::Statement& insert, int64_t number, std::span<const exchange::Sample> samples,
                         std::span<const std::byte> bytes) {
  insert.tryReset();
  insert.bind(1, number);
  insert.bind(2, static_cast<int64_t>(samples.front().tick));
  insert.bind(3, static_cast<int64_t>(samples.back().tick));
  insert.bind(4, static_cast<int64_t>(samples.size()));
  insert.bind(5, static_cast<int64_t>(Checksum(bytes)));
  insert.bindNoCopy(6, bytes.data(), static_cast<int>(bytes.size()));
  Execute(insert);
}

void SessionRows::Insert(const Event& event) {
  event_.tryReset();
  event_.bind(1, static_cast<int64_t>(event.number));
  event_.bind(2, static_cast<int>(event.kind));
  event_.bind(3, static_cast<int64_t>(event.tick));
  event_.bind(4, event.monotonic_ns);
  event_.bind(5, event.message);
  event_.bind(6, MetadataText(event.metadata));
  Execute(event_);
}

void SessionRows::Insert(const Marker& marker) {
  marker_.tryReset();
  marker_.bind(1, static_cast<int64_t>(marker.number));
  marker_.bind(2, marker.label);
  marker_.bind(3, marker.kind);
  marker_.bind(4, MetadataText(marker.metadata));
  marker_.bind(5, marker.monotonic_ns);
  marker_.bind(6, marker.error_ns);
  marker_.bind(7, marker.arrival_ns);
  marker_.bind(8, marker.client_ns);
  Execute(marker_);
}

void SessionRows::Insert(const Gap& gap) {
  gap_.tryReset();
  gap_.bind(1, static_cast<int64_t>(gap.after_tick));
  gap_.bind(2, static_cast<int64_t>(gap.before_tick));
  gap_.bind(3, static_cast<int64_t>(gap.missed_ticks));
  gap_.bind(4, static_cast<int64_t>(gap.lost_ticks));
  gap_.bind(5, gap.reason);
  Execute(gap_);
}

void SessionRows::Insert(const WallClockStep& step) {
  step_.tryReset();
  step_.bind(1, step.monotonic_ns);
  step_.bind(2, step.offset_ns);
  Execute(step_);
}

}  // namespace mwidth::record
