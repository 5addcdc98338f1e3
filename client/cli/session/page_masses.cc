// The tables over masses and over movements.
#include <algorithm>
#include <cmath>

#include "client/cli/session/display.h"
#include "client/cli/session/html.h"
#include "client/cli/session/page.h"

namespace mwidth::cli::session {
namespace {

constexpr double kPercent = 100;

std::string Cell(const std::string& content) { return "<td>" + content + "</td>"; }

// "12.3 ± 0.4".
std::string SpreadCell(const Spread& spread, double scale, int digits, bool sign = false) {
  if (!spread.mean) {
    return Cell(Fixed({}, 0));
  }
  std::string text = Fixed(*spread.mean * scale, digits, sign);
  if (spread.deviation) {
    text += "<br><small>± " + Fixed(*spread.deviation * scale, digits) + "</small>";
  }
  return Cell(text);
}

// Places after the point that show four digits of a mass.
int MassDigits(const std::optional<double>& mass) {
  const double size = std::abs(mass.value_or(0));
  return size > 0 ? std::clamp(3 - static_cast<int>(std::floor(std::log10(size))), 0, 12) : 4;
}

std::string MassCell(const Spread& spread) { return SpreadCell(spread, 1, MassDigits(spread.mean)); }

std::optional<double> DeviceMass(const Analysis& analysis) {
  return analysis.facts.loop ? std::optional(analysis.facts.loop->device_mass) : std::nullopt;
}

std::string GroupRow(const Analysis& analysis, const MassGroup& group) {
  const Display& display = DisplayOf(analysis.info.axis.rotary);
  const auto device = DeviceMass(analysis);
  return R"(<tr><th class="text" scope="row"><span class="key )" +
         ColourOf(analysis, group.mass, group.filter) + "\"></span> " + Significant(group.mass) +
         "<br><small>" + Escape(FilterWords(group.filter)) + "</small></th>" +
         Cell(std::to_string(group.movements)) + SpreadCell(group.overshoot, kPercent, 1, true) +
         SpreadCell(group.movement_time_s, 1, 3) +
         SpreadCell(group.peak_velocity, display.scale, display.position_digits) +
         SpreadCell(group.peak_force, 1, 3) +
         Cell(Significant(device ? std::optional(*device + group.mass) : std::nullopt)) +
         MassCell(group.perceived_mass) + SpreadCell(group.error, kPercent, 1, true) +
         SpreadCell(group.expected_error, kPercent, 1, true) +
         Cell(Fixed(group.chirp_error ? std::optional(*group.chirp_error * kPercent) : std::nullopt, 1,
                    true)) +
         "</tr>\n";
}

std::string Heading(const std::string& name, const std::string& unit) {
  return "<th scope=\"col\">" + name + (unit.empty() ? "" : "<br><small>" + unit + "</small>") + "</th>";
}

Picture OverlayOf(const Analysis& analysis) {
  Picture picture{.title = "Movements under each mass, laid over each other at their onsets",
                  .x_label = "time from movement onset, s",
                  .panels = {{.y_label = "way to the target, %",
                              .curves = {},
                              .levels = {{"target", kPercent, "target"}, {"zero", 0, ""}},
                              .height = 280}}};
  picture.x_max = 0.1;
  for (const MovementCurve& curve : analysis.curves) {
    Curve line{.css_class = ColourOf(analysis, curve.mass, curve.filter), .points = curve.way};
    for (Point& point : line.points) {
      point.y *= kPercent;
    }
    picture.x_min = std::min(picture.x_min, line.points.front().x);
    picture.x_max = std::max(picture.x_max, line.points.back().x);
    picture.panels.front().curves.push_back(std::move(line));
  }
  return picture;
}

std::string MovementRow(const Analysis& analysis, std::size_t trial_index, std::size_t number) {
  const Display& display = DisplayOf(analysis.info.axis.rotary);
  const TrialResult& trial = analysis.trials[trial_index];
  const Movement& movement = trial.movements.found[number];
  const auto percent = [](const std::optional<double>& share) {
    return Cell(Fixed(share ? std::optional(*share * kPercent) : std::nullopt, 1, true));
  };
  const auto position = [&display](double value) {
    return Cell(Fixed(value * display.scale, display.position_digits));
  };
  const bool several = trial.movements.found.size() > 1;
  return R"(<tr><th class="text" scope="row"><a href="#trial-)" + std::to_string(trial_index + 1) + "\">" +
         Escape(TrialName(analysis, trial_index)) + "</a>" +
         (several ? " <small>movement " + std::to_string(number + 1) + "</small>" : "") + "</th>" +
         Cell(movement.mass ? Significant(movement.mass) : "changed") + position(movement.start) +
         Cell(Fixed(movement.target * display.scale, display.position_digits) +
              (movement.target_given ? "" : "*")) +
         Cell(Fixed(movement.overshoot * kPercent, 1, true) + (movement.turned ? "" : "‡")) +
         position(movement.end_error) +
         Cell(Fixed(movement.movement_time_s, 3) + (movement.came_to_rest ? "" : "†")) +
         Cell(Fixed(movement.time_to_peak_s, 3)) + position(movement.peak_velocity) +
         Cell(Fixed(movement.peak_force, 3)) + Cell(Fixed(movement.rms_force, 3)) +
         Cell(Fixed(movement.perceived_mass, MassDigits(movement.perceived_mass))) + percent(movement.error) +
         percent(movement.expected_error) + "</tr>\n";
}

// Marks that the rows of a table need explained.
std::string Footnotes(const Analysis& analysis) {
  bool guessed = false;
  bool restless = false;
  bool unturned = false;
  for (const TrialResult& trial : analysis.trials) {
    for (const Movement& movement : trial.movements.found) {
      guessed = guessed || !movement.target_given;
      restless = restless || !movement.came_to_rest;
      unturned = unturned || !movement.turned;
    }
  }
  std::string notes;
  if (guessed) {
    notes +=
        "<p class=\"note\">* No target was given with the trial: the position in which the movement "
        "came to rest stands for it, so that there is no error at the end.</p>\n";
  }
  if (restless) {
    notes +=
        "<p class=\"note\">† Did not come to rest before the trial, or the next movement, cut it "
        "off: it counts for no mean movement time.</p>\n";
  }
  if (unturned) {
    notes += "<p class=\"note\">‡ Cut off before it turned: it counts for no mean overshoot.</p>\n";
  }
  return notes;
}

}  // namespace

std::string MassSection(const Analysis& analysis) {
  if (analysis.groups.empty()) {
    return {};
  }
  const Display& display = DisplayOf(analysis.info.axis.rotary);
  std::string section =
      "<section id=\"masses\"><h2>By commanded mass</h2>\n<div class=\"wide\"><table>\n<thead><tr>"
      "<th class=\"text\" scope=\"col\">Commanded mass M<br><small>" +
      std::string(display.mass) + "</small></th>" + Heading("Move&shy;ments", "") +
      Heading("Overshoot", "% of the way") + Heading("Movement time", "s") +
      Heading("Peak velocity", display.velocity) + Heading("Peak force", display.force) +
      Heading("Device + M", display.mass) + Heading("Perceived mass", display.mass) +
      Heading("Its error", "%") + Heading("Expected of this motion", "%") +
      Heading("Expected of 0.1–5 Hz", "%") + "</tr></thead>\n<tbody>\n";
  for (const MassGroup& group : analysis.groups) {
    section += GroupRow(analysis, group);
  }
  section +=
      "</tbody></table></div>\n<p class=\"note\">Mean ± standard deviation. Movements during which "
      "the mass changed are left out here. The last three columns are explained under "
      "<a href=\"#definitions\">definitions</a>.</p>\n";
  if (!DeviceMass(analysis)) {
    section +=
        "<p class=\"warn\">The session does not tell the device's mass, so what was perceived cannot "
        "be computed.</p>\n";
  }
  if (!analysis.curves.empty()) {
    section += "<figure>" + Svg(OverlayOf(analysis)) +
               "<figcaption class=\"note\">Colours as in the table; at most 20 movements of each "
               "mass.</figcaption></figure>\n";
  }
  return section + "</section>\n";
}

std::string MovementSection(const Analysis& analysis) {
  std::string rows;
  for (std::size_t i = 0; i < analysis.trials.size(); ++i) {
    for (std::size_t k = 0; k < analysis.trials[i].movements.found.size(); ++k) {
      rows += MovementRow(analysis, i, k);
    }
  }
  if (rows.empty()) {
    return {};
  }
  const Display& display = DisplayOf(analysis.info.axis.rotary);
  return "<section id=\"movements\"><h2>Every movement</h2>\n<div class=\"wide\"><table>\n<thead><tr>"
         "<th class=\"text\" scope=\"col\">Trial</th>" +
         Heading("M", display.mass) + Heading("From", display.position) +
         Heading("Target", display.position) + Heading("Over&shy;shoot", "%") +
         Heading("Error at end", display.position) + Heading("Move&shy;ment time", "s") +
         Heading("Time to peak", "s") + Heading("Peak velocity", display.velocity) +
         Heading("Peak force", display.force) + Heading("RMS force", display.force) +
         Heading("Perceived mass", display.mass) + Heading("Its error", "%") + Heading("Expected", "%") +
         "</tr></thead>\n<tbody>\n" + rows + "</tbody></table></div>\n" + Footnotes(analysis) +
         "</section>\n";
}

}  // namespace mwidth::cli::session
