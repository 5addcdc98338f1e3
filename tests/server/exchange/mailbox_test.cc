#include "server/exchange/mailbox.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <thread>

namespace mwidth::exchange {
namespace {

// Several cache lines, so that a torn copy would show.
struct Words {
  std::array<uint64_t, 24> value{};
};

Words AllEqualTo(uint64_t value) {
  Words words;
  words.value.fill(value);
  return words;
}

TEST(MailboxTest, IsEmptyUntilSomethingIsPosted) {
  Mailbox<int> mailbox;
  int value = 7;
  EXPECT_FALSE(mailbox.Take(value));
  EXPECT_EQ(value, 7);
}

TEST(MailboxTest, GivesTheNewestOnce) {
  Mailbox<int> mailbox;
  mailbox.Post(1);
  mailbox.Post(2);
  mailbox.Post(3);
  int value = 0;
  EXPECT_TRUE(mailbox.Take(value));
  EXPECT_EQ(value, 3);
  EXPECT_FALSE(mailbox.Take(value));
  mailbox.Post(4);
  EXPECT_TRUE(mailbox.Take(value));
  EXPECT_EQ(value, 4);
}

TEST(MailboxTest, HoldsWhatWasLastTakenForAReaderThatIsMadeAnew) {
  Mailbox<int> mailbox;
  EXPECT_EQ(mailbox.Held(), 0);
  for (int i = 1; i < 10; ++i) {
    mailbox.Post(100 + i);
    mailbox.Post(i);
    EXPECT_EQ(mailbox.Held(), i - 1);
    int value = 0;
    mailbox.Take(value);
    EXPECT_EQ(mailbox.Held(), i);
  }
}

TEST(MailboxTest, NeverTearsNorGoesBackNorLosesTheLastUnderTwoThreads) {
  constexpr uint64_t kPosts = 200'000;
  Mailbox<Words> mailbox;
  std::thread writer([&mailbox] {
    for (uint64_t i = 1; i <= kPosts; ++i) {
      mailbox.Post(AllEqualTo(i));
    }
  });
  uint64_t last = 0;
  uint64_t torn = 0;
  uint64_t backwards = 0;
  while (last < kPosts) {
    Words words;
    if (!mailbox.Take(words)) {
      continue;
    }
    torn += words.value != AllEqualTo(words.value[0]).value ? 1 : 0;
    backwards += words.value[0] <= last ? 1 : 0;
    last = words.value[0];
  }
  writer.join();
  EXPECT_EQ(torn, 0);
  EXPECT_EQ(backwards, 0);
  Words words;
  EXPECT_FALSE(mailbox.Take(words));
}

}  // namespace
}  // namespace mwidth::exchange
