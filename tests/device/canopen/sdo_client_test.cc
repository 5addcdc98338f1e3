#include "device/canopen/sdo_client.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/device/canopen/fake_node.h"

namespace mwidth::device::canopen {
namespace {

using ::testing::AllOf;
using testing::FakeBus;
using testing::FakeNode;
using testing::FakeNow;
using ::testing::HasSubstr;
using testing::kNode;

class SdoClientTest : public ::testing::Test {
 protected:
  SdoClientTest() { FakeBus::lost = false; }
  template <typename Ask>
  static std::string ErrorOf(Ask ask) {
    try {
      ask();
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "answered";
  }

  std::shared_ptr<FakeNode> node = std::make_shared<FakeNode>();
  FakeBus bus{node};
  SdoClient sdo{bus, kNode, FakeNow};
};

TEST_F(SdoClientTest, ReadsAndWritesObjects) {
  sdo.Download(kMaxTorque, 1234);
  EXPECT_EQ(node->Get(kMaxTorque), 1234U);
  EXPECT_EQ(sdo.Upload(kMaxTorque), 1234U);
}

TEST_F(SdoClientTest, SaysWhatTheNodeRefusesAndWhy) {
  node->Refuse(kMaxTorque, 0x0609'0031);
  EXPECT_THROW(sdo.Download(kMaxTorque, 9), SdoAborted);
  EXPECT_EQ(ErrorOf([this] { sdo.Upload(kMaxTorque); }),
            "it refuses object 6072h: value of the parameter is too high (6090031h)");
  EXPECT_EQ(NameOf(kInterpolationExponent), "60C2h:2");
}

TEST_F(SdoClientTest, PassesOverWhatIsNoAnswer) {
  node->Say({.identifier = kSdoReply + kNode, .size = 8, .bytes = {0x60, 0x71, 0x60}});
  node->Say({.identifier = kSdoReply + kNode + 1, .size = 8, .bytes = {0x60, 0x72, 0x60}});
  node->Say({.identifier = kSdoReply + kNode, .remote = true, .size = 8});
  node->Say({.identifier = kSdoReply + kNode, .size = 3, .bytes = {0x60, 0x72, 0x60}});
  sdo.Download(kMaxTorque, 7);
  EXPECT_EQ(node->Get(kMaxTorque), 7U);
}

TEST_F(SdoClientTest, GivesUpOnASilentNodeInHalfASecond) {
  node->deaf = true;
  const int64_t begin_ns = FakeNow();
  EXPECT_THAT(ErrorOf([this] { sdo.Upload(kMaxTorque); }),
              AllOf(HasSubstr("does not answer for object 6072h"), HasSubstr("node number")));
  EXPECT_EQ(FakeNow() - begin_ns, 500'000'000);
}

TEST_F(SdoClientTest, GivesUpOnANodeThatOnlyTalksAboutOtherThings) {
  node->sdo_answer = [](const can::Frame& request) {
    can::Frame frame = request;
    frame.identifier = kSdoReply + kNode;
    frame.bytes[3] = 9;
    return frame;
  };
  EXPECT_THAT(ErrorOf([this] { sdo.Upload(kMaxTorque); }), HasSubstr("does not answer"));
}

TEST_F(SdoClientTest, SaysWhereAnObjectHasAnotherWidthAndWhereTheBusIsLost) {
  node->Set({.index = kMaxTorque.index, .subindex = 0, .size = 4}, 7);
  EXPECT_THAT(ErrorOf([this] { sdo.Upload(kMaxTorque); }), HasSubstr("6072h has not the 2 bytes"));
  FakeBus::lost = true;
  EXPECT_THAT(ErrorOf([this] { sdo.Upload(kMaxTorque); }), HasSubstr("the bus is lost"));
}

}  // namespace
}  // namespace mwidth::device::canopen
