#include "server/record/export/bids_events.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

namespace mwidth::record {
namespace {

constexpr int64_t kFirstNs = 7'000'000'000;
constexpr double kPeriodS = 0.001;

MotionExtent Extent() {
  MotionExtent extent;
  extent.samples = 10;
  extent.first_tick = 100;
  extent.last_tick = 119;
  extent.first_monotonic_ns = kFirstNs;
  return extent;
}

Marker MarkerAt(int64_t time_ns, const std::string& kind, const std::string& label) {
  Marker marker;
  marker.label = label;
  marker.kind = kind;
  marker.monotonic_ns = kFirstNs + time_ns;
  return marker;
}

// onset, duration, trial_type and label of each row.
std::vector<std::vector<std::string>> Rows(const std::vector<Marker>& markers,
                                           const std::vector<Event>& events, const std::vector<Gap>& gaps) {
  std::istringstream text(EventsTsv(markers, events, gaps, Extent(), kPeriodS));
  std::vector<std::vector<std::string>> rows;
  for (std::string line; std::getline(text, line);) {
    std::istringstream cells(line);
    rows.emplace_back();
    for (std::string cell; std::getline(cells, cell, '\t') && rows.back().size() < 4;) {
      rows.back().push_back(cell);
    }
  }
  rows.erase(rows.begin());
  return rows;
}

using Expected = std::vector<std::vector<std::string>>;

TEST(BidsEventsTest, ATrialIsOneRowFromItsStartToItsEnd) {
  EXPECT_EQ(Rows({MarkerAt(1, "trial_start", "a"), MarkerAt(2'000'000'003, "trial_end", "b")}, {}, {}),
            (Expected{{"0.000000001", "2.000000002", "trial", "a"}}));
}

TEST(BidsEventsTest, TrialsWithoutAnEndOrABeginningAreTold) {
  EXPECT_EQ(Rows({MarkerAt(0, "trial_end", "x"), MarkerAt(1'000'000'000, "trial_start", "a"),
                  MarkerAt(2'000'000'000, "trial_start", "b"), MarkerAt(3'000'000'000, "trial_end", "y"),
                  MarkerAt(4'000'000'000, "trial_end", "z")},
                 {}, {}),
            (Expected{{"0.000000000", "0.000000000", "trial_end", "x"},
                      {"1.000000000", "n/a", "trial", "a"},
                      {"2.000000000", "1.000000000", "trial", "b"},
                      {"4.000000000", "0.000000000", "trial_end", "z"}}));
}

TEST(BidsEventsTest, MarkersThatCameLateAreWhereTheyWere) {
  // In the order of their numbers the end came before the beginning.
  EXPECT_EQ(Rows({MarkerAt(900, "trial_end", ""), MarkerAt(100, "trial_start", "a"), MarkerAt(500, "", "m")},
                 {}, {}),
            (Expected{{"0.000000100", "0.000000800", "trial", "a"},
                      {"0.000000500", "0.000000000", "marker", "m"}}));
}

TEST(BidsEventsTest, EventsBeforeTheFirstSampleAreNegative) {
  EXPECT_EQ(Rows({},
                 {{.number = 1,
                   .kind = EventKind::kFault,
                   .tick = 99,
                   .monotonic_ns = kFirstNs - 1'500'000'000,
                   .message = "m",
                   .metadata = {}}},
                 {}),
            (Expected{{"-1.500000000", "0.000000000", "fault", "n/a"}}));
}

TEST(BidsEventsTest, GapsLieOnTheGridOfTicks) {
  const Gap within{.after_tick = 104, .before_tick = 108, .missed_ticks = 1, .lost_ticks = 2, .reason = "r"};
  const Gap at_end{.after_tick = 119, .before_tick = 0, .missed_ticks = 0, .lost_ticks = 5, .reason = "r"};
  const Gap at_beginning{
      .after_tick = 0, .before_tick = 100, .missed_ticks = 0, .lost_ticks = 10, .reason = "r"};
  EXPECT_EQ(Rows({}, {}, {within, at_end, at_beginning}),
            (Expected{{"-0.010000000", "0.010000000", "gap", "n/a"},
                      {"0.005000000", "0.003000000", "gap", "n/a"},
                      {"0.020000000", "0.005000000", "gap", "n/a"}}));
}

TEST(BidsEventsTest, EveryColumnIsDescribed) {
  const auto json = nlohmann::json::parse(EventsJson("1.2.3"));
  std::istringstream head(EventsTsv({}, {}, {}, Extent(), kPeriodS));
  std::string line;
  std::getline(head, line);
  std::istringstream cells(line);
  for (std::string cell; std::getline(cells, cell, '\t');) {
    EXPECT_TRUE(json.contains(cell)) << cell;
  }
  EXPECT_EQ(json["StimulusPresentation"]["SoftwareVersion"], "1.2.3");
}

}  // namespace
}  // namespace mwidth::record
