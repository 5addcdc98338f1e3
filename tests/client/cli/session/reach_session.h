// A session whose every number is known: a simulated arm reaches under one mass after another.
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "server/gate/figures.h"
#include "server/record/event.h"
#include "server/record/session/session_info.h"
#include "tests/server/render/held_axis.h"

namespace mwidth::cli::session {

/// All that a session's file holds.
struct RecordedSession {
  record::SessionInfo info;
  std::vector<exchange::Sample> samples;
  std::vector<record::Event> events;
  std::vector<record::Marker> markers;
};

struct ReachPlan {
  std::vector<double> masses{0.0, 0.1, -0.04};
  int reaches_each = 3;
  bool marked = true;
};

/// The shipped configuration "elbow", rendered by the server's own loop: a reach of 30 degrees of 0.8 s, a
/// hold of 1.2 s, back and a hold. Each trial begins 0.5 s before the hand does, and ends 1.7 s after that.
class ReachSession {
 public:
  explicit ReachSession(ReachPlan plan) : plan_(std::move(plan)) {}

  RecordedSession Record() {
    Describe();
    int trial = 0;
    for (const double mass : plan_.masses) {
      axis_.Render(mass);
      NoteMass(mass);
      for (int i = 0; i < plan_.reaches_each; ++i) {
        RunS(kHoldS - 0.5);
        Mark("trial_start", "reach " + std::to_string(++trial));
        RunS(0.5 + kReachS + 0.9);
        Mark("trial_end", "");
        RunS(kHoldS - 0.9 + kReachS);
      }
    }
    session_.events.push_back({.number = ++events_,
                               .kind = record::EventKind::kMassRefused,
                               .tick = axis_.ticks(),
                               .monotonic_ns = NowNs(),
                               .message = "A virtual mass of -0.5 kg m^2 would make the loop unstable.",
                               .metadata = {{"mass", "-0.5"}, {"reason", "UNSTABLE_MASS"}}});
    session_.info.sample_count = session_.samples.size();
    session_.info.first_tick = session_.samples.front().tick;
    session_.info.last_tick = session_.samples.back().tick;
    session_.info.end_wall_ns =
        session_.info.start_wall_ns + session_.samples.back().monotonic_ns - session_.info.start_monotonic_ns;
    session_.info.state = record::SessionState::kEnded;
    return std::move(session_);
  }

 private:
  static constexpr double kReachS = 0.8;
  static constexpr double kHoldS = 1.2;

  void Describe() {
    const server::AxisConfig& config = certified_.config;
    session_.info.id = "sub-01_task-reach_run-1";
    session_.info.labels = {.subject = "01",
                            .visit = "1",
                            .task = "reach",
                            .run = 1,
                            .operator_name = "A. Technician",
                            .metadata = {{"handedness", "right"}}};
    session_.info.axis = {.name = config.name,
                          .rotary = true,
                          .period_s = config.loop.period_s,
                          .position_quantum = config.drive.position_quantum,
                          .force_quantum = config.drive.force_quantum,
                          .acceleration_quantum = 0,
                          .force_limit = config.limits.force,
                          .force_slew_limit = std::numeric_limits<double>::infinity()};
    session_.info.provenance = {
        .software_version = "0.1.0",
        .configuration = "[[axis]]\nname = \"elbow\"\n",
        .command_line = "mwidthd --config elbow",
        .axis_state = R"({"info": {"name": "elbow", "simulated": true, "loop": {"device_mass": )" +
                      gate::Figure(config.loop.device_mass) + R"(, "device_damping": )" +
                      gate::Figure(config.loop.device_damping) + R"(, "hand_mass": 0.0685, )" +
                      R"("hand_damping": 1, "hand_stiffness": 25, "period_s": 0.001, "cutoff_hz": 20}}, )" +
                      R"("m_width": {"required_gain_margin_db": 3, "nominal": {"min": -0.24, "max": 4.7}}})"};
    session_.info.start_wall_ns = 1'795'329'135'000'000'000;
    session_.info.start_monotonic_ns = 0;
  }
  void RunS(double time_s) {
    for (auto left = std::lround(time_s / certified_.config.loop.period_s); left > 0; --left) {
      session_.samples.push_back(axis_.Run());
    }
  }
  int64_t NowNs() const { return session_.samples.empty() ? 0 : session_.samples.back().monotonic_ns; }
  void NoteMass(double mass) {
    const gate::StabilityReport report =
        certified_.stability.Judge(mass, {-100, 100}, model::AxisKind::kRotary);
    record::Event event{.number = ++events_,
                        .kind = record::EventKind::kMassSet,
                        .tick = axis_.ticks() + 1,
                        .monotonic_ns = NowNs(),
                        .message = "A virtual mass of " + gate::Figure(mass) + " kg m^2 is set.",
                        .metadata = {{"mass", gate::Figure(mass)},
                                     {"gain_margin_db", gate::Figure(report.gain_margin_db)},
                                     {"phase_margin_deg",
                                      gate::Figure(report.margins.phase_rad.value * 180 / std::numbers::pi)},
                                     {"delay_margin_s", gate::Figure(report.margins.delay.seconds)},
                                     {"modulus_margin", gate::Figure(report.margins.modulus.value)},
                                     {"admitted_min", gate::Figure(report.range.admitted.min)},
                                     {"admitted_max", gate::Figure(report.range.admitted.max)},
                                     {"robust_min", gate::Figure(report.range.robust.min)},
                                     {"robust_max", gate::Figure(report.range.robust.max)}}};
    session_.events.push_back(std::move(event));
  }
  void Mark(const std::string& kind, const std::string& label) {
    if (plan_.marked) {
      record::Marker marker{.number = session_.markers.size() + 1,
                            .label = label,
                            .kind = kind,
                            .metadata = {},
                            .monotonic_ns = NowNs(),
                            .error_ns = 150'000,
                            .arrival_ns = NowNs() + 1'000'000,
                            .client_ns = 0};
      if (kind == "trial_start") {
        marker.metadata = {{"target_deg", "30"}, {"start_deg", "0"}};
      }
      session_.markers.push_back(std::move(marker));
    }
  }

  ReachPlan plan_;
  render::CertifiedAxis certified_{server::LoadConfig(CONFIG_DIR "/elbow.toml").axes.front()};
  render::HeldAxis axis_{
      certified_, certified_.config.loop,
      std::make_unique<device::MinimumJerkReach>(device::ReachParameters{
          .start_position = 0, .amplitude = std::numbers::pi / 6, .duration_s = kReachS, .hold_s = kHoldS})};
  RecordedSession session_;
  uint64_t events_ = 0;
};

}  // namespace mwidth::cli::session
