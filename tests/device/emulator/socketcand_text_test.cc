#include "device/emulator/socketcand_text.h"

#include <gtest/gtest.h>

#include <chrono>
#include <random>
#include <string>

namespace mwidth::device::emulator {
namespace {

using can::Frame;

TEST(TakeElement, TakesOneAfterTheOther) {
  std::string text = "< open can0 >\n< rawmode >< se";
  EXPECT_EQ(TakeElement(text), "< open can0 >");
  EXPECT_EQ(TakeElement(text), "< rawmode >");
  EXPECT_EQ(TakeElement(text), std::nullopt);
  EXPECT_EQ(text, "< se");
  text += "nd 123 0 >";
  EXPECT_EQ(TakeElement(text), "< send 123 0 >");
  EXPECT_TRUE(text.empty());
}

TEST(TakeElement, PassesOverWhatIsNone) {
  std::string text = "noise > < lost < echo >";
  EXPECT_EQ(TakeElement(text), ">");
  EXPECT_EQ(TakeElement(text), "< echo >");
}

TEST(ParseElement, KnowsTheWordsOfTheProtocol) {
  EXPECT_EQ(ParseElement("< open can0 >").word, GatewayWord::kOpen);
  EXPECT_EQ(ParseElement("< open can0 >").bus, "can0");
  EXPECT_EQ(ParseElement("< rawmode >").word, GatewayWord::kRawMode);
  EXPECT_EQ(ParseElement("< bcmmode >").word, GatewayWord::kBcmMode);
  EXPECT_EQ(ParseElement("<echo>").word, GatewayWord::kEcho);
}

TEST(ParseElement, ReadsFrames) {
  const auto command = ParseElement("< send 7fF 3 1 F1 0a >");
  EXPECT_EQ(command.word, GatewayWord::kSend);
  EXPECT_EQ(command.frame, (Frame{.identifier = 0x7FF, .size = 3, .bytes = {1, 0xF1, 0x0A}}));
  // As python-can writes it: two blanks where there are no bytes.
  EXPECT_EQ(ParseElement("< send 80 0  >").frame, (Frame{.identifier = 0x80}));
  EXPECT_EQ(ParseElement("< sendrtr 123 2 >").frame, (Frame{.identifier = 0x123, .remote = true, .size = 2}));
}

TEST(ParseElement, RefusesWhatIsNoFrameOfElevenBits) {
  for (const char* element : {"",
                              "<",
                              "<>",
                              "< >",
                              "send 123 0",
                              "< send >",
                              "< send 123 >",
                              "< send 800 0 >",
                              "< send 00000123 0 >",
                              "< send 123 9 1 2 3 4 5 6 7 8 9 >",
                              "< send 123 2 1 >",
                              "< send 123 1 1 2 >",
                              "< send 123 1 100 >",
                              "< send 123 1 -1 >",
                              "< send 123 1 0x1 >",
                              "< send -1 0 >",
                              "< send 12g 0 >",
                              "< sendrtr 123 1 1 >",
                              "< open >",
                              "< open can0 can1 >",
                              "< subscribe 0 0 123 >"}) {
    EXPECT_EQ(ParseElement(element).word, GatewayWord::kUnknown) << element;
  }
}

TEST(ParseElement, SurvivesAnyText) {
  std::mt19937 random(7);
  constexpr std::string_view kLetters = "< >sendrt123 0aF\n\t-x";
  for (int i = 0; i < 200'000; ++i) {
    std::string text = "< send ";
    for (std::size_t n = random() % 30; n > 0; --n) {
      text += kLetters.at(random() % kLetters.size());
    }
    while (const auto element = TakeElement(text)) {
      const auto command = ParseElement(*element);
      EXPECT_LE(command.frame.identifier, can::kMaxIdentifier);
      EXPECT_LE(command.frame.size, can::kMaxFrameBytes);
    }
  }
}

TEST(FrameElement, SaysWhoAndWhenAndWhat) {
  using std::chrono::microseconds;
  // The example of the protocol's description.
  EXPECT_EQ(FrameElement({.identifier = 0x123, .size = 4, .bytes = {0x11, 0x22, 0x33, 0x44}},
                         microseconds(23'424'242)),
            "< frame 123 23.424242 11223344 >");
  EXPECT_EQ(FrameElement({.identifier = 0x80}, microseconds(1'000'007)), "< frame 080 1.000007  >");
  EXPECT_EQ(FrameElement({.identifier = 0x123, .remote = true, .size = 4}, microseconds(23'424'242)),
            "< rtr 123 23.424242 4 >");
}

}  // namespace
}  // namespace mwidth::device::emulator
