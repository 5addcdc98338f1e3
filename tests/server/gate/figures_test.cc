#include "server/gate/figures.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <random>

namespace mwidth::gate {
namespace {

TEST(Figures, HaveSixSignificantDigits) {
  EXPECT_EQ(Figure(0.069756239), "0.0697562");
  EXPECT_EQ(Figure(34.2468304), "34.2468");
}

TEST(Figures, RoundTowardsZeroSoThatWhatIsAdmittedStaysAdmittedAsPrinted) {
  EXPECT_EQ(FigureTowardsZero(1.9999996), "1.99999");
  EXPECT_EQ(FigureTowardsZero(-1.9999996), "-1.99999");
  EXPECT_EQ(FigureTowardsZero(5), "5");
  EXPECT_EQ(FigureTowardsZero(0), "0");
}

TEST(Figures, NeverRoundOutwards) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> exponent(-9, 6);
  for (int i = 0; i < 10'000; ++i) {
    const double value = (i % 2 == 0 ? 1 : -1) * std::pow(10.0, exponent(random));
    const double printed = std::strtod(FigureTowardsZero(value).c_str(), nullptr);
    EXPECT_LE(std::abs(printed), std::abs(value)) << value;
    EXPECT_NEAR(printed / value, 1, 1.1e-5) << value;
  }
}

TEST(Figures, NameTheUnits) {
  EXPECT_EQ(MassUnit(model::AxisKind::kLinear), "kg");
  EXPECT_EQ(MassUnit(model::AxisKind::kRotary), "kg m^2");
  EXPECT_EQ(PositionUnit(model::AxisKind::kLinear), "m");
  EXPECT_EQ(PositionUnit(model::AxisKind::kRotary), "rad");
  EXPECT_EQ(ForceUnit(model::AxisKind::kLinear), "N");
  EXPECT_EQ(ForceUnit(model::AxisKind::kRotary), "N m");
}

}  // namespace
}  // namespace mwidth::gate
