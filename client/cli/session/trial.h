// The parts of a session that are looked at one by one.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "server/exchange/crossing.h"
#include "server/record/session/session_info.h"

namespace mwidth::cli::session {

/// A row of samples with what is needed to judge movements in it.
struct Trial {
  /// The label of its marker, or what was rendered.
  std::string label;
  /// Of its markers; those of trial_start before those of trial_end.
  std::map<std::string, std::string> metadata{};
  /// From "trial_start" to "trial_end"; otherwise a time of rendering under one mass.
  bool marked = false;
  /// Longer than TrialSplitter::kLongestS, and cut there.
  bool cut = false;
  int64_t start_ns = 0;

  /// Columns of equal length. Positions that are stale have no sample.
  std::vector<uint64_t> tick{};
  std::vector<double> position{};
  std::vector<double> force{};
  std::vector<double> mass{};
  /// With the first sample, and wherever it changed, by index.
  std::vector<std::pair<std::size_t, exchange::Filter>> filters{};

  /// Ticks of the trial that had no position, whose force was clamped, and in which nothing was rendered.
  uint64_t stale_ticks = 0;
  uint64_t saturated_ticks = 0;
  uint64_t slew_limited_ticks = 0;
  uint64_t not_rendering_ticks = 0;
};

/// Cuts a session into trials as its samples pass. With a marker of kind "trial_start" trials are what lies
/// between each of these and the next "trial_end", or the next "trial_start", or the end. Without any, they
/// are the times of at least kShortestS in which one mass was rendered. Memory: one trial.
class TrialSplitter {
 public:
  static constexpr double kLongestS = 120;
  static constexpr double kShortestS = 0.5;

  /// `markers` in the order of their numbers. `take` gets each trial when it is complete.
  TrialSplitter(const std::vector<record::Marker>& markers, double period_s,
                std::function<void(Trial&&)> take);

  /// In the order of ticks.
  void Add(const exchange::Sample& sample);
  /// After the last sample.
  void End();

  bool marked() const noexcept { return marked_; }

 private:
  struct Span {
    int64_t start_ns = 0;
    int64_t end_ns = 0;
    std::string label;
    std::map<std::string, std::string> metadata;
  };
  static std::vector<Span> SpansOf(std::vector<record::Marker> markers);

  void AddMarked(const exchange::Sample& sample);
  void AddUnmarked(const exchange::Sample& sample);
  void Append(const exchange::Sample& sample);
  void Begin(const std::string& label, bool marked, int64_t start_ns);
  void Finish();
  bool LongEnough() const;
  bool Full(const exchange::Sample& sample) const;

  std::vector<Span> spans_;
  std::size_t next_span_ = 0;
  bool marked_;
  double period_s_;
  std::function<void(Trial&&)> take_;
  std::optional<Trial> trial_;
  uint64_t first_tick_ = 0;
  int64_t end_ns_ = 0;
};

}  // namespace mwidth::cli::session
