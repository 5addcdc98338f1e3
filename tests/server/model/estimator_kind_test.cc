#include "server/model/estimator_kind.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>
#include <string>

namespace mwidth::model {
namespace {

TEST(EstimatorKind, HasANameOfItsOwnThatLeadsBack) {
  std::set<std::string> names;
  for (const EstimatorKind kind : kEstimatorKinds) {
    EXPECT_EQ(EstimatorNamed(Name(kind)), kind);
    names.insert(Name(kind));
  }
  EXPECT_EQ(names.size(), kEstimatorKinds.size());
}

TEST(EstimatorKind, OfNoKnownNameOrValueIsNone) {
  EXPECT_FALSE(EstimatorNamed("unknown").has_value());
  EXPECT_FALSE(EstimatorNamed("").has_value());
  EXPECT_FALSE(EstimatorNamed("Kalman").has_value());
  const auto stranger = static_cast<EstimatorKind>(200);
  EXPECT_STREQ(Name(stranger), "unknown");
  EXPECT_FALSE(Runs(stranger, 1e-3, 10));
}

TEST(EstimatorKind, RunsWithinItsRangeOfCutoffsAndNotBeyond) {
  constexpr double kPeriodS = 3e-4;
  for (const EstimatorKind kind : kEstimatorKinds) {
    const CutoffRange range = CutoffRangeOf(kind);
    EXPECT_TRUE(Runs(kind, kPeriodS, range.max / kPeriodS)) << Name(kind);
    EXPECT_TRUE(Runs(kind, kPeriodS, std::fmax(range.min, 1e-12) / kPeriodS)) << Name(kind);
    EXPECT_FALSE(Runs(kind, kPeriodS, range.max / kPeriodS * (1 + 1e-12))) << Name(kind);
    EXPECT_FALSE(Runs(kind, kPeriodS, range.min / kPeriodS * (1 - 1e-12))) << Name(kind);
    for (const double cutoff_hz :
         {0.0, -10.0, std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
      EXPECT_FALSE(Runs(kind, kPeriodS, cutoff_hz)) << Name(kind);
    }
  }
}

}  // namespace
}  // namespace mwidth::model
