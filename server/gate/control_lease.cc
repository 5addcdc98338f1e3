#include "server/gate/control_lease.h"

#include <sys/random.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "server/gate/figures.h"

namespace mwidth::gate {
namespace {

constexpr double kNsPerS = 1e9;
constexpr std::size_t kRememberedIds = 64;
constexpr std::string_view kHex = "0123456789abcdef";

Refusal NoLease(std::string message) {
  return {.code = RefusalCode::kFailedPrecondition, .reason = kNoLease, .message = std::move(message)};
}

std::optional<Refusal> CheckRequest(const std::string& holder, double ttl_s) {
  if (!(ttl_s >= kMinLeaseTtlS && ttl_s <= kMaxLeaseTtlS)) {
    return Refusal{
        .code = RefusalCode::kInvalidArgument,
        .reason = kInvalidNumber,
        .message = "ttl is " + Figure(ttl_s) + " s: ask for 0.1 to 60 s, or leave it unset for 1 s.",
        .metadata = {{"field", "ttl"}, {"value", Figure(ttl_s)}, {"allowed", "0.1 to 60 s"}}};
  }
  if (holder.size() > kMaxHolderBytes) {
    return Refusal{
        .code = RefusalCode::kInvalidArgument,
        .reason = kInvalidText,
        .message = "client_name has " + std::to_string(holder.size()) + " bytes: give at most 100.",
        .metadata = {{"field", "client_name"}, {"allowed", "at most 100 bytes"}}};
  }
  // It is shown on terminals and in logs.
  if (std::any_of(holder.begin(), holder.end(),
                  [](unsigned char byte) { return byte < ' ' || byte == 0x7f; })) {
    return Refusal{.code = RefusalCode::kInvalidArgument,
                   .reason = kInvalidText,
                   .message = "client_name has control characters: give a name on one line.",
                   .metadata = {{"field", "client_name"}, {"allowed", "no control characters"}}};
  }
  return std::nullopt;
}

}  // namespace

std::string RandomLeaseId() {
  std::array<unsigned char, 16> bytes{};
  // Up to 256 bytes come whole once the kernel's pool is initialised.
  if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
    throw std::runtime_error("the kernel gave no random bytes for a lease id");
  }
  std::string id;
  for (const unsigned int byte : bytes) {
    id += kHex[byte >> 4U];
    id += kHex[byte & 15U];
  }
  return id;
}

Result<Lease> ControlLease::Acquire(std::string id, std::string holder, double ttl_s, int64_t now_ns) {
  if (std::optional<Refusal> refusal = CheckRequest(holder, ttl_s)) {
    return *std::move(refusal);
  }
  if (Alive(now_ns)) {
    const double remaining_s = static_cast<double>(lease_->deadline_ns - now_ns) / kNsPerS;
    return Refusal{.code = RefusalCode::kFailedPrecondition,
                   .reason = kControlHeld,
                   .message = "'" + lease_->holder + "' has control of this axis for another " +
                              Figure(remaining_s) +
                              " s unless it renews: try again then, or ask it to release control.",
                   .metadata = {{"holder", lease_->holder}, {"remaining_s", Figure(remaining_s)}}};
  }
  if (lease_.has_value()) {
    lost_ids_.push_back(std::move(lease_->id));
    if (lost_ids_.size() > kRememberedIds) {
      lost_ids_.pop_front();
    }
  }
  const auto ttl_ns = std::llround(ttl_s * kNsPerS);
  lease_ = Lease{.id = std::move(id),
                 .holder = holder.empty() ? "unnamed client" : std::move(holder),
                 .ttl_ns = ttl_ns,
                 .deadline_ns = now_ns + ttl_ns};
  return *lease_;
}

Result<Lease> ControlLease::Renew(const std::string& id, int64_t now_ns) {
  if (std::optional<Refusal> refusal = Check(id, now_ns)) {
    return *std::move(refusal);
  }
  lease_->deadline_ns = now_ns + lease_->ttl_ns;
  return *lease_;
}

std::optional<Refusal> ControlLease::Release(const std::string& id, int64_t now_ns) {
  std::optional<Refusal> refusal = Check(id, now_ns);
  if (!refusal) {
    lease_.reset();
  }
  return refusal;
}

std::optional<Refusal> ControlLease::Check(const std::string& id, int64_t now_ns) const {
  if (lease_.has_value() && lease_->id == id) {
    if (Alive(now_ns)) {
      return std::nullopt;
    }
    return NoLease("Your lease expired: acquire control again, and renew it before each expiry.");
  }
  if (std::find(lost_ids_.begin(), lost_ids_.end(), id) != lost_ids_.end()) {
    const std::string holder = Holder(now_ns);
    return Refusal{.code = RefusalCode::kAborted,
                   .reason = kLeaseLost,
                   .message = "Your lease expired and another client has taken control since" +
                              (holder.empty() ? "" : " ('" + holder + "' has it now)") +
                              ": acquire control and start over.",
                   .metadata = {{"holder", holder}}};
  }
  return NoLease(id.empty() ? "This request needs control of the axis: acquire it and send its lease_id."
                            : "This lease_id is not one that is held: acquire control first.");
}

std::string ControlLease::Holder(int64_t now_ns) const { return Alive(now_ns) ? lease_->holder : ""; }

}  // namespace mwidth::gate
