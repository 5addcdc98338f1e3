#include "device/modbus/register_value.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

namespace mwidth::device::modbus {
namespace {

using testing::ElementsAre;

RegisterValue Of(RegisterType type, WordOrder order = WordOrder::kAbcd) {
  return {.type = type, .order = order};
}

TEST(RegisterValue, LiesInTheOrderThatItsNameSays) {
  // 0x0A0B0C0D: A = 0A, B = 0B, C = 0C, D = 0D.
  constexpr double kRaw = 0x0A0B0C0D;
  EXPECT_THAT(Encode(Of(RegisterType::kUint32, WordOrder::kAbcd), kRaw), ElementsAre(0x0A0B, 0x0C0D));
  EXPECT_THAT(Encode(Of(RegisterType::kUint32, WordOrder::kCdab), kRaw), ElementsAre(0x0C0D, 0x0A0B));
  EXPECT_THAT(Encode(Of(RegisterType::kUint32, WordOrder::kBadc), kRaw), ElementsAre(0x0B0A, 0x0D0C));
  EXPECT_THAT(Encode(Of(RegisterType::kUint32, WordOrder::kDcba), kRaw), ElementsAre(0x0D0C, 0x0B0A));
  EXPECT_EQ(Encode(Of(RegisterType::kUint16, WordOrder::kAbcd), 0x0A0B)[0], 0x0A0B);
  EXPECT_EQ(Encode(Of(RegisterType::kUint16, WordOrder::kDcba), 0x0A0B)[0], 0x0B0A);
}

TEST(RegisterValue, IsReadAsItWasWritten) {
  std::mt19937_64 random(11);
  for (const auto type :
       {RegisterType::kInt16, RegisterType::kUint16, RegisterType::kInt32, RegisterType::kUint32}) {
    for (const auto order : {WordOrder::kAbcd, WordOrder::kCdab, WordOrder::kBadc, WordOrder::kDcba}) {
      const RegisterValue value = Of(type, order);
      std::uniform_real_distribution<double> raw(value.RawMin(), value.RawMax());
      for (int i = 0; i < 1000; ++i) {
        const double whole = std::nearbyint(raw(random));
        EXPECT_EQ(Decode(value, Encode(value, whole)), whole);
      }
      EXPECT_EQ(Decode(value, Encode(value, value.RawMin())), value.RawMin());
      EXPECT_EQ(Decode(value, Encode(value, value.RawMax())), value.RawMax());
    }
  }
  for (const float raw : {0.0F, -1.5F, 3.25e-7F, 1e30F}) {
    EXPECT_EQ(Decode(Of(RegisterType::kFloat32, WordOrder::kCdab),
                     Encode(Of(RegisterType::kFloat32, WordOrder::kCdab), raw)),
              raw);
  }
}

TEST(RegisterValue, FloatsAreIeee754) {
  // 1.0f is 3F800000.
  EXPECT_THAT(Encode(Of(RegisterType::kFloat32), 1.0), ElementsAre(0x3F80, 0x0000));
  const std::array<uint16_t, 2> not_a_number{0x7FC0, 0};
  EXPECT_TRUE(std::isnan(Decode(Of(RegisterType::kFloat32), not_a_number)));
}

TEST(RegisterValue, IsCutToWhatItsTypeHolds) {
  const RegisterValue value = Of(RegisterType::kInt16);
  EXPECT_EQ(Decode(value, Encode(value, 1e9)), 32'767);
  EXPECT_EQ(Decode(value, Encode(value, -1e9)), -32'768);
  EXPECT_EQ(Decode(value, Encode(value, std::numeric_limits<double>::infinity())), 32'767);
  EXPECT_EQ(Decode(value, Encode(value, std::numeric_limits<double>::quiet_NaN())), 0);
  EXPECT_EQ(Decode(Of(RegisterType::kUint32), Encode(Of(RegisterType::kUint32), -1)), 0);
}

TEST(RegisterValue, RoundsToTheNearestCount) {
  const RegisterValue value = Of(RegisterType::kInt16);
  EXPECT_EQ(Decode(value, Encode(value, -2.6)), -3);
  EXPECT_EQ(Decode(value, Encode(value, 2.4)), 2);
}

}  // namespace
}  // namespace mwidth::device::modbus
