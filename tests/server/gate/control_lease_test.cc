#include "server/gate/control_lease.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <set>

namespace mwidth::gate {
namespace {

using testing::HasSubstr;

constexpr int64_t kSecondNs = 1'000'000'000;
constexpr int64_t kNowNs = 77 * kSecondNs;

void ExpectRefusal(const std::optional<Refusal>& refusal, RefusalCode code, const std::string& reason) {
  ASSERT_TRUE(refusal.has_value());
  EXPECT_EQ(refusal->code, code);
  EXPECT_EQ(refusal->reason, reason);
}

class ControlLeaseTest : public testing::Test {
 protected:
  std::optional<Refusal> Acquire(const std::string& id, const std::string& holder, double ttl_s,
                                 int64_t now_ns) {
    const Result<Lease> lease = leases.Acquire(id, holder, ttl_s, now_ns);
    return lease.ok() ? std::nullopt : std::optional(lease.refusal());
  }

  ControlLease leases;
};

TEST_F(ControlLeaseTest, GivesAFreeAxisUntilTheTimeToLiveIsOver) {
  const Result<Lease> lease = leases.Acquire("a", "anna", 2, kNowNs);
  ASSERT_TRUE(lease.ok());
  EXPECT_EQ(lease->id, "a");
  EXPECT_EQ(lease->deadline_ns, kNowNs + 2 * kSecondNs);
  EXPECT_FALSE(leases.Check("a", kNowNs + 2 * kSecondNs - 1));
  ExpectRefusal(leases.Check("a", kNowNs + 2 * kSecondNs), RefusalCode::kFailedPrecondition, kNoLease);
}

TEST_F(ControlLeaseTest, IsHeldAgainstOthersAndAgainstItsOwnHolder) {
  ASSERT_FALSE(Acquire("a", "anna", 2, kNowNs));
  for (const char* name : {"bob", "anna"}) {
    const std::optional<Refusal> refusal = Acquire("b", name, 1, kNowNs + kSecondNs / 2);
    ExpectRefusal(refusal, RefusalCode::kFailedPrecondition, kControlHeld);
    EXPECT_THAT(refusal->message, HasSubstr("'anna' has control of this axis for another 1.5 s"));
    EXPECT_EQ(refusal->metadata.at("holder"), "anna");
    EXPECT_EQ(refusal->metadata.at("remaining_s"), "1.5");
  }
  EXPECT_FALSE(leases.Check("a", kNowNs + kSecondNs));
}

TEST_F(ControlLeaseTest, IsRenewedByItsTimeToLiveFromNow) {
  ASSERT_FALSE(Acquire("a", "anna", 2, kNowNs));
  const Result<Lease> renewed = leases.Renew("a", kNowNs + kSecondNs);
  ASSERT_TRUE(renewed.ok());
  EXPECT_EQ(renewed->deadline_ns, kNowNs + 3 * kSecondNs);
  EXPECT_FALSE(leases.Check("a", kNowNs + 3 * kSecondNs - 1));
}

TEST_F(ControlLeaseTest, IsGoneOnceExpired) {
  ASSERT_FALSE(Acquire("a", "anna", 1, kNowNs));
  const Result<Lease> renewed = leases.Renew("a", kNowNs + kSecondNs);
  ASSERT_FALSE(renewed.ok());
  EXPECT_EQ(renewed.refusal().reason, kNoLease);
  EXPECT_THAT(renewed.refusal().message, HasSubstr("expired"));
  EXPECT_EQ(leases.Holder(kNowNs + kSecondNs), "");
}

TEST_F(ControlLeaseTest, TellsALateHolderThatAnotherHasTakenTheAxis) {
  ASSERT_FALSE(Acquire("a", "anna", 1, kNowNs));
  ASSERT_FALSE(Acquire("b", "bob", 1, kNowNs + kSecondNs));
  const std::optional<Refusal> refusal = leases.Check("a", kNowNs + kSecondNs);
  ExpectRefusal(refusal, RefusalCode::kAborted, kLeaseLost);
  EXPECT_THAT(refusal->message, HasSubstr("'bob' has it now"));
  // Also when the other is gone too.
  ExpectRefusal(leases.Check("a", kNowNs + 9 * kSecondNs), RefusalCode::kAborted, kLeaseLost);
  EXPECT_EQ(leases.Holder(kNowNs + kSecondNs), "bob");
}

TEST_F(ControlLeaseTest, IsFreeAfterRelease) {
  ASSERT_FALSE(Acquire("a", "anna", 1, kNowNs));
  EXPECT_FALSE(leases.Release("a", kNowNs));
  EXPECT_FALSE(Acquire("b", "bob", 1, kNowNs));
  ExpectRefusal(leases.Release("a", kNowNs), RefusalCode::kFailedPrecondition, kNoLease);
  EXPECT_EQ(leases.Holder(kNowNs), "bob");
}

TEST_F(ControlLeaseTest, KnowsNobodyWithoutAnId) {
  ExpectRefusal(leases.Check("", kNowNs), RefusalCode::kFailedPrecondition, kNoLease);
  ASSERT_FALSE(Acquire("a", "anna", 1, kNowNs));
  ExpectRefusal(leases.Check("", kNowNs), RefusalCode::kFailedPrecondition, kNoLease);
  ExpectRefusal(leases.Check("A", kNowNs), RefusalCode::kFailedPrecondition, kNoLease);
}

TEST_F(ControlLeaseTest, LivesATenthOfASecondToAMinute) {
  for (const double ttl_s : {0.0, 0.0999, 60.001, -1.0, 1e300, std::numeric_limits<double>::infinity(),
                             std::numeric_limits<double>::quiet_NaN()}) {
    ExpectRefusal(Acquire("a", "anna", ttl_s, kNowNs), RefusalCode::kInvalidArgument, kInvalidNumber);
  }
  EXPECT_FALSE(Acquire("a", "anna", 0.1, kNowNs));
  EXPECT_FALSE(Acquire("b", "bob", 60, kNowNs + kSecondNs));
}

TEST_F(ControlLeaseTest, NamesItsHolderInAtMostAHundredBytes) {
  ExpectRefusal(Acquire("a", std::string(101, 'x'), 1, kNowNs), RefusalCode::kInvalidArgument, kInvalidText);
  EXPECT_FALSE(Acquire("a", std::string(100, 'x'), 1, kNowNs));
  EXPECT_FALSE(Acquire("b", "", 1, kNowNs + kSecondNs));
  EXPECT_EQ(leases.Holder(kNowNs + kSecondNs), "unnamed client");
}

TEST_F(ControlLeaseTest, ForgetsTheOldestOfManyLostLeases) {
  for (int i = 0; i < 100; ++i) {
    ASSERT_FALSE(Acquire(std::to_string(i), "anna", 1, kNowNs + i * kSecondNs));
  }
  ExpectRefusal(leases.Check("0", kNowNs), RefusalCode::kFailedPrecondition, kNoLease);
  ExpectRefusal(leases.Check("98", kNowNs), RefusalCode::kAborted, kLeaseLost);
}

TEST(RandomLeaseId, IsHexadecimalAndNeverTheSame) {
  std::set<std::string> ids;
  for (int i = 0; i < 1000; ++i) {
    const std::string id = RandomLeaseId();
    EXPECT_EQ(id.size(), 32U);
    EXPECT_EQ(id.find_first_not_of("0123456789abcdef"), std::string::npos);
    ids.insert(id);
  }
  EXPECT_EQ(ids.size(), 1000U);
}

}  // namespace
}  // namespace mwidth::gate
