#include "device/can/socketcand.h"

#include <gtest/gtest.h>

#include <random>
#include <string>

namespace mwidth::device::can {
namespace {

ElementKind KindOf(std::string_view text) { return FirstElement(text).kind; }

TEST(Socketcand, ReadsAFrame) {
  const std::string text = "< frame 181 1700000000.424242 270604FFFFFF0000 >";
  const Element element = FirstElement(text);
  ASSERT_EQ(element.kind, ElementKind::kFrame);
  EXPECT_EQ(element.size, text.size());
  EXPECT_EQ(element.frame,
            (Frame{.identifier = 0x181, .size = 8, .bytes = {0x27, 0x06, 0x04, 0xFF, 0xFF, 0xFF, 0, 0}}));
}

TEST(Socketcand, ReadsFramesOfEverySizeInBothSpellings) {
  std::string joined;
  std::string apart;
  for (uint8_t size = 0; size <= kMaxFrameBytes; ++size) {
    // The daemon itself prints two spaces where there are no bytes.
    for (const std::string& bytes : {joined, apart}) {
      const Element element = FirstElement("< frame 7ff 1.5 " + bytes + " >");
      ASSERT_EQ(element.kind, ElementKind::kFrame) << bytes;
      EXPECT_EQ(element.frame.identifier, 0x7FF);
      EXPECT_EQ(element.frame.size, size);
      EXPECT_EQ(element.frame.bytes[7], size == 8 ? 0xA7 : 0);
    }
    joined += "A" + std::to_string(size);
    apart += " a" + std::to_string(size);
  }
  EXPECT_EQ(KindOf("< frame 7FF 1.5 " + joined + " >"), ElementKind::kMalformed);
}

TEST(Socketcand, ReadsARemoteFrame) {
  const Element element = FirstElement("< rtr 701 23.424242 4 >");
  ASSERT_EQ(element.kind, ElementKind::kFrame);
  EXPECT_EQ(element.frame, (Frame{.identifier = 0x701, .remote = true, .size = 4, .bytes = {}}));
  EXPECT_EQ(KindOf("< rtr 701 23.424242 9 >"), ElementKind::kMalformed);
}

TEST(Socketcand, KnowsTheOtherElements) {
  EXPECT_EQ(KindOf("< hi >"), ElementKind::kHi);
  EXPECT_EQ(KindOf("< ok >"), ElementKind::kOk);
  EXPECT_EQ(KindOf("<ok>"), ElementKind::kOk);
  EXPECT_EQ(KindOf("< error could not open bus >"), ElementKind::kRefusal);
  EXPECT_EQ(KindOf("< error 004 1700000000.424242 >"), ElementKind::kErrorFrame);
  EXPECT_EQ(KindOf("< error 040 1700000000.424242 >"), ElementKind::kBusOff);
  EXPECT_EQ(KindOf("< error 044 1700000000.424242 >"), ElementKind::kBusOff);
  EXPECT_EQ(KindOf("< frame 00000181 1.5 00 >"), ElementKind::kNotClassical);
  EXPECT_EQ(KindOf("< fdframe 181 04 1.5 00112233445566778899 >"), ElementKind::kNotClassical);
}

TEST(Socketcand, TakesNothingThatIsAlmostAFrame) {
  for (const char* const text :
       {"< frame 800 1.5 00 >", "< frame 1G1 1.5 00 >", "< frame 81 1.5 00 >", "< frame 0x1 1.5 00 >",
        "< frame -81 1.5 00 >", "< frame 181 00 11 2 >", "< frame 181 1.5 0 >", "< frame 181 1.5 0x11 >",
        "< frame 181 1.5 +1 >", "< frame 181 now 00 >", "< frame 181 >", "< frame >", "< >", "<>",
        "< stat 1 2 3 4 >", "< frame 181 1.5 00\xFF >"}) {
    const Element element = FirstElement(text);
    EXPECT_EQ(element.kind, ElementKind::kMalformed) << text;
    EXPECT_EQ(element.size, std::string_view(text).size()) << text;
    EXPECT_EQ(element.frame, Frame{}) << text;
  }
}

TEST(Socketcand, WaitsForTheRestOfAnElement) {
  const std::string text = "< frame 181 1700000000.424242 2706 >";
  for (std::size_t size = 0; size < text.size(); ++size) {
    const Element element = FirstElement(text.substr(0, size));
    EXPECT_EQ(element.kind, ElementKind::kIncomplete);
    EXPECT_EQ(element.size, 0U);
  }
  EXPECT_EQ(FirstElement(" \r\n").size, 3U);
}

TEST(Socketcand, TakesOneElementAtATimeAndFindsTheNextBehindRubbish) {
  std::string text = "\n< ok >rubbish < frame 18< frame 181 1.5 07 >";
  std::vector<ElementKind> kinds;
  while (true) {
    const Element element = FirstElement(text);
    if (element.kind == ElementKind::kIncomplete) {
      break;
    }
    kinds.push_back(element.kind);
    text.erase(0, element.size);
  }
  EXPECT_EQ(kinds, (std::vector{ElementKind::kOk, ElementKind::kMalformed, ElementKind::kMalformed,
                                ElementKind::kFrame}));
}

TEST(Socketcand, GivesUpOnAnElementWithoutAnEnd) {
  EXPECT_EQ(KindOf("< " + std::string(kMaxElementBytes - 3, 'a')), ElementKind::kIncomplete);
  EXPECT_EQ(KindOf("< " + std::string(kMaxElementBytes, 'a')), ElementKind::kMalformed);
}

TEST(Socketcand, WritesWhatTheGatewayReads) {
  EXPECT_EQ(ToSend({.identifier = 0x80}).view(), "< send 080 0 >");
  EXPECT_EQ(ToSend({.identifier = 0x201, .size = 4, .bytes = {0x0F, 0, 0x9C, 0xFF}}).view(),
            "< send 201 4 0F 00 9C FF >");
  EXPECT_EQ(ToSend({.identifier = 0x7FF, .size = 8, .bytes = {1, 2, 3, 4, 5, 6, 7, 8}}).view(),
            "< send 7FF 8 01 02 03 04 05 06 07 08 >");
  EXPECT_EQ(ToSend({.identifier = 0x701, .remote = true, .size = 1}).view(), "< sendrtr 701 1 >");
}

TEST(Socketcand, AnyBytesAreSomethingAndComeToAnEnd) {
  std::mt19937 random(20120710);
  const std::string alphabet = "<> frame10AFerrok.\n\xFF";
  for (int round = 0; round < 20'000; ++round) {
    std::string text;
    for (std::size_t i = random() % 300; i > 0; --i) {
      text += alphabet[random() % alphabet.size()];
    }
    while (true) {
      const Element element = FirstElement(text);
      ASSERT_LE(element.size, text.size());
      text.erase(0, element.size);
      if (element.kind == ElementKind::kIncomplete) {
        break;
      }
      ASSERT_GT(element.size, 0U);
    }
    ASSERT_LT(text.size(), kMaxElementBytes);
  }
}

}  // namespace
}  // namespace mwidth::device::can
