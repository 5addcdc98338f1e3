// Process data objects of an emulated CANopen node (CiA 301, sections 7.2.2 and 7.5.2.35 and on).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "device/can/frame.h"
#include "device/emulator/object_dictionary.h"

namespace mwidth::device::emulator {

/// Seen from the node.
enum class PdoDirection : uint8_t { kReceive, kTransmit };

struct PdoConfig {
  PdoDirection direction = PdoDirection::kReceive;
  /// Index of the communication parameter: 1400h or 1800h and on. The mapping's is 200h above.
  uint16_t index = 0;
  /// At power-on.
  uint16_t identifier = 0;
  uint8_t type = 1;
  /// Objects as a mapping has them: index, subindex, length in bits.
  std::vector<uint32_t> mapping;
};

/// One PDO, set up by SDO as CiA 301 wants it: made invalid, its mapping taken away, written, counted, and
/// made valid again. All its state lies in the object dictionary.
class Pdo {
 public:
  static constexpr uint8_t kLastSynchronous = 240;

  /// Adds its objects to `objects`, which outlives it.
  Pdo(ObjectDictionary& objects, const PdoConfig& config);

  bool valid() const;
  uint16_t identifier() const;
  /// Whether SYNC makes it act, or is what it answers; else a receive PDO acts as it comes.
  bool synchronous() const { return type() <= kLastSynchronous; }
  /// Of a transmit PDO: every how many-th SYNC it answers.
  uint8_t type() const;

  /// The frame of a transmit PDO. `wrong_order`: with the halves of 32-bit numbers exchanged.
  can::Frame Pack(bool wrong_order) const;
  /// Writes what a receive PDO brings; false where it brings too little.
  bool Unpack(const can::Frame& frame);

 private:
  struct Mapped {
    ObjectId id;
    std::size_t bytes = 0;
  };

  void AddCommunication(const PdoConfig& config);
  void AddMapping(const PdoConfig& config);
  SdoAbort JudgeIdentifier(int64_t value) const;
  SdoAbort JudgeType(int64_t value) const;
  SdoAbort JudgeEntry(int64_t value) const;
  SdoAbort JudgeCount(int64_t count) const;
  /// None where the object cannot travel this way.
  std::optional<Mapped> Parse(int64_t entry) const;
  std::vector<Mapped> Mapping() const;

  ObjectDictionary& objects_;
  const PdoDirection direction_;
  const uint16_t index_;
};

}  // namespace mwidth::device::emulator
