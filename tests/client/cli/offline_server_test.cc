#include "client/cli/offline/offline_server.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "client/cpp/client.h"
#include "server/config.h"
#include "server/model/m_width.h"

namespace mwidth::offline {
namespace {

class OfflineServerTest : public ::testing::Test {
 protected:
  static v1::SweepMWidthRequest Cutoffs() {
    v1::SweepMWidthRequest request;
    request.mutable_x()->set_parameter(v1::SWEEP_PARAMETER_CUTOFF_HZ);
    request.mutable_x()->set_min(1);
    request.mutable_x()->set_max(100);
    request.mutable_x()->set_count(5);
    request.mutable_y()->set_parameter(v1::SWEEP_PARAMETER_HAND_DAMPING);
    request.mutable_y()->set_min(1);
    request.mutable_y()->set_max(4);
    request.mutable_y()->set_count(4);
    return request;
  }

  OfflineServer server_{"paper"};
  client::Client client_{server_.Connect()};
};

TEST_F(OfflineServerTest, TheMWidthIsTheModelsBitForBit) {
  const auto config = server::LoadConfig(server::FindConfig("paper"));
  const auto exact = model::ComputeMWidth(config.axes.at(0).loop);
  const auto answered = client_.MWidth().m_width().nominal();
  EXPECT_EQ(answered.min(), exact.lower.mass);
  EXPECT_EQ(answered.max(), exact.upper.mass);
}

TEST_F(OfflineServerTest, ASweepArrivesRowByRow) {
  uint32_t next = 0;
  EXPECT_TRUE(client_.SweepMWidth(Cutoffs(), [&](const v1::SweepMWidthResponse& row) {
    EXPECT_EQ(row.row(), next++);
    EXPECT_EQ(row.max_size(), 5);
    return true;
  }));
  EXPECT_EQ(next, 4U);
}

TEST_F(OfflineServerTest, ASweepEndsWhenNobodyWantsMore) {
  int rows = 0;
  EXPECT_FALSE(client_.SweepMWidth(Cutoffs(), [&](const v1::SweepMWidthResponse&) { return ++rows < 2; }));
  EXPECT_EQ(rows, 2);
}

TEST_F(OfflineServerTest, NothingIsRendered) {
  auto control = client_.AcquireControl("test");
  EXPECT_THROW(control.StartRendering(), client::Error);
}

TEST(OfflineServer, AConfigurationThatCannotBeUsedIsAnError) {
  EXPECT_THROW(OfflineServer("no such configuration"), std::runtime_error);
}

}  // namespace
}  // namespace mwidth::offline
