#include "server/gate/state_words.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

namespace mwidth::gate {
namespace {

using exchange::Fault;
using exchange::State;
using testing::HasSubstr;

TEST(StateWords, NameEveryStateAsTheApiDoes) {
  EXPECT_EQ(StateName(State::kIdle), "IDLE");
  EXPECT_EQ(StateName(State::kReady), "READY");
  EXPECT_EQ(StateName(State::kRendering), "RENDERING");
  EXPECT_EQ(StateName(State::kFault), "FAULT");
}

TEST(StateWords, SayForEveryFaultWhatToDo) {
  std::set<std::string> messages;
  for (const Fault fault :
       {Fault::kEmergencyStop,  Fault::kDriveSilent,   Fault::kNotFinite,          Fault::kPositionLimit,
        Fault::kVelocityLimit,  Fault::kOverrun,       Fault::kDriveRefused,       Fault::kNoDriveWatchdog,
        Fault::kForeignTraffic, Fault::kDriveError,    Fault::kForceSaturation,    Fault::kForceSlew,
        Fault::kEncoderJump,    Fault::kEncoderFreeze, Fault::kAccelerometer,      Fault::kRepeatedOverrun,
        Fault::kLoopDelay,      Fault::kPositionGaps,  Fault::kGrowingOscillation, Fault::kEnergyExcess}) {
    const std::string message = FaultMessage({.fault = fault, .number = 1});
    EXPECT_THAT(message, HasSubstr("then clear the fault."));
    messages.insert(message);
  }
  EXPECT_EQ(messages.size(), 20U);
  EXPECT_EQ(FaultMessage({}), "");
}

TEST(StateWords, GiveTheFiguresOfAFault) {
  const std::string message =
      FaultMessage({.fault = Fault::kVelocityLimit, .number = 1, .tick = 7, .value = 3.25, .limit = 3});
  EXPECT_THAT(message, HasSubstr("3.25, above its limit of 3"));
}

TEST(StateWords, GiveACodeAsManualsPrintIt) {
  const auto words = [](Fault fault, double code) {
    return FaultMessage({.fault = fault, .number = 1, .value = code});
  };
  EXPECT_THAT(words(Fault::kDriveError, 0xFF10), HasSubstr("error (code FF10h). Look"));
  EXPECT_THAT(words(Fault::kDriveError, 0), HasSubstr("error. Look"));
  EXPECT_THAT(words(Fault::kForeignTraffic, 0x80), HasSubstr("(identifier 80h)."));
}

}  // namespace
}  // namespace mwidth::gate
