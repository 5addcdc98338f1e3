#include "client/cli/drive/probe.h"

#include <algorithm>
#include <variant>

#include "device/canopen/survey.h"
#include "device/modbus/survey.h"
#include "server/config.h"
#include "server/drive_address.h"

namespace mwidth::drive {
namespace {

using server::ConfigError;

server::AxisConfig FindAxis(const std::string& name_or_file, const std::string& axis) {
  server::Config config = server::LoadConfig(server::FindConfig(name_or_file));
  if (axis.empty() && config.axes.size() > 1) {
    throw ConfigError(name_or_file + ": there are several axes; name one with --axis");
  }
  const auto found = std::find_if(config.axes.begin(), config.axes.end(), [&axis](const auto& candidate) {
    return axis.empty() || candidate.name == axis;
  });
  if (found == config.axes.end()) {
    throw ConfigError(name_or_file + ": no axis is called \"" + axis + "\"");
  }
  return std::move(*found);
}

device::SurveyReport SurveyOf(const server::AxisConfig& axis) {
  if (const auto* modbus = std::get_if<device::modbus::ModbusDriveConfig>(&axis.drive.behind)) {
    return device::modbus::Survey(*modbus, axis.kind);
  }
  if (const auto* canopen = std::get_if<device::canopen::CanopenDriveConfig>(&axis.drive.behind)) {
    return device::canopen::Survey(*canopen, axis.kind);
  }
  throw ConfigError("axis " + axis.name + " has a simulated drive: there is nothing to look at");
}

}  // namespace

Probe ProbeDrive(const std::string& name_or_file, const std::string& axis, const std::string& address) {
  server::AxisConfig config = FindAxis(name_or_file, axis);
  if (!address.empty()) {
    server::PlaceDrive(address, config);
  }
  Probe probe{.axis = config.name, .findings = {}};
  for (device::SurveyFinding& finding : SurveyOf(config)) {
    probe.findings.push_back(
        {std::move(finding.subject), std::move(finding.seen), std::move(finding.advice)});
  }
  return probe;
}

}  // namespace mwidth::drive
