#include "server/rpc/session_playback.h"

#include <algorithm>
#include <span>
#include <string>
#include <utility>

#include "server/rpc/convert_record.h"
#include "server/rpc/sample_encoding.h"

namespace mwidth::rpc {
namespace {

using exchange::Sample;

class Playback {
 public:
  using Take = std::function<bool(const v1::ReadSessionResponse&)>;

  Playback(record::SessionReader& session, const PlaybackRequest& request, const Take& take)
      : session_(session),
        request_(request),
        last_tick_(LastTick(session.info(), request)),
        take_(take),
        axis_(session.info().axis.name),
        batcher_({.max_batch = request.max_batch}) {
    CollectNotes();
  }

  void Run() {
    session_.Seek(request_.first_tick);
    std::vector<Sample> samples;
    while (going_ && session_.Next(samples)) {
      const auto end =
          std::upper_bound(samples.begin(), samples.end(), last_tick_,
                           [](uint64_t tick, const Sample& sample) { return tick < sample.tick; });
      Send(std::span(samples.begin(), end));
      if (end != samples.end()) {
        break;
      }
    }
    // Those behind the last sample, where the whole session is asked for.
    if (last_tick_ >= session_.info().last_tick) {
      SendNotesUpTo(INT64_MAX);
    }
  }

 private:
  struct Note {
    int64_t monotonic_ns = 0;
    v1::ReadSessionResponse message;
  };

  // A session that grows ends, for this call, where it ended when its events and markers were read.
  static uint64_t LastTick(const record::SessionInfo& info, const PlaybackRequest& request) {
    return info.last_tick == 0 ? request.last_tick : std::min(request.last_tick, info.last_tick);
  }

  void CollectNotes() {
    for (const record::Event& event : session_.Events()) {
      Note& note = notes_.emplace_back(Note{.monotonic_ns = event.monotonic_ns, .message = {}});
      Convert(axis_, event, *note.message.mutable_event());
    }
    for (const record::Marker& marker : session_.Markers()) {
      Note& note = notes_.emplace_back(Note{.monotonic_ns = marker.monotonic_ns, .message = {}});
      Convert(marker, *note.message.mutable_marker());
    }
    std::stable_sort(notes_.begin(), notes_.end(),
                     [](const Note& a, const Note& b) { return a.monotonic_ns < b.monotonic_ns; });
  }

  // Batches end where a note comes between.
  void Send(std::span<const Sample> samples) {
    while (going_ && !samples.empty()) {
      if (samples.front().tick < request_.first_tick) {
        SkipNotesUpTo(samples.front().monotonic_ns);
        samples = samples.subspan(1);
        continue;
      }
      const auto cut =
          next_note_ == notes_.size()
              ? samples.end()
              : std::lower_bound(samples.begin(), samples.end(), notes_[next_note_].monotonic_ns,
                                 [](const Sample& sample, int64_t ns) { return sample.monotonic_ns < ns; });
      batcher_.Take(std::span(samples.begin(), cut),
                    [this](const record::Batch& batch) { SendBatch(batch); });
      samples = std::span(cut, samples.end());
      if (!samples.empty()) {
        SendNotesUpTo(samples.front().monotonic_ns);
      }
    }
  }

  void SendBatch(const record::Batch& batch) {
    if (going_) {
      v1::ReadSessionResponse message;
      Convert(axis_, batch, *message.mutable_batch());
      going_ = take_(message);
    }
  }

  void SendNotesUpTo(int64_t monotonic_ns) {
    for (; going_ && next_note_ < notes_.size() && notes_[next_note_].monotonic_ns <= monotonic_ns;
         ++next_note_) {
      going_ = take_(notes_[next_note_].message);
    }
  }

  void SkipNotesUpTo(int64_t monotonic_ns) {
    while (next_note_ < notes_.size() && notes_[next_note_].monotonic_ns <= monotonic_ns) {
      ++next_note_;
    }
  }

  record::SessionReader& session_;
  const PlaybackRequest request_;
  const uint64_t last_tick_;
  const Take& take_;
  const std::string axis_;
  record::Batcher batcher_;
  std::vector<Note> notes_;
  std::size_t next_note_ = 0;
  bool going_ = true;
};

}  // namespace

void Play(record::SessionReader& session, const PlaybackRequest& request,
          const std::function<bool(const v1::ReadSessionResponse&)>& take) {
  Playback(session, request, take).Run();
}

}  // namespace mwidth::rpc
