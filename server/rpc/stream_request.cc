#include "server/rpc/stream_request.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>

#include "server/gate/invalid_number.h"

namespace mwidth::rpc {
namespace {

constexpr uint32_t kDefaultBatch = 100;
constexpr uint32_t kMaxBatch = 1000;
constexpr uint32_t kMaxDecimation = 10'000;
constexpr uint32_t kMaxFilteredDecimation = 1000;

std::optional<gate::Refusal> CheckRange(const std::string& field, uint32_t value, uint32_t max) {
  if (value <= max) {
    return std::nullopt;
  }
  return gate::InvalidNumber(field, value, "0 to " + std::to_string(max));
}

std::optional<record::Reduction> ReductionOf(v1::Reduction reduction) {
  switch (reduction) {
    case v1::REDUCTION_UNSPECIFIED:
    case v1::REDUCTION_PICK:
      return record::Reduction::kPick;
    case v1::REDUCTION_LOW_PASS:
      return record::Reduction::kLowPass;
    case v1::REDUCTION_MIN_MAX:
      return record::Reduction::kMinMax;
    default:  // proto3 passes on any number
      return std::nullopt;
  }
}

}  // namespace

// As proto3 has it, 0 is a field that was not set.
gate::Result<record::Cut> CutOf(const v1::StreamSamplesRequest& request) {
  const std::optional<record::Reduction> reduction = ReductionOf(request.reduction());
  if (!reduction) {
    return gate::InvalidNumber("reduction", request.reduction(),
                               "1 (PICK), 2 (LOW_PASS), 3 (MIN_MAX), or 0 for PICK");
  }
  const bool filtered = *reduction == record::Reduction::kLowPass;
  if (auto refusal = CheckRange("decimation", request.decimation(),
                                filtered ? kMaxFilteredDecimation : kMaxDecimation)) {
    return *std::move(refusal);
  }
  if (auto refusal = CheckRange("max_batch", request.max_batch(), kMaxBatch)) {
    return *std::move(refusal);
  }
  if (auto refusal = CheckRange("min_batch", request.min_batch(), kMaxBatch)) {
    return *std::move(refusal);
  }
  if (request.max_batch() != 0 && request.min_batch() > request.max_batch()) {
    return gate::InvalidNumber("min_batch", request.min_batch(),
                               "at most max_batch, which is " + std::to_string(request.max_batch()));
  }
  const uint32_t min_batch = std::max(request.min_batch(), 1U);
  return record::Cut{
      .decimation = std::max(request.decimation(), 1U),
      .reduction = *reduction,
      .min_batch = min_batch,
      .max_batch = request.max_batch() == 0 ? std::max(kDefaultBatch, min_batch) : request.max_batch()};
}

}  // namespace mwidth::rpc
