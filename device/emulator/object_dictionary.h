// The object dictionary of an emulated CANopen node (CiA 301, section 7.4): numbers of up to 4 bytes.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <vector>

namespace mwidth::device::emulator {

/// Why a transfer is refused: the abort codes of CiA 301, table 22.
enum class SdoAbort : uint32_t {
  kNone = 0,
  kUnknownCommand = 0x0504'0001,
  kUnsupportedAccess = 0x0601'0000,
  kReadOnly = 0x0601'0002,
  kNoObject = 0x0602'0000,
  kNotMappable = 0x0604'0041,
  kPdoTooLong = 0x0604'0042,
  kTooLong = 0x0607'0012,
  kTooShort = 0x0607'0013,
  kNoSubindex = 0x0609'0011,
  kInvalidValue = 0x0609'0030,
  kTooHigh = 0x0609'0031,
  kTooLow = 0x0609'0032,
  kGeneral = 0x0800'0000,
};

struct ObjectId {
  uint16_t index = 0;
  uint8_t subindex = 0;

  // NOLINTNEXTLINE(modernize-use-nullptr): the 0 that a rewritten comparison is compared with
  auto operator<=>(const ObjectId&) const = default;
};

enum class Access : uint8_t { kReadOnly, kReadWrite };

struct Object {
  /// 1, 2 or 4.
  uint8_t bytes = 4;
  bool is_signed = false;
  Access access = Access::kReadOnly;
  /// Whether it may travel in a PDO.
  bool mappable = false;
  /// At power-on, and now.
  int64_t initial = 0;
  /// What may be written; none: all that the bytes can hold.
  std::optional<int64_t> min{};
  std::optional<int64_t> max{};
  /// Tells the value where it is not one that was stored.
  std::function<int64_t()> read{};
  /// Judges a value in range before it is stored, and acts on it.
  std::function<SdoAbort(int64_t)> write{};
};

/// Lives in one thread.
class ObjectDictionary {
 public:
  /// Objects are added before anything else is done.
  void Add(ObjectId id, Object object);

  /// The object itself; none where there is no such.
  const Object* Find(ObjectId id) const;
  /// The value of an object that exists. Throws std::out_of_range.
  int64_t Get(ObjectId id) const;
  /// Stores a value unasked.
  void Set(ObjectId id, int64_t value);

  /// The bytes of an object, the least significant first.
  SdoAbort Read(ObjectId id, std::vector<uint8_t>& bytes) const;
  SdoAbort Write(ObjectId id, std::span<const uint8_t> bytes);
  /// What a reset does to all objects from index `first` to `last`.
  void Reset(uint16_t first, uint16_t last);

 private:
  struct Stored {
    Object object;
    int64_t value = 0;
  };

  /// kNone where the object exists.
  SdoAbort Missing(ObjectId id) const;

  std::map<ObjectId, Stored> objects_;
};

/// A number as its bytes, the least significant first.
std::vector<uint8_t> ToBytes(int64_t value, std::size_t bytes);
int64_t FromBytes(std::span<const uint8_t> bytes, bool is_signed);

}  // namespace mwidth::device::emulator
