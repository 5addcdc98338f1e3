#include "device/can/socketcand.h"

#include <algorithm>
#include <charconv>
#include <optional>

namespace mwidth::device::can {
namespace {

constexpr std::string_view kWhiteSpace = " \t\r\n";
constexpr int kHex = 16;

// Takes the next word off the front of `text`.
std::string_view TakeWord(std::string_view& text) noexcept {
  text.remove_prefix(std::min(text.find_first_not_of(kWhiteSpace), text.size()));
  const std::string_view word = text.substr(0, text.find_first_of(kWhiteSpace));
  text.remove_prefix(word.size());
  return word;
}

std::optional<uint32_t> Number(std::string_view word, int base) noexcept {
  uint32_t value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value, base);
  return error == std::errc() && end == word.data() + word.size() ? std::optional(value) : std::nullopt;
}

// Seconds with a point, which nobody here needs: the clock is another host's.
bool IsTime(std::string_view word) noexcept {
  return !word.empty() && word.find_first_not_of("0123456789.") == std::string_view::npos;
}

// Pairs of digits, with or without space between them.
bool TakeBytes(std::string_view text, Frame& frame) noexcept {
  for (std::string_view word = TakeWord(text); !word.empty(); word = TakeWord(text)) {
    for (; !word.empty(); word.remove_prefix(2)) {
      const auto byte = word.size() < 2 ? std::nullopt : Number(word.substr(0, 2), kHex);
      if (!byte || frame.size == kMaxFrameBytes) {
        return false;
      }
      frame.bytes.at(frame.size++) = static_cast<uint8_t>(*byte);
    }
  }
  return true;
}

ElementKind TakeFrame(std::string_view text, bool remote, Frame& frame) noexcept {
  // The gateway prints three digits or eight: their number tells the width of the identifier.
  constexpr std::size_t kClassicalDigits = 3;
  constexpr std::size_t kExtendedDigits = 8;
  const std::string_view digits = TakeWord(text);
  const auto identifier = Number(digits, kHex);
  if (!identifier || !IsTime(TakeWord(text))) {
    return ElementKind::kMalformed;
  }
  if (digits.size() == kExtendedDigits) {
    return ElementKind::kNotClassical;
  }
  if (digits.size() != kClassicalDigits || *identifier > kMaxIdentifier) {
    return ElementKind::kMalformed;
  }
  frame.identifier = static_cast<uint16_t>(*identifier);
  frame.remote = remote;
  if (!remote) {
    return TakeBytes(text, frame) ? ElementKind::kFrame : ElementKind::kMalformed;
  }
  const auto size = Number(TakeWord(text), 10);
  if (!size || *size > kMaxFrameBytes) {
    return ElementKind::kMalformed;
  }
  frame.size = static_cast<uint8_t>(*size);
  return ElementKind::kFrame;
}

// < error 040 1700000000.424242 > is of the bus, < error could not open bus > of the gateway.
ElementKind TakeError(std::string_view text) noexcept {
  constexpr uint32_t kBusOffClass = 0x40;  // CAN_ERR_BUSOFF of the kernel
  const auto error_class = Number(TakeWord(text), kHex);
  if (!error_class || !IsTime(TakeWord(text))) {
    return ElementKind::kRefusal;
  }
  return (*error_class & kBusOffClass) != 0 ? ElementKind::kBusOff : ElementKind::kErrorFrame;
}

ElementKind Judge(std::string_view inside, Frame& frame) noexcept {
  const std::string_view word = TakeWord(inside);
  if (word == "frame" || word == "rtr") {
    return TakeFrame(inside, word == "rtr", frame);
  }
  if (word == "fdframe") {
    return ElementKind::kNotClassical;
  }
  if (word == "error") {
    return TakeError(inside);
  }
  if (word == "hi") {
    return ElementKind::kHi;
  }
  return word == "ok" ? ElementKind::kOk : ElementKind::kMalformed;
}

Element Of(ElementKind kind, std::size_t size) noexcept { return {.kind = kind, .size = size, .frame = {}}; }

}  // namespace

Element FirstElement(std::string_view text) noexcept {
  const std::size_t first = std::min(text.find_first_not_of(kWhiteSpace), text.size());
  if (first == text.size()) {
    return Of(ElementKind::kIncomplete, first);
  }
  if (text[first] != '<') {
    return Of(ElementKind::kMalformed, std::min(text.find('<', first), text.size()));
  }
  const std::size_t last = text.find_first_of("<>", first + 1);
  const std::size_t size = std::min(last, text.size());
  if (size - first >= kMaxElementBytes || (last != std::string_view::npos && text[last] == '<')) {
    return Of(ElementKind::kMalformed, size);
  }
  if (last == std::string_view::npos) {
    return Of(ElementKind::kIncomplete, first);
  }
  Frame frame;
  const ElementKind kind = Judge(text.substr(first + 1, last - first - 1), frame);
  return kind == ElementKind::kFrame ? Element{kind, last + 1, frame} : Of(kind, last + 1);
}

SendElement ToSend(const Frame& frame) noexcept {
  SendElement element;
  const auto put = [&element](std::string_view text) {
    element.size += text.copy(element.text.data() + element.size, element.text.size() - element.size);
  };
  const auto put_hex = [&put](unsigned value, int digits) {
    constexpr std::string_view kDigits = "0123456789ABCDEF";
    for (int digit = digits - 1; digit >= 0; --digit) {
      put(kDigits.substr((value >> (4 * digit)) & 0xFU, 1));
    }
  };
  put(frame.remote ? "< sendrtr " : "< send ");
  put_hex(frame.identifier, 3);
  put(" ");
  put_hex(frame.size, 1);
  if (!frame.remote) {
    for (const uint8_t byte : frame.data()) {
      put(" ");
      put_hex(byte, 2);
    }
  }
  put(" >");
  return element;
}

}  // namespace mwidth::device::can
