#include "client/cli/session/page.h"

#include "client/cli/session/display.h"
#include "client/cli/session/html.h"
#include "client/cli/session/page_style.h"

namespace mwidth::cli::session {
namespace {

std::string Title(const record::SessionInfo& info) {
  const record::SessionLabels& labels = info.labels;
  std::string title = "Subject " + labels.subject;
  if (!labels.visit.empty()) {
    title += ", visit " + labels.visit;
  }
  return title + ", task " + labels.task + ", run " + std::to_string(labels.run);
}

void WriteTrials(const Analysis& analysis, std::ostream& out) {
  if (analysis.trials.empty()) {
    return;
  }
  out << "<section id=\"trials\"><h2>" << (analysis.marked_trials ? "Trials" : "Times of rendering")
      << "</h2>\n";
  for (std::size_t i = 0; i < analysis.trials.size(); ++i) {
    out << TrialPart(analysis, i);
  }
  out << "</section>\n";
}

}  // namespace

void WritePage(const Analysis& analysis, std::ostream& out) {
  const std::string title = Escape(Title(analysis.info));
  // The policy makes "no script, no network" the browser's business, whatever a label might try.
  out << "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
         "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src "
         "'unsafe-inline'; img-src data:\">\n"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
         // No request for an icon.
         "<link rel=\"icon\" href=\"data:,\">\n<title>"
      << title << "</title>\n<style>" << kPageStyle << "</style>\n</head>\n<body>\n<header><h1>" << title
      << "</h1>\n<p>" << Escape(UtcText(analysis.info.start_wall_ns)) << " · axis "
      << Escape(analysis.info.axis.name) << " · session " << Escape(analysis.info.id)
      << "</p></header>\n<main>\n";
  out << Summary(analysis) << MassSection(analysis) << MovementSection(analysis) << OverviewSection(analysis);
  WriteTrials(analysis, out);
  out << LogSection(analysis) << AxisSection(analysis) << DefinitionSection()
      << ConfigurationSection(analysis) << "</main>\n</body>\n</html>\n";
}

std::string FilterWords(const exchange::Filter& filter) {
  const auto kind = static_cast<model::EstimatorKind>(filter.estimator);
  const std::string name = model::Name(kind);
  return kind == model::EstimatorKind::kAccelerometer ? name
                                                      : name + ", " + Significant(filter.cutoff_hz) + " Hz";
}

std::string TrialName(const Analysis& analysis, std::size_t index) {
  const TrialResult& trial = analysis.trials[index];
  return trial.label.empty() ? (trial.marked ? "Trial " : "Part ") + std::to_string(index + 1) : trial.label;
}

std::string ColourOf(const Analysis& analysis, double mass, const exchange::Filter& filter) {
  constexpr std::size_t kColours = 7;
  for (std::size_t i = 0; i < analysis.groups.size(); ++i) {
    if (analysis.groups[i].mass == mass && analysis.groups[i].filter == filter) {
      return "c" + std::to_string(i % kColours);
    }
  }
  return "c0";
}

}  // namespace mwidth::cli::session
