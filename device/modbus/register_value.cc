#include "device/modbus/register_value.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace mwidth::device::modbus {
namespace {

uint16_t Swapped(uint16_t word) noexcept { return static_cast<uint16_t>(word << 8 | word >> 8); }

bool SwapsBytes(WordOrder order) noexcept { return order == WordOrder::kBadc || order == WordOrder::kDcba; }
bool LowWordFirst(WordOrder order) noexcept { return order == WordOrder::kCdab || order == WordOrder::kDcba; }

template <typename Integer>
double Largest() noexcept {
  return static_cast<double>(std::numeric_limits<Integer>::max());
}
template <typename Integer>
double Smallest() noexcept {
  return static_cast<double>(std::numeric_limits<Integer>::lowest());
}

// Two's complement of a rounded raw value that is in range.
uint32_t Bits(const RegisterValue& value, double raw) noexcept {
  if (value.type == RegisterType::kFloat32) {
    return std::bit_cast<uint32_t>(static_cast<float>(raw));
  }
  return static_cast<uint32_t>(static_cast<int64_t>(std::nearbyint(raw)));
}

}  // namespace

std::size_t RegisterValue::Registers() const noexcept {
  return type == RegisterType::kInt16 || type == RegisterType::kUint16 ? 1 : 2;
}

int RegisterValue::CounterBits() const noexcept {
  if (type == RegisterType::kFloat32) {
    return 0;
  }
  return Registers() == 1 ? 16 : 32;
}

double RegisterValue::RawMin() const noexcept {
  switch (type) {
    case RegisterType::kInt16:
      return Smallest<int16_t>();
    case RegisterType::kInt32:
      return Smallest<int32_t>();
    case RegisterType::kFloat32:
      return Smallest<float>();
    case RegisterType::kUint16:
    case RegisterType::kUint32:
      break;
  }
  return 0;
}

double RegisterValue::RawMax() const noexcept {
  switch (type) {
    case RegisterType::kInt16:
      return Largest<int16_t>();
    case RegisterType::kUint16:
      return Largest<uint16_t>();
    case RegisterType::kInt32:
      return Largest<int32_t>();
    case RegisterType::kUint32:
      return Largest<uint32_t>();
    case RegisterType::kFloat32:
      break;
  }
  return Largest<float>();
}

double Decode(const RegisterValue& value, std::span<const uint16_t> words) noexcept {
  std::array<uint16_t, kMaxValueRegisters> in_order{};
  for (std::size_t i = 0; i < value.Registers(); ++i) {
    in_order[i] = SwapsBytes(value.order) ? Swapped(words[i]) : words[i];
  }
  if (value.type == RegisterType::kInt16) {
    return static_cast<int16_t>(in_order[0]);
  }
  if (value.type == RegisterType::kUint16) {
    return in_order[0];
  }
  const auto [high, low] =
      LowWordFirst(value.order) ? std::pair(in_order[1], in_order[0]) : std::pair(in_order[0], in_order[1]);
  const uint32_t bits = static_cast<uint32_t>(high) << 16 | low;
  switch (value.type) {
    case RegisterType::kInt32:
      return static_cast<int32_t>(bits);
    case RegisterType::kFloat32:
      return std::bit_cast<float>(bits);
    default:
      return bits;
  }
}

std::array<uint16_t, kMaxValueRegisters> Encode(const RegisterValue& value, double raw) noexcept {
  const double in_range = std::isnan(raw) ? 0 : std::clamp(raw, value.RawMin(), value.RawMax());
  const uint32_t bits = Bits(value, in_range);
  std::array<uint16_t, kMaxValueRegisters> words{static_cast<uint16_t>(bits >> 16),
                                                 static_cast<uint16_t>(bits & 0xFFFF)};
  if (value.Registers() == 1) {
    words = {words[1], 0};
  } else if (LowWordFirst(value.order)) {
    std::swap(words[0], words[1]);
  }
  if (SwapsBytes(value.order)) {
    for (std::size_t i = 0; i < value.Registers(); ++i) {
      words[i] = Swapped(words[i]);
    }
  }
  return words;
}

}  // namespace mwidth::device::modbus
