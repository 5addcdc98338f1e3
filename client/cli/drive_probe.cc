#include <algorithm>
#include <iomanip>
#include <iostream>
#include <nlohmann/json.hpp>

#include "client/cli/commands.h"
#include "client/cli/drive/probe.h"

namespace mwidth::cli {
namespace {

void PrintJson(const drive::Probe& probe, bool ready) {
  nlohmann::ordered_json json{
      {"axis", probe.axis}, {"ready", ready}, {"findings", nlohmann::ordered_json::array()}};
  for (const drive::Finding& finding : probe.findings) {
    json["findings"].push_back(
        {{"subject", finding.subject}, {"seen", finding.seen}, {"advice", finding.advice}});
  }
  std::cout << json.dump(2) << "\n";
}

void PrintText(const drive::Probe& probe, bool ready) {
  std::size_t width = 0;
  for (const drive::Finding& finding : probe.findings) {
    width = std::max(width, finding.subject.size());
  }
  std::cout << "The drive of " << probe.axis << ", which was only read:\n";
  for (const drive::Finding& finding : probe.findings) {
    std::cout << "  " << std::left << std::setw(static_cast<int>(width)) << finding.subject << "  "
              << finding.seen << "\n";
    if (!finding.advice.empty()) {
      std::cout << std::string(width + 4, ' ') << finding.advice << "\n";
    }
  }
  std::cout << (ready ? "It can be armed." : "It is not ready to be armed.") << "\n";
}

}  // namespace

int RunDriveProbe(const CommandLine& line) {
  const drive::Probe probe = drive::ProbeDrive(line.config, line.axis, line.drive);
  const bool ready = std::all_of(probe.findings.begin(), probe.findings.end(),
                                 [](const auto& finding) { return finding.advice.empty(); });
  if (line.json) {
    PrintJson(probe, ready);
  } else {
    PrintText(probe, ready);
  }
  return ready ? kDone : kRefused;
}

}  // namespace mwidth::cli
