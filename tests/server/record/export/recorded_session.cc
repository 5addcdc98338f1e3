#include "tests/server/record/export/recorded_session.h"

#include <algorithm>
#include <limits>
#include <random>

#include "server/record/session/session_file.h"

namespace mwidth::testing {
namespace {

constexpr int64_t kPeriodNs = 1'000'000;
constexpr int64_t kStartNs = 5'000'000'000'123;

double AnyDouble(std::mt19937_64& random) {
  std::uniform_real_distribution<double> mantissa(-1, 1);
  std::uniform_int_distribution<int> exponent(-40, 40);
  return std::ldexp(mantissa(random), exponent(random));
}

// Where numbers are hard to write.
double Special(uint64_t index) {
  constexpr double kValues[] = {-0.0,
                                std::numeric_limits<double>::denorm_min(),
                                std::numeric_limits<double>::max(),
                                -std::numeric_limits<double>::min(),
                                0.1,
                                1e22,
                                123456789012345680.0};
  return kValues[index % std::size(kValues)];
}

std::vector<exchange::Sample> MakeSamples(std::mt19937_64& random, uint64_t count,
                                          const record::SessionAxis& axis) {
  std::vector<exchange::Sample> samples;
  std::uniform_int_distribution<int64_t> step(-40, 50);
  std::uniform_int_distribution<int64_t> jitter(-30'000, 90'000);
  std::uniform_int_distribution<int> percent(0, 99);
  exchange::Sample sample{.tick = 1000, .monotonic_ns = kStartNs, .position_counts = -2000};
  for (uint64_t i = 0; i < count; ++i) {
    if (i > 0) {
      uint64_t ticks = 1;
      if (i % 701 == 0) {
        // Missed by the loop.
        ticks += 3;
        sample.missed_ticks += 3;
      } else if (i % 1201 == 0) {
        // Ran, and were lost on the way.
        ticks += 17;
      }
      sample.tick += ticks;
    }
    sample.monotonic_ns =
        kStartNs + static_cast<int64_t>(sample.tick - 1000) * kPeriodNs + (i == 0 ? 0 : jitter(random));
    sample.position_counts += step(random);
    sample.acceleration_counts = static_cast<int32_t>(step(random));
    sample.force_counts = static_cast<int32_t>(step(random) * 100);
    sample.state = static_cast<exchange::State>(i * 4 / count);
    sample.saturated = percent(random) < 10;
    sample.slew_limited = sample.saturated && percent(random) < 50;
    sample.position_stale = percent(random) < 2;
    sample.force_taken = percent(random) < 90;
    sample.position = axis.position_quantum * static_cast<double>(sample.position_counts);
    sample.velocity = AnyDouble(random);
    sample.acceleration = i % 50 == 0 ? Special(i / 50) : AnyDouble(random);
    sample.force = axis.force_quantum * sample.force_counts;
    sample.mass = AnyDouble(random);
    sample.filter = {static_cast<uint8_t>(i < count / 2 ? 0 : 3), i < count / 2 ? 20.0 : 31.25};
    sample.answered_tick = sample.tick;
    samples.push_back(sample);
  }
  return samples;
}

record::SessionInfo MakeInfo(bool rotary) {
  return {.id = {},
          .labels = {.subject = "01",
                     .visit = "1",
                     .task = "reach",
                     .run = 2,
                     .operator_name = "Zoë, \"the\" operator",
                     .metadata = {{"arm", "left"}, {"note", "a,b\tc\nd \"e\" ü"}}},
          .axis = {.name = "elbow",
                   .rotary = rotary,
                   .period_s = 1e-9 * kPeriodNs,
                   .position_quantum = 7.6699039394282058e-05,
                   .force_quantum = 0.0030517578125,
                   .acceleration_quantum = 0.01,
                   .force_limit = 10,
                   .force_slew_limit = std::numeric_limits<double>::infinity()},
          .provenance = {.software_version = "0.1.0",
                         .configuration = "[[axis]]\nname = \"elbow\"  # größer\n",
                         .command_line = "mwidthd --config elbow",
                         .axis_state = R"({"info": {"name": "elbow"}})"},
          .state = record::SessionState::kOpen,
          .start_wall_ns = 1'763'793'000'123'456'789,
          .start_monotonic_ns = kStartNs - 2'500'000,
          .end_wall_ns = {}};
}

std::vector<record::Marker> MakeMarkers(int64_t last_ns) {
  std::vector<record::Marker> markers;
  const auto add = [&](const std::string& kind, const std::string& label, int64_t at_percent,
                       const std::map<std::string, std::string>& metadata) {
    const int64_t time_ns = kStartNs + (last_ns - kStartNs) / 100 * at_percent + 7;
    markers.push_back({.number = markers.size() + 1,
                       .label = label,
                       .kind = kind,
                       .metadata = metadata,
                       .monotonic_ns = time_ns,
                       .error_ns = 250'001,
                       .arrival_ns = time_ns + 3'000'000,
                       .client_ns = 17 + at_percent});
  };
  add("trial_start", "reach 1", 5, {{"target_rad", "0.5"}});
  add("trial_end", "hit", 20, {{"score", "10"}});
  add("trial_start", "reach, \"2\"\n", 30, {});
  add("cue", "Ton höher\tjetzt", 35, {});
  add("trial_end", "", 50, {});
  add("", "strap moved", 60, {});
  add("trial_start", "reach 3", 90, {});
  return markers;
}

std::vector<record::Event> MakeEvents(const std::vector<exchange::Sample>& samples) {
  const auto& middle = samples[samples.size() / 2];
  return {{.number = 41,
           .kind = record::EventKind::kSessionStarted,
           .tick = samples.front().tick - 1,
           .monotonic_ns = samples.front().monotonic_ns - 400'000,
           .message = "session begun",
           .metadata = {}},
          {.number = 42,
           .kind = record::EventKind::kMassRefused,
           .tick = middle.tick,
           .monotonic_ns = middle.monotonic_ns + 11,
           .message = "a mass of -0.5 kg m² is refused:\n\"unstable\", so",
           .metadata = {{"mass", "-0.5"}, {"admitted_min", "-0.17"}}},
          {.number = 43,
           .kind = record::EventKind::kFault,
           .tick = middle.tick + 5,
           .monotonic_ns = middle.monotonic_ns + 5'000'011,
           .message = "energy excess",
           .metadata = {{"value", "0.2"}}}};
}

}  // namespace

RecordedSession MakeSession(uint64_t seed, uint64_t count, bool rotary) {
  std::mt19937_64 random(seed);
  RecordedSession session;
  session.info = MakeInfo(rotary);
  session.samples = MakeSamples(random, count, session.info.axis);
  session.markers = MakeMarkers(session.samples.back().monotonic_ns);
  session.events = MakeEvents(session.samples);
  session.steps = {
      {.monotonic_ns = session.samples[count / 3].monotonic_ns,
       .offset_ns = session.info.start_wall_ns - session.info.start_monotonic_ns + 3'600'000'000'000}};
  return session;
}

void Write(const RecordedSession& session, const std::filesystem::path& file, bool end) {
  record::SessionFile out(file, session.info);
  for (size_t begin = 0; begin < session.samples.size(); begin += 100) {
    const size_t count = std::min<size_t>(100, session.samples.size() - begin);
    out.Append(std::span(session.samples).subspan(begin, count), "the disk was slow");
    out.Commit(record::Durability::kProcess);
  }
  for (const auto& event : session.events) {
    out.Add(event);
  }
  for (const auto& marker : session.markers) {
    out.Add(marker);
  }
  for (const auto& step : session.steps) {
    out.Add(step);
  }
  out.Commit(record::Durability::kProcess);
  if (!end) {
    return;
  }
  out.End(record::SessionState::kEnded, session.info.start_wall_ns + 60'000'000'000);
}

}  // namespace mwidth::testing
