// Estimators of acceleration by the names that configurations have for them.
#pragma once

#include <mwidth/v1/stability.pb.h>

#include <string>
#include <vector>

namespace mwidth::cli {

/// "late-filtered-difference" and so on: model::Name of the same estimator. "unspecified" for none, and a
/// number for one that only a newer server knows.
std::string EstimatorName(v1::EstimatorKind estimator);

/// The names of all estimators, in the order of the API.
std::vector<std::string> EstimatorNames();

/// The estimator of a name; unspecified for any other text.
v1::EstimatorKind EstimatorNamed(const std::string& name);

}  // namespace mwidth::cli
