#include "client/cli/session/trial.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace mwidth::cli::session {

std::vector<TrialSplitter::Span> TrialSplitter::SpansOf(std::vector<record::Marker> markers) {
  std::stable_sort(markers.begin(), markers.end(),
                   [](const auto& a, const auto& b) { return a.monotonic_ns < b.monotonic_ns; });
  std::vector<Span> spans;
  bool open = false;
  for (record::Marker& marker : markers) {
    const bool starts = marker.kind == "trial_start";
    if (open && (starts || marker.kind == "trial_end")) {
      spans.back().end_ns = marker.monotonic_ns;
      open = false;
      if (!starts) {
        spans.back().metadata.merge(marker.metadata);
      }
    }
    if (starts) {
      spans.push_back({.start_ns = marker.monotonic_ns,
                       .end_ns = std::numeric_limits<int64_t>::max(),
                       .label = marker.label,
                       .metadata = std::move(marker.metadata)});
      open = true;
    }
  }
  return spans;
}

TrialSplitter::TrialSplitter(const std::vector<record::Marker>& markers, double period_s,
                             std::function<void(Trial&&)> take)
    : spans_(SpansOf(markers)), marked_(!spans_.empty()), period_s_(period_s), take_(std::move(take)) {}

void TrialSplitter::Add(const exchange::Sample& sample) { marked_ ? AddMarked(sample) : AddUnmarked(sample); }

void TrialSplitter::AddMarked(const exchange::Sample& sample) {
  if (trial_ && sample.monotonic_ns >= end_ns_) {
    Finish();
  }
  while (!trial_ && next_span_ < spans_.size() && sample.monotonic_ns >= spans_[next_span_].start_ns) {
    Span& span = spans_[next_span_++];
    Begin(span.label, true, span.start_ns);
    trial_->metadata = std::move(span.metadata);
    end_ns_ = span.end_ns;
    if (sample.monotonic_ns >= end_ns_) {
      Finish();  // Over before its first sample: it is told, with nothing in it.
    }
  }
  if (trial_) {
    if (Full(sample)) {
      trial_->cut = true;
    } else {
      Append(sample);
    }
  }
}

void TrialSplitter::AddUnmarked(const exchange::Sample& sample) {
  const bool renders = sample.state == exchange::State::kRendering;
  if (trial_ && (!renders || sample.mass != trial_->mass.back() || Full(sample))) {
    if (LongEnough()) {
      trial_->cut = Full(sample);
      Finish();
    }
    trial_.reset();
  }
  if (renders) {
    if (!trial_) {
      if (sample.position_stale) {
        return;  // Nothing to begin with.
      }
      Begin("", false, sample.monotonic_ns);
    }
    Append(sample);
  }
}

bool TrialSplitter::LongEnough() const {
  return static_cast<double>(trial_->tick.size()) * period_s_ >= kShortestS;
}

bool TrialSplitter::Full(const exchange::Sample& sample) const {
  return !trial_->tick.empty() && static_cast<double>(sample.tick - first_tick_) * period_s_ > kLongestS;
}

void TrialSplitter::Begin(const std::string& label, bool marked, int64_t start_ns) {
  trial_.emplace();
  trial_->label = label;
  trial_->marked = marked;
  trial_->start_ns = start_ns;
}

void TrialSplitter::Append(const exchange::Sample& sample) {
  Trial& trial = *trial_;
  trial.saturated_ticks += sample.saturated ? 1 : 0;
  trial.slew_limited_ticks += sample.slew_limited ? 1 : 0;
  trial.not_rendering_ticks += sample.state != exchange::State::kRendering ? 1 : 0;
  if (sample.position_stale) {
    ++trial.stale_ticks;
    return;
  }
  if (trial.tick.empty()) {
    first_tick_ = sample.tick;
  }
  if (trial.filters.empty() || trial.filters.back().second != sample.filter) {
    trial.filters.emplace_back(trial.tick.size(), sample.filter);
  }
  trial.tick.push_back(sample.tick);
  trial.position.push_back(sample.position);
  trial.force.push_back(sample.force);
  trial.mass.push_back(sample.mass);
}

void TrialSplitter::Finish() {
  take_(std::move(*trial_));
  trial_.reset();
}

void TrialSplitter::End() {
  if (trial_ && (marked_ || LongEnough())) {
    Finish();
  }
  trial_.reset();
  for (; next_span_ < spans_.size(); ++next_span_) {  // Marked after the last sample.
    Begin(spans_[next_span_].label, true, spans_[next_span_].start_ns);
    trial_->metadata = std::move(spans_[next_span_].metadata);
    Finish();
  }
}

}  // namespace mwidth::cli::session
