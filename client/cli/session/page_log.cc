// What stands behind the results: the axis, the log, the definitions, the configuration.
#include <algorithm>
#include <cmath>

#include "client/cli/session/display.h"
#include "client/cli/session/html.h"
#include "client/cli/session/page.h"

namespace mwidth::cli::session {
namespace {

constexpr double kNsPerS = 1e9;

std::string Row(const std::string& name, const std::string& value) {
  return value.empty() ? "" : "<tr><th scope=\"row\">" + name + "</th><td>" + value + "</td></tr>\n";
}

const char* KindWord(record::EventKind kind) {
  switch (kind) {
    case record::EventKind::kUnknown:
      break;
    case record::EventKind::kStateChanged:
      return "state";
    case record::EventKind::kFault:
      return "fault";
    case record::EventKind::kEmergencyStop:
      return "emergency stop";
    case record::EventKind::kControlAcquired:
    case record::EventKind::kControlReleased:
      return "control";
    case record::EventKind::kMassSet:
      return "mass set";
    case record::EventKind::kMassRefused:
      return "mass refused";
    case record::EventKind::kFilterSet:
      return "filter set";
    case record::EventKind::kFilterRefused:
      return "filter refused";
    case record::EventKind::kTicksMissed:
    case record::EventKind::kSamplesDropped:
      return "gap";
    case record::EventKind::kSessionStarted:
    case record::EventKind::kSessionEnded:
      return "session";
    case record::EventKind::kStorageFailed:
    case record::EventKind::kStorageRestored:
      return "storage";
    case record::EventKind::kWallClockStepped:
      return "clock";
    case record::EventKind::kServerStopping:
      return "server";
  }
  return "event";
}

struct Entry {
  int64_t monotonic_ns;
  std::string kind;
  std::string text;
};

std::string MarkerText(const record::Marker& marker) {
  std::string text = Escape(marker.label);
  for (const auto& [key, value] : marker.metadata) {
    text += (text.empty() ? "" : "; ") + Escape(key) + ": " + Escape(value);
  }
  if (marker.error_ns > 0) {
    text += " <small>(± " + Significant(static_cast<double>(marker.error_ns) / 1e6, 2) + " ms)</small>";
  }
  return text;
}

std::vector<Entry> Entries(const Analysis& analysis) {
  std::vector<Entry> entries;
  for (const record::Event& event : analysis.events) {
    entries.push_back({event.monotonic_ns, KindWord(event.kind), Escape(event.message)});
  }
  for (const record::Marker& marker : analysis.markers) {
    entries.push_back({marker.monotonic_ns, "marker" + (marker.kind.empty() ? "" : " " + Escape(marker.kind)),
                       MarkerText(marker)});
  }
  for (const record::WallClockStep& step : analysis.wall_clock_steps) {
    entries.push_back({step.monotonic_ns, "clock", "The wall clock was set."});
  }
  std::stable_sort(entries.begin(), entries.end(),
                   [](const Entry& a, const Entry& b) { return a.monotonic_ns < b.monotonic_ns; });
  return entries;
}

std::string LoopRows(const model::LoopParameters& loop, const Display& display) {
  const auto with = [](double value, const char* unit) { return Significant(value) + " " + unit; };
  return Row("Device",
             with(loop.device_mass, display.mass) + ", " + with(loop.device_damping, display.damping)) +
         Row("Hand, nominal", with(loop.hand_mass, display.mass) + ", " +
                                  with(loop.hand_damping, display.damping) + ", " +
                                  with(loop.hand_stiffness, display.stiffness)) +
         Row("Loop delay", with(loop.delay_s * 1e3, "ms")) +
         Row("Filter cut-off at the start", with(loop.cutoff_hz, "Hz"));
}

std::string RangeRow(const std::string& name, const std::optional<MassRange>& range, const Display& display) {
  return range ? Row(name, Significant(range->min) + " to " + Significant(range->max) + " " + display.mass)
               : "";
}

constexpr const char* kDefinitions = R"html(<section id="definitions"><h2>Definitions</h2>
<p>Velocity and acceleration come from the recorded positions by a symmetric filter (Savitzky–Golay, fifth order,
61 ms), which shifts nothing in time; forces pass through the same filter. Up to 10 ms without a position are bridged by a
straight line.</p>
<dl>
<dt>Target</dt><dd>From the trial's metadata: <code>target_deg</code>, <code>target_rad</code>, <code>target_m</code>, or
<code>target</code> in rad or m; <code>start_deg</code> and so on say where the way begins, otherwise it is the position
at the trial's start. Without a target, movements are what lies between two rests, and where they come to rest stands for
it; those that come back by more than half are left out.</dd>
<dt>Onset, end, movement time</dt><dd>Onset: the last moment before the middle of the way with less than 5 % of the
trial's largest velocity toward the target. End: from there on slower than that for 0.1 s.</dd>
<dt>Overshoot</dt><dd>The farthest position beyond the target, in parts of the way from start to target. Negative: the
movement stayed short of it. It is looked for until the movement has rested for 0.1 s, and so is the error at the
end.</dd>
<dt>Perceived mass</dt><dd>The mass that explains the hand's force best by acceleration alone, in the least-squares sense,
from onset to end: m̂ = Σ x″F<sub>h</sub> / Σ x″², with F<sub>h</sub> = m x″ + b x′ + F<sub>a</sub>, the device's mass m and
damping b, and the rendered force F<sub>a</sub> (Colonnese and Okamura, RSS 2012, eqs. 1 and 21 to 23).</dd>
<dt>Its error</dt><dd>(m̂ − (m + M)) / (m + M), eq. 24. Negative: it felt lighter than commanded.</dd>
<dt>Expected of this motion</dt><dd>The same error where the force is what the loop's own filter makes of the smooth
motion. What the measured error differs by is the work of the encoder's counts, of limits and of silences; what both have
in common is the filter's lag. Not computed with an accelerometer.</dd>
<dt>Expected of 0.1–5 Hz</dt><dd>The same error for a slow chirp over this band with the nominal hand, from the model
(the paper's Figure 9): faster than most reaches, so usually larger.</dd>
<dt>Margins</dt><dd>How far the loop was from instability when the mass was admitted: by how much the mass may grow
(gain), the phase may turn, the loop may be later (delay), and how near its frequency response comes to −1
(modulus).</dd>
</dl></section>
)html";

}  // namespace

std::string LogSection(const Analysis& analysis) {
  const std::vector<Entry> entries = Entries(analysis);
  if (entries.empty()) {
    return {};
  }
  std::string section =
      "<section id=\"log\"><h2>Log</h2>\n<div class=\"wide\"><table><thead><tr><th scope=\"col\">s</th>"
      "<th class=\"text\" scope=\"col\">What</th><th class=\"text\" "
      "scope=\"col\"></th></tr></thead><tbody>\n";
  for (const Entry& entry : entries) {
    const double second =
        static_cast<double>(entry.monotonic_ns - analysis.info.start_monotonic_ns) / kNsPerS;
    section += "<tr><td>" + Fixed(second, 3) + "</td><td class=\"text\">" + entry.kind +
               "</td><td class=\"text\">" + entry.text + "</td></tr>\n";
  }
  return section + "</tbody></table></div></section>\n";
}

std::string AxisSection(const Analysis& analysis) {
  const record::SessionAxis& axis = analysis.info.axis;
  const Display& display = DisplayOf(axis.rotary);
  const AxisFacts& facts = analysis.facts;
  std::string section =
      "<section id=\"axis\"><h2>The axis and its loop</h2>\n<table class=\"facts\"><tbody>\n";
  section +=
      Row("Axis", Escape(axis.name) + (axis.rotary ? ", rotary" : ", linear")) +
      Row("Sample period", Significant(axis.period_s * 1e3) + " ms") +
      (facts.loop ? LoopRows(*facts.loop, display) : "") +
      Row("One count of position",
          Significant(axis.position_quantum * display.scale) + " " + display.position) +
      Row("One count of force", Significant(axis.force_quantum) + " " + display.force) +
      Row("Force limit", Significant(axis.force_limit) + " " + display.force) +
      (std::isfinite(axis.force_slew_limit)
           ? Row("Limit on its change", Significant(axis.force_slew_limit) + " " + display.force + "/s")
           : "") +
      Row("Largest force commanded", Significant(analysis.overview.largest_force()) + " " + display.force);
  section += RangeRow("Admitted masses at the start", facts.admitted, display) +
             RangeRow("Stable with every hand allowed for", facts.robust, display) +
             RangeRow("Stable with the nominal hand", facts.nominal, display) +
             (facts.required_gain_margin_db
                  ? Row("Gain margin kept", Significant(facts.required_gain_margin_db) + " dB")
                  : "");
  return section + "</tbody></table></section>\n";
}

std::string DefinitionSection() { return kDefinitions; }

std::string ConfigurationSection(const Analysis& analysis) {
  const record::SessionProvenance& provenance = analysis.info.provenance;
  if (provenance.configuration.empty() && provenance.command_line.empty()) {
    return {};
  }
  return "<section id=\"configuration\"><h2>Configuration</h2>\n<details><summary>As the server read "
         "it</summary>"
         "<pre>" +
         Escape(provenance.command_line) + "\n\n" + Escape(provenance.configuration) +
         "</pre></details></section>\n";
}

}  // namespace mwidth::cli::session
