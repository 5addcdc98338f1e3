// Numbers as they lie in registers.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace mwidth::device::modbus {

/// How a number is coded.
enum class RegisterType : uint8_t { kInt16, kUint16, kInt32, kUint32, kFloat32 };

/// In which order the four bytes of a number of 32 bits lie in its two registers, A being the most
/// significant. Modbus leaves it open, and drives differ. Numbers of 16 bits have their two bytes in order,
/// swapped with kBadc and kDcba.
enum class WordOrder : uint8_t { kAbcd, kCdab, kBadc, kDcba };

/// "int16", "uint16", "int32", "uint32", "float32", in the order of the enumeration.
inline constexpr std::array<const char*, 5> kRegisterTypeNames{"int16", "uint16", "int32", "uint32",
                                                               "float32"};
/// "ABCD", "CDAB", "BADC", "DCBA".
inline constexpr std::array<const char*, 4> kWordOrderNames{"ABCD", "CDAB", "BADC", "DCBA"};

/// Most registers that one number takes.
inline constexpr std::size_t kMaxValueRegisters = 2;

/// One number of a drive: raw value times `scale` plus `offset` is the quantity.
struct RegisterValue {
  uint16_t address = 0;
  RegisterType type = RegisterType::kInt16;
  WordOrder order = WordOrder::kAbcd;
  /// Quantity of one count; not 0, finite. Negative where the drive counts the other way.
  double scale = 1;
  /// Quantity of raw 0; finite.
  double offset = 0;

  /// Registers that it takes, 1 or 2.
  std::size_t Registers() const noexcept;
  /// Bits of a counter of this type; 0 for float32, which is none.
  int CounterBits() const noexcept;
  /// Smallest and largest raw value.
  double RawMin() const noexcept;
  double RawMax() const noexcept;
};

/// The raw value in the first Registers() words of `words`, exactly; a float32 that is no number comes as
/// one. Rt.
double Decode(const RegisterValue& value, std::span<const uint16_t> words) noexcept;
/// The words of the raw value nearest to `raw`, cut to what the type holds; NaN codes as 0. Rt.
std::array<uint16_t, kMaxValueRegisters> Encode(const RegisterValue& value, double raw) noexcept;

}  // namespace mwidth::device::modbus
