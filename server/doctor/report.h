// Findings for a person and for a program.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "server/doctor/finding.h"

namespace mwidth::doctor {

/// "ok", "warning" or "problem".
std::string VerdictName(Verdict verdict);

std::size_t Count(const std::vector<Finding>& findings, Verdict verdict);

/// One finding a line, its advice below it, and a sum.
std::string TextReport(const std::vector<Finding>& findings);

/// {"findings": [{"subject", "verdict", "seen", "advice"}, ...], "problems": n, "warnings": n}
std::string JsonReport(const std::vector<Finding>& findings);

}  // namespace mwidth::doctor
