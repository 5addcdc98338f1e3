#include "device/canopen/cia402.h"

#include <gtest/gtest.h>

#include <array>
#include <map>
#include <set>
#include <string>

namespace mwidth::device::canopen {
namespace {

// Bits 6, 5, 3, 2, 1, 0 of every state; the others say other things.
constexpr std::array<std::pair<uint16_t, DriveState>, 8> kStates{{
    {0x00, DriveState::kNotReadyToSwitchOn},
    {0x40, DriveState::kSwitchOnDisabled},
    {0x21, DriveState::kReadyToSwitchOn},
    {0x23, DriveState::kSwitchedOn},
    {0x27, DriveState::kOperationEnabled},
    {0x07, DriveState::kQuickStopActive},
    {0x0F, DriveState::kFaultReactionActive},
    {0x08, DriveState::kFault},
}};

TEST(Cia402, KnowsEveryStateWhateverTheOtherBits) {
  for (const auto& [word, state] : kStates) {
    for (const int others : {0x0000, 0x0010, 0x0280, 0xFF90}) {
      EXPECT_EQ(StateOf(static_cast<uint16_t>(word | others)), state) << NameOf(state);
    }
  }
  // Bit 5 does not matter where the table has an x.
  EXPECT_EQ(StateOf(0x60), DriveState::kSwitchOnDisabled);
  EXPECT_EQ(StateOf(0x2F), DriveState::kFaultReactionActive);
  EXPECT_EQ(StateOf(0x28), DriveState::kFault);
}

TEST(Cia402, EveryOtherWordIsUnknown) {
  EXPECT_EQ(StateOf(0x01), DriveState::kUnknown);
  EXPECT_EQ(StateOf(0x67), DriveState::kUnknown);
  EXPECT_EQ(StateOf(0xFFFF), DriveState::kUnknown);
  std::map<DriveState, int> counts;
  for (int word = 0; word < 0x80; ++word) {
    ++counts[StateOf(static_cast<uint16_t>(word))];
  }
  // Bit 4 is free everywhere, bit 5 in four states.
  EXPECT_EQ(counts[DriveState::kOperationEnabled], 2);
  EXPECT_EQ(counts[DriveState::kFault], 4);
  EXPECT_EQ(counts[DriveState::kUnknown], 128 - 4 * 4 - 4 * 2);
}

TEST(Cia402, NamesEveryStateDifferently) {
  std::set<std::string> names{NameOf(DriveState::kUnknown)};
  for (const auto& [word, state] : kStates) {
    names.insert(NameOf(state));
  }
  EXPECT_EQ(names.size(), kStates.size() + 1);
}

TEST(Cia402, LeadsToOperationEnabled) {
  EXPECT_EQ(TowardsEnabled(DriveState::kSwitchOnDisabled, 0), kShutdown);
  EXPECT_EQ(TowardsEnabled(DriveState::kReadyToSwitchOn, kShutdown), kSwitchOn);
  EXPECT_EQ(TowardsEnabled(DriveState::kSwitchedOn, kSwitchOn), kEnableOperation);
  EXPECT_EQ(TowardsEnabled(DriveState::kOperationEnabled, kEnableOperation), kEnableOperation);
}

TEST(Cia402, ResetsAFaultByARisingEdgeAgainAndAgain) {
  uint16_t last = kEnableOperation;
  for (const uint16_t expected : {kFaultReset, kDisableVoltage, kFaultReset}) {
    last = TowardsEnabled(DriveState::kFault, last);
    EXPECT_EQ(last, expected);
  }
}

TEST(Cia402, LetsGoOfTheMotorWhereItCanOnlyWait) {
  for (const DriveState state : {DriveState::kNotReadyToSwitchOn, DriveState::kQuickStopActive,
                                 DriveState::kFaultReactionActive, DriveState::kUnknown}) {
    EXPECT_EQ(TowardsEnabled(state, kEnableOperation), kDisableVoltage);
  }
}

}  // namespace
}  // namespace mwidth::device::canopen
