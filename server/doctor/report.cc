#include "server/doctor/report.h"

#include <algorithm>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <sstream>

namespace mwidth::doctor {

std::string VerdictName(Verdict verdict) {
  switch (verdict) {
    case Verdict::kOk:
      return "ok";
    case Verdict::kWarning:
      return "warning";
    case Verdict::kProblem:
      return "problem";
  }
  return "";
}

std::size_t Count(const std::vector<Finding>& findings, Verdict verdict) {
  return static_cast<std::size_t>(
      std::count_if(findings.begin(), findings.end(),
                    [verdict](const Finding& finding) { return finding.verdict == verdict; }));
}

std::string TextReport(const std::vector<Finding>& findings) {
  std::ostringstream out;
  for (const Finding& finding : findings) {
    out << std::left << std::setw(9) << VerdictName(finding.verdict) << finding.subject << ": "
        << finding.seen << '\n';
    if (!finding.advice.empty()) {
      out << std::string(9, ' ') << "-> " << finding.advice << '\n';
    }
  }
  out << '\n'
      << Count(findings, Verdict::kProblem) << " problems, " << Count(findings, Verdict::kWarning)
      << " warnings\n";
  return out.str();
}

std::string JsonReport(const std::vector<Finding>& findings) {
  nlohmann::ordered_json report;
  report["findings"] = nlohmann::ordered_json::array();
  for (const Finding& finding : findings) {
    report["findings"].push_back({{"subject", finding.subject},
                                  {"verdict", VerdictName(finding.verdict)},
                                  {"seen", finding.seen},
                                  {"advice", finding.advice}});
  }
  report["problems"] = Count(findings, Verdict::kProblem);
  report["warnings"] = Count(findings, Verdict::kWarning);
  // What a host's files hold need not be text.
  return report.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace mwidth::doctor
