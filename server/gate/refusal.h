// How the gate says no: a code for programs, a sentence for people.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "server/gate/stability_report.h"

namespace mwidth::gate {

/// The kind of a refusal: what a caller can do about it. Named after the gRPC codes that they become.
enum class RefusalCode : uint8_t {
  kInvalidArgument,     // ask for something else
  kFailedPrecondition,  // change the state first
  kAborted,             // start over: somebody else took control
  kNotFound,            // no such axis
  kPermissionDenied,    // another role
  kResourceExhausted,   // fewer or smaller requests
  kUnavailable,         // the loop does not answer, or the server stops
  kDataLoss,            // what was recorded cannot be read
};

// Reasons, as programs read them. Part of the API: never renamed.
inline constexpr const char* kInvalidNumber = "INVALID_NUMBER";
inline constexpr const char* kInvalidText = "INVALID_TEXT";
inline constexpr const char* kMassLimit = "MASS_LIMIT";
inline constexpr const char* kUnstableMass = "UNSTABLE_MASS";
inline constexpr const char* kNoisyMass = "NOISY_MASS";
inline constexpr const char* kNoLease = "NO_LEASE";
inline constexpr const char* kLeaseLost = "LEASE_LOST";
inline constexpr const char* kControlHeld = "CONTROL_HELD";
inline constexpr const char* kWrongState = "WRONG_STATE";
inline constexpr const char* kRenderingBlocked = "RENDERING_BLOCKED";
inline constexpr const char* kLoopSilent = "LOOP_SILENT";
inline constexpr const char* kUnknownAxis = "UNKNOWN_AXIS";
inline constexpr const char* kAmbiguousAxis = "AMBIGUOUS_AXIS";
inline constexpr const char* kTooManyStreams = "TOO_MANY_STREAMS";
inline constexpr const char* kTooManyComputations = "TOO_MANY_COMPUTATIONS";
inline constexpr const char* kShuttingDown = "SHUTTING_DOWN";
inline constexpr const char* kNoSession = "NO_SESSION";
inline constexpr const char* kSessionOpen = "SESSION_OPEN";
inline constexpr const char* kSessionExists = "SESSION_EXISTS";
inline constexpr const char* kUnknownSession = "UNKNOWN_SESSION";
inline constexpr const char* kUnreadableSession = "UNREADABLE_SESSION";
inline constexpr const char* kStorageFull = "STORAGE_FULL";
inline constexpr const char* kStorageFailed = "STORAGE_FAILED";

/// A request that was not granted; nothing has changed unless the message says so.
struct Refusal {
  RefusalCode code = RefusalCode::kFailedPrecondition;
  /// One of the constants above.
  std::string reason;
  /// What is wrong and what to do next, for a person.
  std::string message;
  /// The figures of the message, for a program.
  std::map<std::string, std::string> metadata{};
  /// With UNSTABLE_MASS and NOISY_MASS.
  std::optional<StabilityReport> stability{};
};

/// A value, or the refusal in its place. (std::expected is C++23.)
template <typename T>
class Result {
 public:
  Result(T value) : content_(std::in_place_index<0>, std::move(value)) {}            // NOLINT(*-explicit-*)
  Result(Refusal refusal) : content_(std::in_place_index<1>, std::move(refusal)) {}  // NOLINT(*-explicit-*)

  bool ok() const { return content_.index() == 0; }
  /// Precondition: ok(); throws std::bad_variant_access otherwise.
  const T& value() const { return std::get<0>(content_); }
  const T& operator*() const { return value(); }
  const T* operator->() const { return &value(); }
  /// Precondition: !ok(); throws std::bad_variant_access otherwise.
  const Refusal& refusal() const { return std::get<1>(content_); }

 private:
  std::variant<T, Refusal> content_;
};

}  // namespace mwidth::gate
