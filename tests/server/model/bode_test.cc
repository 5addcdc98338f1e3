#include "server/model/bode.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <string>

#include "server/model/continuous_loop.h"
#include "server/model/frequency_response.h"
#include "server/model/m_width.h"

namespace mwidth::model {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr LoopParameters kPaper{.device_mass = 0.07,
                                .device_damping = 0.005,
                                .hand_mass = 0,
                                .hand_damping = 5,
                                .hand_stiffness = 700,
                                .period_s = 1e-3,
                                .cutoff_hz = 10,
                                .delay_s = 0};
constexpr double kInfinity = std::numeric_limits<double>::infinity();

class BodeOfEitherModel : public ::testing::TestWithParam<ResponseModel> {
 protected:
  MWidth Stable() const {
    return GetParam() == ResponseModel::kDiscrete ? ComputeMWidth(kPaper) : ComputeContinuousMWidth(kPaper);
  }
};

TEST_P(BodeOfEitherModel, PassesThroughMinusOneAtAnEdgeOfTheMWidth) {
  const MWidth stable = Stable();
  for (const Edge& edge : {stable.lower, stable.upper}) {
    const FrequencyRange range{.min_hz = edge.critical_hz, .max_hz = 1.1 * edge.critical_hz, .count = 2};
    const Bode bode = ComputeBode(kPaper, edge.mass, range, GetParam());
    EXPECT_NEAR(bode.magnitude_db[0], 0, 1e-9);
    EXPECT_NEAR(std::abs(bode.phase_deg[0]), 180, 1e-9);
  }
}

TEST_P(BodeOfEitherModel, CountsThePhaseOnWithoutJumps) {
  // Through the resonance and three turns of delay.
  LoopParameters late = kPaper;
  late.delay_s = 3e-3;
  for (const double mass : {-0.01, 0.2}) {
    const Bode bode = ComputeBode(late, mass, {.min_hz = 0.1, .max_hz = 490, .count = 2000}, GetParam());
    const SampledResponse sampled(late);
    EXPECT_NEAR(bode.phase_deg.front(), mass > 0 ? 180 : 0, 2);
    EXPECT_LT(bode.phase_deg.back(), bode.phase_deg.front() - 540);
    for (std::size_t i = 1; i < bode.phase_deg.size(); ++i) {
      EXPECT_NEAR(bode.phase_deg[i], bode.phase_deg[i - 1], 20);
      const std::complex<double> loop = GetParam() == ResponseModel::kDiscrete
                                            ? sampled.Loop(mass, bode.frequency_hz[i])
                                            : ContinuousLoop(late, mass, bode.frequency_hz[i]);
      const double radians = bode.phase_deg[i] * std::numbers::pi / 180;
      EXPECT_LT(std::abs(std::polar(std::abs(loop), radians) - loop), 1e-9 * std::abs(loop));
      EXPECT_NEAR(bode.magnitude_db[i], 20 * std::log10(std::abs(loop)), 1e-9);
    }
  }
}

TEST_P(BodeOfEitherModel, FeelsDeviceAndVirtualMassAtLowFrequency) {
  const Bode bode = ComputeBode(kPaper, 0.21, {.min_hz = 0.05, .max_hz = 1, .count = 3}, GetParam());
  EXPECT_EQ(bode.effective_missing, "");
  EXPECT_NEAR(bode.effective_mass_ratio[0], 4, 0.03);
  EXPECT_NEAR(
      ComputeBode(kPaper, 0, {.min_hz = 0.05, .max_hz = 1, .count = 3}, GetParam()).effective_mass_ratio[0],
      1, 0.01);
}

TEST_P(BodeOfEitherModel, SaysWhyNothingIsFeltInPlaceOfRatios) {
  const FrequencyRange range{.min_hz = 1, .max_hz = 10, .count = 5};
  const Bode unstable = ComputeBode(kPaper, 1.01 * Stable().upper.mass, range, GetParam());
  EXPECT_THAT(unstable.effective_mass_ratio, IsEmpty());
  EXPECT_THAT(unstable.effective_damping_ratio, IsEmpty());
  EXPECT_THAT(unstable.effective_missing, HasSubstr("unstable"));
  EXPECT_THAT(unstable.magnitude_db, SizeIs(5));

  LoopParameters released = kPaper;
  released.hand_stiffness = 0;
  released.hand_damping = 0;
  EXPECT_THAT(ComputeBode(released, 0.01, range, GetParam()).effective_missing, HasSubstr("feels nothing"));

  LoopParameters undamped = kPaper;
  undamped.device_damping = 0;
  undamped.hand_damping = 0;
  EXPECT_THAT(ComputeBode(undamped, 0.01, range, GetParam()).effective_missing, HasSubstr("without damping"));
}

TEST_P(BodeOfEitherModel, HasNoLoopAtAMassOfZero) {
  const Bode none = ComputeBode(kPaper, 0, {.min_hz = 1, .max_hz = 10, .count = 2}, GetParam());
  const Bode some = ComputeBode(kPaper, 0.01, {.min_hz = 1, .max_hz = 10, .count = 2}, GetParam());
  EXPECT_EQ(none.magnitude_db[0], -kInfinity);
  EXPECT_EQ(none.phase_deg, some.phase_deg);
}

INSTANTIATE_TEST_SUITE_P(Models, BodeOfEitherModel,
                         ::testing::Values(ResponseModel::kDiscrete, ResponseModel::kContinuous));

TEST(Bode, TakesEqualRatiosBetweenExactEnds) {
  const Bode bode =
      ComputeBode(kPaper, 0.1, {.min_hz = 0.3, .max_hz = 300, .count = 4}, ResponseModel::kDiscrete);
  EXPECT_EQ(bode.frequency_hz.front(), 0.3);
  EXPECT_NEAR(bode.frequency_hz[1], 3, 1e-12);
  EXPECT_EQ(bode.frequency_hz.back(), 300);
}

TEST(ValidateFrequencyRange, NamesTheFieldThatIsNotAllowed) {
  const auto objection = [](const FrequencyRange& range) {
    const auto error = Validate(range, 1e-3);
    return error ? error->parameter : std::string();
  };
  EXPECT_EQ(objection({.min_hz = 0.1, .max_hz = 500, .count = 2}), "");
  EXPECT_EQ(objection({.min_hz = 0, .max_hz = 500, .count = 2}), "min_hz");
  EXPECT_EQ(objection({.min_hz = std::nan(""), .max_hz = 500, .count = 2}), "min_hz");
  EXPECT_EQ(objection({.min_hz = 501, .max_hz = 502, .count = 2}), "min_hz");
  EXPECT_EQ(objection({.min_hz = 1, .max_hz = 1, .count = 2}), "max_hz");
  EXPECT_EQ(objection({.min_hz = 1, .max_hz = 500.1, .count = 2}), "max_hz");
  EXPECT_EQ(objection({.min_hz = 1, .max_hz = kInfinity, .count = 2}), "max_hz");
  EXPECT_EQ(objection({.min_hz = 1, .max_hz = 2, .count = 1}), "count");
  EXPECT_EQ(objection({.min_hz = 1, .max_hz = 2, .count = kMaxFrequencies + 1}), "count");
}

}  // namespace
}  // namespace mwidth::model
