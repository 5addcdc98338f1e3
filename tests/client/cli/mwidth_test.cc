// The program `mwidth` itself, run against a server that answers as mwidthd does.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/client/fake_server.h"
#include "tests/client/subprocess.h"

namespace mwidth::testing {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

using Arguments = std::vector<std::string>;

// Calls that change nothing on an axis.
constexpr const char* kAcquired = "AcquireControl";
constexpr const char* kReleased = "ReleaseControl";

class MwidthTest : public ::testing::Test {
 protected:
  Outcome Run(const Arguments& arguments, const std::function<void(int)>& meanwhile = {}) {
    return RunProgram(MWIDTH_PROGRAM, arguments, server_.address(), meanwhile);
  }

  FakeServer server_;
};

TEST_F(MwidthTest, StateIsATableWithTheUnitsOfTheAxis) {
  const auto outcome = Run({"state"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, AllOf(HasSubstr("mwidthd 9.9.9"), HasSubstr("elbow (rotary, simulated)"),
                                 HasSubstr("admitted masses  from -0.0512345 to 0.351234 kg m²"),
                                 HasSubstr("limit 5 N m"), HasSubstr("tick             123456789012\n")));
}

TEST_F(MwidthTest, JsonKeepsTheNamesOfTheApi) {
  const auto outcome = Run({"state", "--json"});
  const auto json = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(json["axes"][0]["info"]["loop"]["device_mass"], 0.05);
  EXPECT_EQ(json["axes"][0]["state"], "STATE_IDLE");
  EXPECT_EQ(json["axes"][0]["missed_ticks"], "0");
}

TEST_F(MwidthTest, MWidthTakesOverrides) {
  const auto outcome = Run(
      {"m-width", "--rate-hz", "500", "--cutoff-hz=30", "--hand-stiffness", "0", "--estimator", "kalman"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(server_.LastMWidth().loop().period_s(), 0.002);
  EXPECT_EQ(server_.LastMWidth().loop().cutoff_hz(), 30);
  EXPECT_TRUE(server_.LastMWidth().loop().has_hand_stiffness());
  EXPECT_FALSE(server_.LastMWidth().loop().has_device_mass());
  EXPECT_EQ(server_.LastMWidth().loop().estimator(), v1::ESTIMATOR_KIND_KALMAN);
  EXPECT_FALSE(server_.LastMWidth().has_envelope());
  EXPECT_THAT(outcome.out,
              AllOf(HasSubstr("500 Hz; kalman, cut-off 30 Hz"), HasSubstr("-1.4"), HasSubstr("10"),
                    HasSubstr("oscillates at 3.25 Hz (lower) and 60.5 Hz (upper)")));
}

TEST_F(MwidthTest, MWidthTakesAnEnvelope) {
  const auto outcome = Run({"m-width", "--hand-stiffness-range", "10:200", "--hand-damping-range=0.1:2",
                            "--released-hand", "--device-mass-range", "0.04:0.06"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  const auto request = server_.LastMWidth();
  EXPECT_EQ(request.envelope().stiffness().min(), 10);
  EXPECT_EQ(request.envelope().stiffness().max(), 200);
  EXPECT_EQ(request.envelope().damping().min(), 0.1);
  EXPECT_FALSE(request.envelope().has_mass());
  EXPECT_TRUE(request.envelope().include_released_hand());
  EXPECT_EQ(request.tolerance().mass().max(), 0.06);
  EXPECT_FALSE(request.tolerance().has_damping());
  EXPECT_THAT(
      outcome.out,
      AllOf(
          HasSubstr(
              "Robust means stable for hand stiffness 10 to 200 N m/rad, hand damping 0.1 to 2 N m s/rad, a "
              "released hand, device mass 0.04 to 0.06 kg m², delay 0 to 0.5 ms"),
          HasSubstr("set by the nominal loop")));
}

TEST_F(MwidthTest, AnEmptyMWidthIsAReasonAndNoNumber) {
  const auto outcome = Run({"m-width", "--device-damping", "0"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out,
              AllOf(HasSubstr("none: without damping no mass is stable"), Not(HasSubstr("lower"))));
}

TEST_F(MwidthTest, FiguresNeedNoServer) {
  const auto folder = std::filesystem::path(::testing::TempDir()) / "mwidth_figures";
  const auto outcome =
      RunProgram(MWIDTH_PROGRAM, {"figures", "--out", folder.string(), "--png"}, "127.0.0.1:1");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("[1/9] table-1\n"), HasSubstr("[9/9] figure-10\n")));
  EXPECT_TRUE(std::filesystem::exists(folder / "figure-6.png"));
  EXPECT_TRUE(std::filesystem::exists(folder / "figure-6.csv"));
  std::filesystem::remove_all(folder);
  EXPECT_EQ(Run({"figures"}).code, 2);
}

TEST_F(MwidthTest, SetMassHoldsThenStopsAndReleases) {
  const auto outcome = Run({"set-mass", "-0.05", "--hold", "0", "--ramp", "0.5"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out,
              AllOf(HasSubstr("Rendering -0.05 kg m² on elbow."), HasSubstr("gain 2.92 dB (at 3.25 Hz)"),
                    HasSubstr("Stopped: the mass is back to zero.")));
  EXPECT_EQ(server_.LastMass().mass(), -0.05);
  EXPECT_EQ(server_.LastMass().ramp().nanos(), 500'000'000);
  EXPECT_THAT(server_.Calls(), ElementsAre(kAcquired, "ValidateMass", "StartRendering", "SetMass",
                                           "StopRendering", kReleased));
}

TEST_F(MwidthTest, EveryNotationOfANegativeMassIsUnderstood) {
  for (const auto& [typed, mass] :
       std::map<std::string, double>{{"-0.05", -0.05}, {"-.05", -0.05}, {"-5e-2", -0.05}, {"-0", 0.0}}) {
    const auto outcome = Run({"set-mass", typed, "--validate-only"});
    EXPECT_EQ(outcome.code, 0) << typed << ": " << outcome.err;
    EXPECT_EQ(server_.LastMass().mass(), mass);
  }
}

TEST_F(MwidthTest, ARefusedMassIsExplainedAndNothingIsEnabled) {
  const auto outcome = Run({"set-mass", "0.8"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.err,
              AllOf(HasSubstr("Refused: a virtual mass of 0.8 kg m² on elbow"),
                    HasSubstr("from -0.0512345 to 0.351234 kg m²"), HasSubstr("nearest is 0.351234"),
                    HasSubstr("cut-off of 4.5 Hz would admit it"), HasSubstr("upper edge binds")));
  EXPECT_THAT(outcome.out, IsEmpty());
  EXPECT_THAT(server_.Calls(), ElementsAre(kAcquired, kReleased));
}

TEST_F(MwidthTest, ARefusalAsJsonIsAGoogleRpcStatus) {
  const auto outcome = Run({"--json", "set-mass", "0.8"});
  EXPECT_EQ(outcome.code, 1);
  const auto json = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(json["code"], 9);
  EXPECT_EQ(json["details"][0]["reason"], "UNSTABLE_MASS");
  EXPECT_EQ(json["details"][1]["nearest_admitted_mass"], kAdmittedMax);
}

TEST_F(MwidthTest, ValidateOnlyNeitherEnablesNorSets) {
  const auto outcome = Run({"set-mass", "0.1", "--validate-only"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("Would render 0.1 kg m²"));
  EXPECT_THAT(server_.Calls(), ElementsAre(kAcquired, "ValidateMass", kReleased));
  EXPECT_EQ(Run({"set-mass", "0.8", "--validate-only"}).code, 1);
}

TEST_F(MwidthTest, SetFilterTakesControlChangesAndReleases) {
  const auto outcome = Run({"set-filter", "--estimator", "kalman", "20"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out,
              AllOf(HasSubstr("elbow: filter is kalman, cut-off 20 Hz; it was filtered-difference"),
                    HasSubstr("from -0.0512345 to 0.351234 kg m²")));
  EXPECT_THAT(server_.Calls(), ElementsAre(kAcquired, "SetFilter", kReleased));
  EXPECT_EQ(server_.LastFilter().cutoff_hz(), 20);
  EXPECT_EQ(server_.LastFilter().estimator(), v1::ESTIMATOR_KIND_KALMAN);
  EXPECT_THAT(Run({"state"}).out, HasSubstr("filter           kalman, cut-off 20 Hz\n"));
}

TEST_F(MwidthTest, SetFilterOnlyAsksWhereItIsToldSo) {
  const auto outcome = Run({"--json", "set-filter", "20", "--validate-only"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(nlohmann::json::parse(outcome.out)["loop"]["cutoff_hz"], 20);
  EXPECT_EQ(server_.LastFilter().estimator(), v1::ESTIMATOR_KIND_UNSPECIFIED);
  EXPECT_THAT(server_.Calls(), ElementsAre(kAcquired, "ValidateFilter", kReleased));
}

TEST_F(MwidthTest, ARefusedFilterIsExplained) {
  const auto outcome = Run({"set-filter", "100"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.err,
              HasSubstr("Refused: with filtered-difference, cut-off 100 Hz, the virtual mass of 0 kg m²"));
  EXPECT_THAT(server_.Calls(), ElementsAre(kAcquired, kReleased));
  const auto json = nlohmann::json::parse(Run({"--json", "set-filter", "100"}).out);
  EXPECT_EQ(json["details"][0]["reason"], "UNSTABLE_MASS");
}

TEST_F(MwidthTest, AFilterOfAnAxisThatAnotherControlsIsRefused) {
  server_.Behave({.held_by_another = true});
  const auto outcome = Run({"set-filter", "20"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("control is held by somebody"));
}

TEST_F(MwidthTest, CtrlCEndsAHoldWithTheMassBackAtZero) {
  for (const int signal : {SIGINT, SIGTERM}) {
    FakeServer server;
    const auto outcome = RunProgram(MWIDTH_PROGRAM, {"set-mass", "0.1"}, server.address(), [&](int pid) {
      EXPECT_TRUE(server.WaitForCall("SetMass"));
      // As `timeout` does it: to the program, then to its whole group.
      kill(pid, signal);
      kill(pid, SIGHUP);
    });
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_THAT(outcome.out, HasSubstr("Holding it until Ctrl-C."));
    EXPECT_THAT(server.Calls(), ElementsAre(kAcquired, "ValidateMass", "StartRendering", "SetMass",
                                            "StopRendering", kReleased));
  }
}

TEST_F(MwidthTest, AFaultEndsAHoldWithItsMessage) {
  server_.Behave({.fault_on_mass = true});
  const auto outcome = Run({"set-mass", "0.1"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("Rendering has ended: fault, the drive did not answer"));
}

TEST_F(MwidthTest, ALostLeaseEndsAHold) {
  server_.Behave({.ttl_s = 0.1, .renewal = grpc::Status(grpc::StatusCode::ABORTED, "somebody took control")});
  const auto outcome = Run({"set-mass", "0.1"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("somebody took control"));
}

TEST_F(MwidthTest, ControlHeldByAnotherIsARefusal) {
  server_.Behave({.held_by_another = true});
  const auto outcome = Run({"set-mass", "0.1"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("control is held by somebody"));
}

TEST_F(MwidthTest, StopNeedsNoControl) {
  server_.Behave({.held_by_another = true});
  const auto outcome = Run({"stop", "--reason", "strap came loose"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("elbow: stopped, fault"));
  EXPECT_EQ(server_.StopReason(), "strap came loose");
  EXPECT_THAT(server_.Calls(), ElementsAre("EmergencyStop"));
}

TEST_F(MwidthTest, ClearFaultTakesAndReleasesControl) {
  const auto outcome = Run({"clear-fault"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("elbow: idle"));
  EXPECT_THAT(server_.Calls(), ElementsAre(kAcquired, "ClearFault", kReleased));
}

TEST_F(MwidthTest, AWrongCommandLineIsExitCodeTwo) {
  for (const Arguments& arguments : {Arguments{},
                                     {"set-mass"},
                                     {"set-mass", "heavy"},
                                     {"set-filter"},
                                     {"set-filter", "--estimator", "guess", "20"},
                                     {"m-width", "--estimator", "unspecified"},
                                     {"m-width", "--hand-damping-range", "5"},
                                     {"m-width", "--hand-damping-range", "5:"},
                                     {"sweep", "cutoff-hz=1:2", "--released-hand"},
                                     {"m-width", "--rate-hz", "0"},
                                     {"m-width", "--rate-hz", "500", "--period-s", "0.002"},
                                     {"stream", "--samples", "-1"}}) {
    EXPECT_EQ(Run(arguments).code, 2);
  }
  EXPECT_THAT(server_.Calls(), IsEmpty());
}

TEST_F(MwidthTest, AnUnknownCommandIsNamed) {
  const auto outcome = Run({"fly"});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("mwidth: 'fly' is no command\nmwidth --help"));
}

TEST_F(MwidthTest, HelpAndVersionAreNotErrors) {
  const auto help = Run({"--help"});
  EXPECT_EQ(help.code, 0);
  EXPECT_THAT(help.out, AllOf(HasSubstr("set-mass"), HasSubstr("Exit codes:"), HasSubstr("MWIDTH_SERVER")));
  for (const auto* command :
       {"state", "m-width", "set-mass", "set-filter", "stop", "clear-fault", "stream"}) {
    const auto outcome = Run({command, "--help"});
    EXPECT_EQ(outcome.code, 0);
    EXPECT_THAT(outcome.out, HasSubstr("Examples:")) << command;
  }
  EXPECT_EQ(Run({"--version"}).out, "mwidth " MWIDTH_VERSION "\n");
}

TEST_F(MwidthTest, AnUnknownAxisIsARefusalAndNoServerAFailure) {
  EXPECT_EQ(Run({"--axis", "knee", "state"}).code, 1);
  const auto outcome = Run({"--server", "127.0.0.1:1", "state"});
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("no server answers at 127.0.0.1:1"));
}

}  // namespace
}  // namespace mwidth::testing
