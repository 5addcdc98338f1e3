#include "client/cli/estimator_name.h"

#include <google/protobuf/descriptor.h>

#include <string_view>

#include "client/cli/enum_words.h"

namespace mwidth::cli {
namespace {

// Calls `take` with every estimator of the API.
template <typename Take>
void ForEach(const Take& take) {
  const auto* const descriptor = v1::EstimatorKind_descriptor();
  for (int i = 0; i < descriptor->value_count(); ++i) {
    const auto estimator = static_cast<v1::EstimatorKind>(descriptor->value(i)->number());
    if (estimator != v1::ESTIMATOR_KIND_UNSPECIFIED) {
      take(estimator);
    }
  }
}

}  // namespace

std::string EstimatorName(v1::EstimatorKind estimator) {
  const auto& name = v1::EstimatorKind_Name(estimator);
  return name.empty() ? std::to_string(estimator) : EnumWords(name, "ESTIMATOR_KIND_", '-');
}

std::vector<std::string> EstimatorNames() {
  std::vector<std::string> names;
  ForEach([&](v1::EstimatorKind estimator) { names.push_back(EstimatorName(estimator)); });
  return names;
}

v1::EstimatorKind EstimatorNamed(const std::string& name) {
  auto found = v1::ESTIMATOR_KIND_UNSPECIFIED;
  ForEach([&](v1::EstimatorKind estimator) { found = EstimatorName(estimator) == name ? estimator : found; });
  return found;
}

}  // namespace mwidth::cli
