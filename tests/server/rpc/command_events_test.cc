#include "server/rpc/command_events.h"

#include <cstdlib>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "tests/server/rpc/served_axis.h"

namespace mwidth::rpc {
namespace {

using record::Event;
using record::EventKind;

class CommandEventsTest : public ServedAxis {
 protected:
  std::vector<Event> Published() {
    std::vector<Event> published;
    while (auto delivery = subscription_->Take()) {
      published.push_back(delivery->event);
    }
    return published;
  }

  std::unique_ptr<record::EventSubscription> subscription_ = axis.events().Subscribe(0, 1, [] {});
};

TEST_F(CommandEventsTest, AMassThatIsSetIsTheEventWithItsMargins) {
  const std::string lease = Acquire("the study");
  ASSERT_TRUE(SetMass(lease, 0.1).ok());
  const auto events = Published();
  ASSERT_EQ(events.size(), 2);
  EXPECT_EQ(events[0].kind, EventKind::kControlAcquired);
  EXPECT_EQ(events[0].metadata.at("client_name"), "the study");
  EXPECT_EQ(events[1].kind, EventKind::kMassSet);
  EXPECT_EQ(events[1].metadata.at("mass"), "0.1");
  // The paper's Table II at 10 Hz: M/m from -1.398 to 34.25.
  EXPECT_NEAR(std::stod(events[1].metadata.at("nominal_min")) / 0.07, -1.398, 0.001);
  EXPECT_NEAR(std::stod(events[1].metadata.at("nominal_max")) / 0.07, 34.25, 0.01);
  EXPECT_GT(std::stod(events[1].metadata.at("gain_margin_db")), 3);
  EXPECT_GT(std::stod(events[1].metadata.at("phase_margin_deg")), 0);
}

TEST_F(CommandEventsTest, ARefusalIsTheEventWithItsReason) {
  const std::string lease = Acquire();
  ASSERT_FALSE(SetMass(lease, -1).ok());
  const auto events = Published();
  ASSERT_EQ(events.size(), 2);
  EXPECT_EQ(events[1].kind, EventKind::kMassRefused);
  EXPECT_EQ(events[1].metadata.at("reason"), "UNSTABLE_MASS");
  EXPECT_EQ(events[1].metadata.at("mass"), "-1");
}

TEST_F(CommandEventsTest, WhoHasNoLeaseIsNoEvent) {
  ASSERT_FALSE(SetMass("nobody's", 0.1).ok());
  EXPECT_TRUE(Published().empty());
}

TEST_F(CommandEventsTest, AnEmergencyStopTellsItsReasonOnOneLine) {
  v1::EmergencyStopRequest request;
  request.set_reason("arm\nslipped");
  v1::EmergencyStopResponse response;
  ASSERT_TRUE(Call(&Rendering::EmergencyStop, *rendering, request, response).ok());
  const auto events = Published();
  ASSERT_EQ(events.size(), 1);
  EXPECT_EQ(events[0].kind, EventKind::kEmergencyStop);
  EXPECT_EQ(events[0].metadata.at("reason"), "arm slipped");
}

}  // namespace
}  // namespace mwidth::rpc
