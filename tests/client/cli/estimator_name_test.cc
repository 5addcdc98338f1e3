#include "client/cli/estimator_name.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/model/estimator_kind.h"

namespace mwidth::cli {
namespace {

using ::testing::Contains;

TEST(EstimatorNameTest, EveryEstimatorHasTheNameThatConfigurationsHaveForIt) {
  for (const auto kind : model::kEstimatorKinds) {
    EXPECT_THAT(EstimatorNames(), Contains(model::Name(kind)));
  }
  for (const auto& name : EstimatorNames()) {
    EXPECT_TRUE(model::EstimatorNamed(name).has_value()) << name;
  }
}

TEST(EstimatorNameTest, ANameLeadsBackToItsEstimator) {
  EXPECT_EQ(EstimatorNamed("late-filtered-difference"), v1::ESTIMATOR_KIND_LATE_FILTERED_DIFFERENCE);
  for (const auto& name : EstimatorNames()) {
    EXPECT_EQ(EstimatorName(EstimatorNamed(name)), name);
  }
  EXPECT_EQ(EstimatorNamed("unspecified"), v1::ESTIMATOR_KIND_UNSPECIFIED);
  EXPECT_EQ(EstimatorNamed("guess"), v1::ESTIMATOR_KIND_UNSPECIFIED);
}

TEST(EstimatorNameTest, OneThatOnlyANewerServerKnowsIsANumber) {
  EXPECT_EQ(EstimatorName(static_cast<v1::EstimatorKind>(99)), "99");
}

}  // namespace
}  // namespace mwidth::cli
