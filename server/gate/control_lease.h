// Who may command an axis, and until when: the dead man's switch of its client.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include "server/gate/refusal.h"

namespace mwidth::gate {

inline constexpr double kMinLeaseTtlS = 0.1;
inline constexpr double kMaxLeaseTtlS = 60;
inline constexpr double kDefaultLeaseTtlS = 1;
inline constexpr std::size_t kMaxHolderBytes = 100;

/// The right to command an axis until `deadline_ns`, excluded. Times are the axis's clock, in nanoseconds.
struct Lease {
  /// Secret of the holder.
  std::string id;
  /// For people; two clients may share a name.
  std::string holder;
  int64_t ttl_ns = 0;
  int64_t deadline_ns = 0;
};

/// 128 random bits from the kernel as 32 hexadecimal digits. Throws std::runtime_error where the kernel has
/// none.
std::string RandomLeaseId();

/// The lease of one axis. The id is the identity: a client that forgot its id (it crashed, say) is a stranger
/// and waits for the lease to expire, whatever name it gives; a holder that asks again is refused like anyone
/// else, and renews instead. An expired lease is gone: renewing it would hide that the axis had already let
/// go. Not thread-safe; time is the caller's.
class ControlLease {
 public:
  /// Gives a free axis to `holder` under `id`. CONTROL_HELD while another lease is alive; INVALID_ARGUMENT
  /// for a time to live outside 0.1..60 s or a holder's name above 100 bytes. An empty name becomes "unnamed
  /// client".
  Result<Lease> Acquire(std::string id, std::string holder, double ttl_s, int64_t now_ns);
  /// Extends the lease by its time to live from now. Refused like Check.
  Result<Lease> Renew(const std::string& id, int64_t now_ns);
  /// Frees the axis. Refused like Check.
  std::optional<Refusal> Release(const std::string& id, int64_t now_ns);
  /// Why `id` may not command now, if so: FAILED_PRECONDITION (NO_LEASE) where it is no lease, or expired and
  /// the axis is free; ABORTED (LEASE_LOST) where another client has taken the axis since.
  std::optional<Refusal> Check(const std::string& id, int64_t now_ns) const;
  /// The holder's name; empty where the axis is free.
  std::string Holder(int64_t now_ns) const;

 private:
  bool Alive(int64_t now_ns) const { return lease_.has_value() && now_ns < lease_->deadline_ns; }

  std::optional<Lease> lease_;
  // Ids of leases that expired and were replaced, newest last: enough to tell a late client what happened.
  std::deque<std::string> lost_ids_;
};

}  // namespace mwidth::gate
