// Identifiers and objects of CANopen (CiA 301) and of its drive profile (CiA 402), as far as they are used.
#pragma once

#include <cstdint>

namespace mwidth::device::canopen {

/// Identifiers of the predefined connection set (CiA 301, 7.3.5); those below kSync stand alone, to the
/// others the node's number is added.
inline constexpr uint16_t kNmt = 0x000;
inline constexpr uint16_t kSync = 0x080;
inline constexpr uint16_t kEmergency = 0x080;
inline constexpr uint16_t kTpdo1 = 0x180;
inline constexpr uint16_t kRpdo1 = 0x200;
inline constexpr uint16_t kRpdo2 = 0x300;
inline constexpr uint16_t kRpdo3 = 0x400;
inline constexpr uint16_t kRpdo4 = 0x500;
inline constexpr uint16_t kSdoReply = 0x580;
inline constexpr uint16_t kSdoRequest = 0x600;
inline constexpr uint16_t kHeartbeat = 0x700;

/// First byte of an NMT frame (CiA 301, 7.2.8.3.1); the second is the node's number.
enum class NmtCommand : uint8_t {
  kStart = 0x01,
  kStop = 0x02,
  kEnterPreOperational = 0x80,
  kResetNode = 0x81,
  kResetCommunication = 0x82,
};

/// The byte of a heartbeat (CiA 301, 7.2.8.3.2.2).
enum class NmtState : uint8_t {
  kBootUp = 0x00,
  kStopped = 0x04,
  kOperational = 0x05,
  kPreOperational = 0x7F,
};

/// An entry of the object dictionary, and how wide it is.
struct Object {
  uint16_t index = 0;
  uint8_t subindex = 0;
  /// Bytes, 1 to 4.
  uint8_t size = 4;

  bool operator==(const Object&) const = default;
};

inline constexpr Object kDeviceType{0x1000, 0, 4};
/// Milliseconds in bits 0 to 15, the number of the node that is watched in 16 to 22.
inline constexpr Object kConsumerHeartbeat{0x1016, 1, 4};
inline constexpr Object kProducerHeartbeat{0x1017, 0, 2};
inline constexpr Object kRpdo1Identifier{0x1400, 1, 4};
inline constexpr Object kRpdo2Identifier{0x1401, 1, 4};
inline constexpr Object kRpdo3Identifier{0x1402, 1, 4};
inline constexpr Object kRpdo4Identifier{0x1403, 1, 4};
inline constexpr Object kRpdo1Type{0x1400, 2, 1};
inline constexpr Object kRpdo1Count{0x1600, 0, 1};
inline constexpr Object kTpdo1Identifier{0x1800, 1, 4};
inline constexpr Object kTpdo1Type{0x1800, 2, 1};
inline constexpr Object kTpdo1Count{0x1A00, 0, 1};
/// Mapping entries have subindex 1 and on.
inline constexpr uint16_t kRpdo1Mapping = 0x1600;
inline constexpr uint16_t kTpdo1Mapping = 0x1A00;

inline constexpr Object kConnectionLossOption{0x6007, 0, 2};
inline constexpr Object kErrorCode{0x603F, 0, 2};
inline constexpr Object kControlword{0x6040, 0, 2};
inline constexpr Object kStatusword{0x6041, 0, 2};
inline constexpr Object kQuickStopOption{0x605A, 0, 2};
inline constexpr Object kModeOfOperation{0x6060, 0, 1};
inline constexpr Object kModeDisplay{0x6061, 0, 1};
inline constexpr Object kPosition{0x6064, 0, 4};
/// Torques are in thousandths of kRatedTorque.
inline constexpr Object kTargetTorque{0x6071, 0, 2};
inline constexpr Object kMaxTorque{0x6072, 0, 2};
/// mN m, or mN for a linear motor.
inline constexpr Object kRatedTorque{0x6076, 0, 4};
inline constexpr Object kTorque{0x6077, 0, 2};
/// Bit n - 1 is set where the drive knows mode n.
inline constexpr Object kSupportedModes{0x6502, 0, 4};
/// Added to every target torque.
inline constexpr Object kTorqueOffset{0x60B2, 0, 2};
inline constexpr Object kInterpolationPeriod{0x60C2, 1, 1};
/// The power of ten, in seconds, that the period counts.
inline constexpr Object kInterpolationExponent{0x60C2, 2, 1};

/// Bits 0 to 15 of the device type of a drive.
inline constexpr uint16_t kDriveProfile = 402;
/// Mode of operation: the force of every RPDO acts as it comes.
inline constexpr uint8_t kCyclicSynchronousTorque = 10;
/// Transmission types: a TPDO with every SYNC or an RPDO that the next SYNC makes act; an RPDO that acts at
/// once.
inline constexpr uint8_t kOnEverySync = 1;
inline constexpr uint8_t kEventDriven = 255;
/// Set in the identifier of a PDO that does not exist.
inline constexpr uint32_t kPdoInvalid = 0x8000'0000;

}  // namespace mwidth::device::canopen
