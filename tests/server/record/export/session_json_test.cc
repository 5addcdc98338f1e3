#include "server/record/export/session_json.h"

#include <gtest/gtest.h>

#include <limits>

#include "server/record/session/wall_time.h"

namespace mwidth::record {
namespace {

TEST(SessionJsonTest, AWallClockThatWasSetCountsFromThen) {
  SessionInfo info;
  info.start_wall_ns = 1'000'000;
  info.start_monotonic_ns = 500;
  const std::vector<WallClockStep> steps{{.monotonic_ns = 700, .offset_ns = 5},
                                         {.monotonic_ns = 900, .offset_ns = 6}};
  EXPECT_EQ(WallTime(info, steps, 500), 1'000'000);
  EXPECT_EQ(WallTime(info, steps, 699), 1'000'199);
  EXPECT_EQ(WallTime(info, steps, 700), 705);
  EXPECT_EQ(WallTime(info, steps, 1000), 1006);
}

TEST(SessionJsonTest, WhatThereIsNotIsNull) {
  SessionInfo info;
  info.axis.force_slew_limit = std::numeric_limits<double>::infinity();
  const auto json = nlohmann::json::parse(Indented(SessionJson(info)));
  EXPECT_TRUE(json["end_time"].is_null());
  EXPECT_TRUE(json["axis"]["force_slew_limit"].is_null());
}

TEST(SessionJsonTest, TheAxisIsShownAsJsonWhereItIsSome) {
  SessionInfo info;
  info.provenance.axis_state = R"({"state": "STATE_READY"})";
  EXPECT_EQ(SessionJson(info)["axis_state"]["state"], "STATE_READY");
  info.provenance.axis_state = "{ broken";
  EXPECT_EQ(SessionJson(info)["axis_state"], "{ broken");
}

TEST(SessionJsonTest, EveryKindOfEventHasItsWord) {
  EXPECT_EQ(KindWord(EventKind::kStateChanged), "state_changed");
  EXPECT_EQ(KindWord(EventKind::kControlReleased), "control_released");
  EXPECT_EQ(KindWord(EventKind::kWallClockStepped), "wall_clock_stepped");
  EXPECT_EQ(KindWord(EventKind::kServerStopping), "server_stopping");
  EXPECT_EQ(KindWord(static_cast<EventKind>(200)), "unknown");
}

}  // namespace
}  // namespace mwidth::record
