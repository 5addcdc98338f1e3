#include "device/emulator/socketcand_text.h"

#include <array>
#include <charconv>
#include <cstdint>
#include <cstdio>
#include <span>
#include <system_error>
#include <vector>

namespace mwidth::device::emulator {
namespace {

using Words = std::vector<std::string_view>;

Words Split(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r\n";
  Words words;
  while (true) {
    const std::size_t begin = text.find_first_not_of(kBlank);
    if (begin == std::string_view::npos) {
      return words;
    }
    text.remove_prefix(begin);
    const std::size_t size = std::min(text.find_first_of(kBlank), text.size());
    words.push_back(text.substr(0, size));
    text.remove_prefix(size);
  }
}

// A number in hexadecimal digits and nothing else, at most `max`.
std::optional<unsigned> Hex(std::string_view word, unsigned max) {
  constexpr int kBase = 16;
  unsigned value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value, kBase);
  if (error != std::errc() || end != word.data() + word.size() || value > max) {
    return std::nullopt;
  }
  return value;
}

// "send ID LENGTH BYTE..." or "sendrtr ID LENGTH".
std::optional<can::Frame> ParseFrame(std::span<const std::string_view> words, bool remote) {
  constexpr std::size_t kHeader = 3;
  // Eight digits mean an identifier of 29 bits, whatever its value.
  constexpr std::size_t kExtendedDigits = 8;
  constexpr unsigned kMaxByte = 0xFF;
  if (words.size() < kHeader || words[1].size() >= kExtendedDigits) {
    return std::nullopt;
  }
  const auto identifier = Hex(words[1], can::kMaxIdentifier);
  const auto size = Hex(words[2], can::kMaxFrameBytes);
  if (!identifier || !size || words.size() != kHeader + (remote ? 0 : *size)) {
    return std::nullopt;
  }
  can::Frame frame{.identifier = static_cast<uint16_t>(*identifier),
                   .remote = remote,
                   .size = static_cast<uint8_t>(*size)};
  for (std::size_t i = kHeader; i < words.size(); ++i) {
    const auto byte = Hex(words[i], kMaxByte);
    if (!byte) {
      return std::nullopt;
    }
    frame.bytes.at(i - kHeader) = static_cast<uint8_t>(*byte);
  }
  return frame;
}

}  // namespace

std::optional<std::string> TakeElement(std::string& text) {
  const std::size_t end = text.find('>');
  if (end == std::string::npos) {
    return std::nullopt;
  }
  const std::size_t begin = std::min(text.rfind('<', end), end);
  std::string element = text.substr(begin, end + 1 - begin);
  text.erase(0, end + 1);
  return element;
}

GatewayCommand ParseElement(std::string_view element) {
  GatewayCommand command;
  if (element.size() < 2 || element.front() != '<' || element.back() != '>') {
    return command;
  }
  const Words words = Split(element.substr(1, element.size() - 2));
  const std::string_view word = words.empty() ? std::string_view() : words[0];
  if (word == "open" && words.size() == 2) {
    command.word = GatewayWord::kOpen;
    command.bus = words[1];
  } else if (word == "rawmode") {
    command.word = GatewayWord::kRawMode;
  } else if (word == "bcmmode") {
    command.word = GatewayWord::kBcmMode;
  } else if (word == "echo") {
    command.word = GatewayWord::kEcho;
  } else if (word == "send" || word == "sendrtr") {
    if (const auto frame = ParseFrame(words, word == "sendrtr")) {
      command.word = GatewayWord::kSend;
      command.frame = *frame;
    }
  }
  return command;
}

std::string FrameElement(const can::Frame& frame, std::chrono::microseconds since_epoch) {
  constexpr int64_t kMicrosecondsInASecond = 1'000'000;
  std::array<char, 80> head{};
  std::snprintf(head.data(), head.size(), "< %s %03X %lld.%06lld ", frame.remote ? "rtr" : "frame",
                frame.identifier, static_cast<long long>(since_epoch.count() / kMicrosecondsInASecond),
                static_cast<long long>(since_epoch.count() % kMicrosecondsInASecond));
  std::string text(head.data());
  if (frame.remote) {
    text += std::to_string(frame.size);
  } else {
    for (const uint8_t byte : frame.data()) {
      constexpr std::string_view kDigits = "0123456789ABCDEF";
      text += kDigits.at(byte >> 4);
      text += kDigits.at(byte & 0xF);
    }
  }
  return text + " >";
}

}  // namespace mwidth::device::emulator
