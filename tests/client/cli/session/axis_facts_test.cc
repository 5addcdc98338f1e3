#include "client/cli/session/axis_facts.h"

#include <gtest/gtest.h>

#include <cmath>

namespace mwidth::cli::session {
namespace {

TEST(AxisFactsTest, ReadsTheStateWithEitherKindOfNames) {
  for (
      const char* text :
      {R"({"info": {"simulated": true, "loop": {"device_mass": 0.07, "device_damping": 0.005, "hand_damping": 5,
            "hand_stiffness": 700, "period_s": 0.001, "cutoff_hz": 10, "estimator": "ESTIMATOR_KIND_KALMAN"}},
            "m_width": {"nominal": {"min": -0.098, "max": 2.4}, "required_gain_margin_db": 3}})",
       R"({"info": {"simulated": true, "loop": {"deviceMass": 0.07, "deviceDamping": 0.005, "handDamping": 5,
            "handStiffness": 700, "periodS": 0.001, "cutoffHz": 10}},
            "mWidth": {"nominal": {"min": -0.098, "max": 2.4}, "requiredGainMarginDb": 3}})"}) {
    const AxisFacts facts = FactsOf(text);
    ASSERT_TRUE(facts.loop.has_value());
    EXPECT_EQ(facts.loop->device_mass, 0.07);
    EXPECT_EQ(facts.loop->hand_stiffness, 700);
    EXPECT_EQ(facts.nominal->min, -0.098);
    EXPECT_EQ(facts.required_gain_margin_db, 3);
    EXPECT_EQ(facts.simulated, true);
    EXPECT_FALSE(facts.robust.has_value());
  }
}

TEST(AxisFactsTest, KnowsNothingOfWhatIsNoState) {
  for (const char* text :
       {"", "{", "[]", "null", R"({"info": 3})", R"({"info": {"loop": {"device_mass": "heavy"}}})",
        R"({"m_width": {"nominal": {"min": 1, "max": -1, "empty": true}}})"}) {
    const AxisFacts facts = FactsOf(text);
    EXPECT_FALSE(facts.loop.has_value()) << text;
    EXPECT_FALSE(facts.nominal.has_value()) << text;
  }
}

record::Event MassSet(uint64_t tick, const std::string& mass,
                      record::EventKind kind = record::EventKind::kMassSet) {
  return {.kind = kind,
          .tick = tick,
          .message = "",
          .metadata = {{"mass", mass},
                       {"gain_margin_db", "inf"},
                       {"delay_margin_s", "0.003"},
                       {"phase_margin_deg", "?"},
                       {"robust_min", "-0.2"},
                       {"robust_max", "4"}}};
}

TEST(MarginsInForceTest, AreThoseOfTheLastMassOrFilterBefore) {
  const auto margins =
      MarginsOf({MassSet(200, "0.2"), MassSet(100, "0.1"), MassSet(150, "9", record::EventKind::kMassRefused),
                 MassSet(300, "0.2", record::EventKind::kFilterSet)});
  ASSERT_EQ(margins.size(), 3);
  EXPECT_EQ(InForceAt(margins, 99), nullptr);
  EXPECT_EQ(InForceAt(margins, 100)->mass, 0.1);
  EXPECT_EQ(InForceAt(margins, 199)->mass, 0.1);
  EXPECT_EQ(InForceAt(margins, 200)->mass, 0.2);
  EXPECT_EQ(InForceAt(margins, 1000)->tick, 300);
  EXPECT_TRUE(std::isinf(*margins[0].gain_db));
  EXPECT_EQ(margins[0].delay_s, 0.003);
  EXPECT_FALSE(margins[0].phase_deg.has_value());
  EXPECT_EQ(margins[0].robust->max, 4);
  EXPECT_FALSE(margins[0].admitted.has_value());
}

}  // namespace
}  // namespace mwidth::cli::session
