// The session as a whole: what happened in words, and at a glance.
#include <algorithm>

#include "client/cli/session/display.h"
#include "client/cli/session/html.h"
#include "client/cli/session/page.h"
#include "server/record/export/columns.h"

namespace mwidth::cli::session {
namespace {

std::string Paragraph(const std::string& text, bool warns = false) {
  return std::string(warns ? "<p class=\"warn\">" : "<p>") + text + "</p>\n";
}

std::string Ending(const record::SessionInfo& info) {
  switch (info.state) {
    case record::SessionState::kEnded:
      return "";
    case record::SessionState::kOpen:
      return Paragraph(
          "The session has not been ended: its server still records it, or died. This is what "
          "is on the disk so far.",
          true);
    case record::SessionState::kRecovered:
      return Paragraph(
          "The session was recovered: its server died or lost its disk, and what it had "
          "written until then is here.",
          true);
  }
  return "";
}

std::string Completeness(const Analysis& analysis) {
  uint64_t missed = 0;
  uint64_t lost = 0;
  for (const record::Gap& gap : analysis.gaps) {
    missed += gap.missed_ticks;
    lost += gap.lost_ticks;
  }
  std::string text;
  if (missed == 0 && lost == 0) {
    text += Paragraph("Every tick has its sample.");
  }
  if (missed > 0) {
    text += Paragraph(Counted(missed, "tick") + " never ran, because the computer was late.");
  }
  if (lost > 0) {
    text += Paragraph(Counted(lost, "sample") + (lost == 1 ? " was" : " were") +
                          " lost on the way to the file or within it.",
                      true);
  }
  if (!analysis.damaged.empty()) {
    text += Paragraph(Counted(analysis.damaged.size(), "block") +
                          " of the file cannot be trusted, and left out: see the gaps.",
                      true);
  }
  if (const uint64_t stale = analysis.overview.stale_ticks(); stale > 0) {
    text += Paragraph("In " + Counted(stale, "tick") + " the drive did not tell its position.");
  }
  return text;
}

uint64_t CountOf(const Analysis& analysis, record::EventKind kind) {
  return static_cast<uint64_t>(
      std::count_if(analysis.events.begin(), analysis.events.end(),
                    [kind](const record::Event& event) { return event.kind == kind; }));
}

std::string Course(const Analysis& analysis) {
  using record::EventKind;
  std::string text;
  for (const auto& [kind, noun, warns] :
       {std::tuple{EventKind::kFault, "fault", true}, {EventKind::kEmergencyStop, "emergency stop", true}}) {
    if (const uint64_t count = CountOf(analysis, kind); count > 0) {
      text += Paragraph(Counted(count, noun) + ": see the <a href=\"#log\">log</a>.", warns);
    }
  }
  const uint64_t set = CountOf(analysis, EventKind::kMassSet);
  const uint64_t refused = CountOf(analysis, EventKind::kMassRefused);
  if (set + refused > 0) {
    text += Paragraph(Counted(set, "mass request") + " admitted, " +
                      (refused > 0 ? std::to_string(refused) : "none") + " refused.");
  }
  const Overview& overview = analysis.overview;
  if (overview.saturated_ticks() > 0) {
    text += Paragraph("The force was cut at its limit in " + Counted(overview.saturated_ticks(), "tick") +
                      ": there the person felt less than the commanded mass.");
  }
  if (overview.slew_limited_ticks() > 0) {
    text += Paragraph("The force was kept from changing as fast as the mass asked for in " +
                      Counted(overview.slew_limited_ticks(), "tick") + ".");
  }
  return text;
}

std::string Found(const Analysis& analysis) {
  std::size_t movements = 0;
  for (const TrialResult& trial : analysis.trials) {
    movements += trial.movements.found.size();
  }
  if (analysis.trials.empty()) {
    return Paragraph("There is no trial and no time of rendering to judge.");
  }
  return Paragraph(Counted(analysis.trials.size(), analysis.marked_trials ? "trial" : "time") +
                   (analysis.marked_trials ? ", as the study marked them" : " of rendering under one mass") +
                   ", with " + Counted(movements, "movement") + ".");
}

std::string Row(const std::string& name, const std::string& value) {
  return value.empty() ? "" : "<tr><th scope=\"row\">" + name + "</th><td>" + value + "</td></tr>\n";
}

std::string Who(const record::SessionInfo& info) {
  const record::SessionLabels& labels = info.labels;
  std::string rows = Row("Subject", Escape(labels.subject)) + Row("Visit", Escape(labels.visit)) +
                     Row("Task", Escape(labels.task)) + Row("Run", std::to_string(labels.run)) +
                     Row("Run by", Escape(labels.operator_name)) +
                     Row("Began", Escape(UtcText(info.start_wall_ns))) +
                     Row("Ended", info.end_wall_ns ? Escape(UtcText(*info.end_wall_ns)) : "");
  for (const auto& [key, value] : labels.metadata) {
    rows += Row(Escape(key), Escape(value));
  }
  return "<table class=\"facts\"><tbody>\n" + rows +
         Row("Software", "mwidthd " + Escape(info.provenance.software_version)) + "</tbody></table>\n";
}

Picture OverviewPicture(const Analysis& analysis) {
  const Overview& overview = analysis.overview;
  const record::SessionAxis& axis = analysis.info.axis;
  const Display& display = DisplayOf(axis.rotary);
  std::vector<Point> position = overview.Position();
  for (Point& point : position) {
    point.y *= display.scale;
  }
  Picture picture{.title = "Position, force and mass over the whole session",
                  .x_label = "time from the session's start, s",
                  .x_max = overview.length_s(),
                  .panels = {{.y_label = std::string("position, ") + display.position,
                              .curves = {{"position", std::move(position)}},
                              .least_span = 20 * axis.position_quantum * display.scale},
                             {.y_label = std::string("force, ") + display.force,
                              .curves = {{"force", overview.Force()}},
                              .levels = {{"zero", 0, ""}},
                              .height = 90,
                              .least_span = 20 * axis.force_quantum},
                             {.y_label = std::string("mass, ") + display.mass,
                              .curves = {{"mass", overview.Mass()}},
                              .levels = {{"zero", 0, ""}},
                              .height = 90}}};
  for (const Overview::StateSpan& span : overview.states()) {
    if (span.state == exchange::State::kRendering || span.state == exchange::State::kFault) {
      const std::string word(record::StateWord(span.state));
      picture.bands.push_back({word, span.from_s, span.to_s, word});
    }
  }
  const auto second_of = [&](uint64_t tick) {
    return (static_cast<double>(tick) - static_cast<double>(analysis.info.first_tick)) * axis.period_s;
  };
  for (const record::Gap& gap : analysis.gaps) {
    if (gap.before_tick > gap.after_tick) {
      picture.bands.push_back({"gap", second_of(gap.after_tick), second_of(gap.before_tick), "gap"});
    }
  }
  for (std::size_t i = 0; i < analysis.trials.size(); ++i) {
    picture.marks.push_back({"moment", analysis.trials[i].start_s, std::to_string(i + 1)});
  }
  for (const record::Event& event : analysis.events) {
    if (event.kind == record::EventKind::kFault || event.kind == record::EventKind::kEmergencyStop) {
      picture.marks.push_back({"fault-moment", second_of(event.tick), "fault"});
    }
  }
  std::stable_sort(picture.marks.begin(), picture.marks.end(),
                   [](const Mark& a, const Mark& b) { return a.x < b.x; });
  return picture;
}

std::string StateTable(const Analysis& analysis) {
  std::string rows;
  for (std::size_t i = 0; i < analysis.overview.state_ticks().size(); ++i) {
    const uint64_t ticks = analysis.overview.state_ticks()[i];
    if (ticks > 0) {
      rows += Row(std::string(record::StateWord(static_cast<exchange::State>(i))),
                  Fixed(static_cast<double>(ticks) * analysis.info.axis.period_s, 2) + " s");
    }
  }
  return "<table class=\"facts\"><tbody>\n" + rows + "</tbody></table>\n";
}

std::string GapTable(const Analysis& analysis) {
  if (analysis.gaps.empty()) {
    return {};
  }
  constexpr std::size_t kMost = 100;
  std::string rows;
  for (std::size_t i = 0; i < std::min(kMost, analysis.gaps.size()); ++i) {
    const record::Gap& gap = analysis.gaps[i];
    rows += "<tr><td>" + std::to_string(gap.after_tick) + "</td><td>" +
            (gap.before_tick > 0 ? std::to_string(gap.before_tick) : "the end") + "</td><td>" +
            std::to_string(gap.missed_ticks) + "</td><td>" + std::to_string(gap.lost_ticks) +
            "</td><td class=\"text\">" + Escape(gap.reason) + "</td></tr>\n";
  }
  std::string more;
  if (analysis.gaps.size() > kMost) {
    more = "<p class=\"note\">And " + Counted(analysis.gaps.size() - kMost, "gap") + " more.</p>\n";
  }
  return "<h3>Gaps</h3>\n<div class=\"wide\"><table><thead><tr><th scope=\"col\">After tick</th>"
         "<th scope=\"col\">Before tick</th><th scope=\"col\">Never ran</th><th scope=\"col\">Lost</th>"
         "<th class=\"text\" scope=\"col\">Why</th></tr></thead><tbody>\n" +
         rows + "</tbody></table></div>\n" + more;
}

}  // namespace

std::string Summary(const Analysis& analysis) {
  const record::SessionInfo& info = analysis.info;
  const double seconds = static_cast<double>(analysis.overview.samples()) * info.axis.period_s;
  return "<section id=\"summary\">\n" + Ending(info) +
         Paragraph(Counted(analysis.overview.samples(), "sample") + " at " +
                   Significant(1 / info.axis.period_s, 6) + " Hz: " + Fixed(seconds, 1) + " s of the " +
                   (info.axis.rotary ? "joint" : "slide") + " “" + Escape(info.axis.name) + "”" +
                   (analysis.facts.simulated.value_or(false) ? ", which was simulated" : "") + ".") +
         Found(analysis) + Completeness(analysis) + Course(analysis) + Who(info) + "</section>\n";
}

std::string OverviewSection(const Analysis& analysis) {
  if (analysis.overview.samples() == 0) {
    return {};
  }
  return "<section id=\"overview\"><h2>The whole session</h2>\n" + Svg(OverviewPicture(analysis)) +
         "<p class=\"note\">Green: rendering. Orange: fault, or a gap. Dotted lines: where trials begin. "
         "What is shown of each instant is the least and the largest value around it, of the force as it was "
         "commanded: with the noise of the encoder's counts, which trials are shown without.</p>\n" +
         StateTable(analysis) + GapTable(analysis) + "</section>\n";
}

}  // namespace mwidth::cli::session
