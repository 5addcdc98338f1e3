// One trial: its picture and its figures.
#include <algorithm>
#include <cmath>

#include "client/cli/session/display.h"
#include "client/cli/session/html.h"
#include "client/cli/session/page.h"

namespace mwidth::cli::session {
namespace {

std::vector<Point> Scaled(std::vector<Point> points, double scale) {
  for (Point& point : points) {
    point.y *= scale;
  }
  return points;
}

Picture PictureOf(const Analysis& analysis, std::size_t index) {
  const TrialResult& trial = analysis.trials[index];
  const record::SessionAxis& axis = analysis.info.axis;
  const Display& display = DisplayOf(axis.rotary);
  Panel position{.y_label = std::string("position, ") + display.position,
                 .curves = {{"position", Scaled(trial.position, display.scale)}},
                 .height = 150,
                 .least_span = 20 * axis.position_quantum * display.scale};
  if (trial.task.target) {
    position.levels.push_back({"target", *trial.task.target * display.scale, "target"});
  }
  Picture picture{.title = "Position, velocity and force of " + TrialName(analysis, index),
                  .x_label = "time from the trial's start, s",
                  .x_max = trial.position.back().x,
                  .panels = {std::move(position),
                             {.y_label = std::string("velocity, ") + display.velocity,
                              .curves = {{"velocity", Scaled(trial.velocity, display.scale)}},
                              .levels = {{"zero", 0, ""}},
                              .height = 100},
                             {.y_label = std::string("smooth force, ") + display.force,
                              .curves = {{"force", trial.force}},
                              .levels = {{"zero", 0, ""}},
                              .height = 100,
                              .least_span = 20 * axis.force_quantum}}};
  constexpr std::size_t kMostLabelled = 3;  // More would lie over each other.
  const bool labels = trial.movements.found.size() <= kMostLabelled;
  for (const Movement& movement : trial.movements.found) {
    const auto at = [&axis](std::size_t k) { return static_cast<double>(k) * axis.period_s; };
    picture.bands.push_back({"moving", at(movement.onset), at(movement.end), "movement"});
    picture.marks.push_back({"moment", at(movement.onset), labels ? "onset" : ""});
    picture.marks.push_back({"moment", at(movement.peak), labels ? "peak" : ""});
    picture.marks.push_back({"moment", at(movement.end), labels && movement.came_to_rest ? "rest" : ""});
  }
  return picture;
}

std::string Fact(const std::string& name, const std::string& value) {
  return value.empty() ? "" : "<tr><th scope=\"row\">" + name + "</th><td>" + value + "</td></tr>\n";
}

std::string RangeText(const std::optional<MassRange>& range, const Display& display) {
  return range ? Significant(range->min) + " to " + Significant(range->max) + " " + display.mass : "";
}

std::string MarginText(const MarginsInForce& margins) {
  std::string text;
  const auto add = [&text](const std::optional<double>& value, double scale, const std::string& before,
                           const std::string& unit) {
    if (value) {
      text += (text.empty() ? "" : ", ") + before + " " +
              (std::isinf(*value) ? "∞" : Significant(*value * scale, 3) + unit);
    }
  };
  add(margins.gain_db, 1, "gain", " dB");
  add(margins.phase_deg, 1, "phase", "°");
  add(margins.delay_s, 1e3, "delay", " ms");
  add(margins.modulus, 1, "modulus", "");
  return text;
}

std::string MarginFacts(const TrialResult& trial, const Display& display) {
  if (!trial.margins) {
    return Fact("M-width in force", "no mass was set before in this session: see the axis at its start");
  }
  const MarginsInForce& margins = *trial.margins;
  return Fact("Mass that was admitted", Significant(margins.mass) + " " + display.mass) +
         Fact("Margins to instability", MarginText(margins)) +
         Fact("Admitted masses then", RangeText(margins.admitted, display)) +
         Fact("Stable with every hand allowed for", RangeText(margins.robust, display)) +
         Fact("Stable with the nominal hand", RangeText(margins.nominal, display));
}

std::string ClampText(const TrialResult& trial) {
  std::string text;
  const auto add = [&text](uint64_t ticks, const std::string& what) {
    if (ticks > 0) {
      text += (text.empty() ? "" : "; ") + Counted(ticks, "tick") + what;
    }
  };
  add(trial.saturated_ticks, " at the force limit");
  add(trial.slew_limited_ticks, " at the limit on the change of force");
  add(trial.stale_ticks, " without a position");
  add(trial.not_rendering_ticks, " not rendering");
  return text;
}

std::string MetadataText(const std::map<std::string, std::string>& metadata) {
  std::string text;
  for (const auto& [key, value] : metadata) {
    text += (text.empty() ? "" : "<br>") + Escape(key) + ": " + Escape(value);
  }
  return text;
}

std::string MovementSentence(const Movement& movement, const Display& display) {
  const double way = (movement.target - movement.start) * display.scale;
  std::string text = Fixed(way, display.position_digits, true) + " " + display.position + " in " +
                     Fixed(movement.movement_time_s, 2) + " s, at most " +
                     Fixed(std::abs(movement.peak_velocity) * display.scale, 0) + " " + display.velocity +
                     ", ";
  const double percent = 100 * movement.overshoot;
  text +=
      percent >= 0 ? "overshoot " + Fixed(percent, 1) + " %" : Fixed(-percent, 1) + " % short of the target";
  if (movement.perceived_mass) {
    text += "; felt like " + Significant(movement.perceived_mass, 3) + " " + display.mass;
    if (movement.error) {
      text += " (" + Fixed(100 * *movement.error, 1, true) + " %)";
    }
  }
  return text;
}

std::string CommandedText(const TrialResult& trial, const AxisFacts& facts, const Display& display) {
  if (trial.movements.found.empty() || !trial.movements.found.front().mass) {
    return trial.movements.found.empty() ? "" : "changed during the movement";
  }
  const double mass = *trial.movements.found.front().mass;
  return Significant(mass) + " " + display.mass +
         (facts.loop ? "; with the device " + Significant(facts.loop->device_mass + mass) + " " + display.mass
                     : "");
}

std::string MovementFacts(const TrialResult& trial, const Display& display) {
  constexpr std::size_t kMost = 4;  // The rest is in the table of all movements.
  std::string facts;
  for (std::size_t k = 0; k < std::min(kMost, trial.movements.found.size()); ++k) {
    facts += Fact("Movement" + (trial.movements.found.size() > 1 ? " " + std::to_string(k + 1) : ""),
                  MovementSentence(trial.movements.found[k], display));
  }
  if (trial.movements.found.size() > kMost) {
    facts += Fact("", "and " + std::to_string(trial.movements.found.size() - kMost) + " more, in the table");
  }
  if (trial.movements.left_out > 0) {
    facts += Fact("Left out", Counted(trial.movements.left_out, "movement") +
                                  " cut off by the start or the end, or there and back");
  }
  if (trial.movements.found.empty()) {
    facts +=
        Fact("Movement", trial.not_judged.empty() ? "none found" : "not judged: " + Escape(trial.not_judged));
  }
  return facts;
}

}  // namespace

std::string TrialPart(const Analysis& analysis, std::size_t index) {
  const TrialResult& trial = analysis.trials[index];
  const Display& display = DisplayOf(analysis.info.axis.rotary);
  std::string part = R"(<div class="trial-part" id="trial-)" + std::to_string(index + 1) + "\"><h3>" +
                     Escape(TrialName(analysis, index)) + "</h3>\n<p class=\"note\">From " +
                     Fixed(trial.start_s, 2) + " s on, " + Fixed(trial.duration_s, 2) + " s" +
                     (trial.cut ? "; longer than what is judged at once, and cut" : "") + ".</p>\n";
  if (!trial.position.empty()) {
    part += Svg(PictureOf(analysis, index));
  }
  return part + "<table class=\"facts\"><tbody>\n" + MovementFacts(trial, display) +
         Fact("Commanded mass", CommandedText(trial, analysis.facts, display)) + MarginFacts(trial, display) +
         Fact("Acceleration by",
              Escape(FilterWords(trial.filter)) + (trial.more_filters ? " at first; it was changed" : "")) +
         Fact("Largest force commanded", Significant(trial.largest_force, 3) + " " + display.force) +
         Fact("Noteworthy", ClampText(trial)) + Fact("Notes of the study", MetadataText(trial.metadata)) +
         "</tbody></table></div>\n";
}

}  // namespace mwidth::cli::session
