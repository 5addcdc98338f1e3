#include "server/rpc/session_request.h"

#include <google/protobuf/map.h>

#include <algorithm>
#include <cstdint>
#include <map>

#include "server/gate/invalid_number.h"

namespace mwidth::rpc {
namespace {

constexpr std::size_t kMaxLabel = 32;
constexpr int kMaxRun = 9999;
constexpr std::size_t kMaxOperator = 100;
constexpr int kMaxEntries = 100;
constexpr std::size_t kMaxKey = 100;
constexpr std::size_t kMaxValue = 4000;
constexpr std::size_t kMaxMetadata = 32'000;
constexpr std::size_t kMaxMarkerLabel = 200;
constexpr std::size_t kMaxMarkerKind = 50;
// A year: any clock, and no sum that overflows.
constexpr int64_t kMaxErrorNs = 365LL * 24 * 3600 * 1'000'000'000;
constexpr int64_t kMaxClockNs = INT64_MAX / 4;

using Metadata = std::map<std::string, std::string>;

gate::Refusal InvalidText(const std::string& field, const std::string& allowed) {
  return {.code = gate::RefusalCode::kInvalidArgument,
          .reason = gate::kInvalidText,
          .message = field + " must be " + allowed + ".",
          .metadata = {{"field", field}, {"allowed", allowed}}};
}

bool IsLabel(const std::string& text) {
  return !text.empty() && text.size() <= kMaxLabel && std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
  });
}

std::string WithoutPrefix(const std::string& text, const std::string& prefix) {
  return text.starts_with(prefix) ? text.substr(prefix.size()) : text;
}

std::optional<gate::Refusal> CheckLength(const std::string& field, const std::string& text,
                                         std::size_t most) {
  if (text.size() <= most) {
    return std::nullopt;
  }
  return InvalidText(field, "of at most " + std::to_string(most) + " bytes");
}

gate::Result<Metadata> ReadMetadata(const google::protobuf::Map<std::string, std::string>& sent) {
  if (sent.size() > kMaxEntries) {
    return InvalidText("metadata", "of at most " + std::to_string(kMaxEntries) + " entries");
  }
  Metadata metadata;
  std::size_t bytes = 0;
  for (const auto& [key, value] : sent) {
    if (auto refusal = CheckLength("metadata's keys", key, kMaxKey)) {
      return *std::move(refusal);
    }
    if (auto refusal = CheckLength("metadata's values", value, kMaxValue)) {
      return *std::move(refusal);
    }
    metadata[key] = value;
    bytes += key.size() + value.size();
  }
  if (bytes > kMaxMetadata) {
    return InvalidText("metadata", "of at most " + std::to_string(kMaxMetadata) + " bytes in all");
  }
  return metadata;
}

}  // namespace

gate::Result<record::SessionLabels> ReadLabels(const v1::SessionLabels& labels) {
  const std::string letters = "1 to " + std::to_string(kMaxLabel) + " letters and digits";
  const std::string subject = WithoutPrefix(labels.subject(), "sub-");
  const std::string visit = WithoutPrefix(labels.visit(), "ses-");
  const std::string task = WithoutPrefix(labels.task(), "task-");
  if (!IsLabel(subject)) {
    return InvalidText("labels.subject", letters + ", such as sub-01");
  }
  if (!visit.empty() && !IsLabel(visit)) {
    return InvalidText("labels.visit", letters + ", such as ses-1, or empty");
  }
  if (!IsLabel(task)) {
    return InvalidText("labels.task", letters + ", such as reach");
  }
  if (labels.run() > kMaxRun) {
    return gate::InvalidNumber("labels.run", labels.run(),
                               "1 to " + std::to_string(kMaxRun) + ", or 0 for the next one");
  }
  if (auto refusal = CheckLength("labels.operator", labels.operator_(), kMaxOperator)) {
    return *std::move(refusal);
  }
  auto metadata = ReadMetadata(labels.metadata());
  if (!metadata.ok()) {
    return metadata.refusal();
  }
  return record::SessionLabels{.subject = subject,
                               .visit = visit,
                               .task = task,
                               .run = static_cast<int>(labels.run()),
                               .operator_name = labels.operator_(),
                               .metadata = *metadata};
}

gate::Result<record::Marker> ReadMarker(const v1::AddMarkerRequest& request, int64_t arrival_ns) {
  if (auto refusal = CheckLength("label", request.label(), kMaxMarkerLabel)) {
    return *std::move(refusal);
  }
  if (auto refusal = CheckLength("kind", request.kind(), kMaxMarkerKind)) {
    return *std::move(refusal);
  }
  const auto metadata = ReadMetadata(request.metadata());
  if (!metadata.ok()) {
    return metadata.refusal();
  }
  record::Marker marker{.label = request.label(),
                        .kind = request.kind(),
                        .metadata = *metadata,
                        .monotonic_ns = arrival_ns,
                        .arrival_ns = arrival_ns};
  if (request.has_time()) {
    const v1::ClientTime& time = request.time();
    const auto within = [](int64_t value, int64_t most) { return value >= -most && value <= most; };
    if (!within(time.client_ns(), kMaxClockNs) || !within(time.offset_ns(), kMaxClockNs)) {
      return gate::InvalidNumber("time.client_ns", static_cast<double>(time.client_ns()),
                                 "a time, and so must be time.offset_ns: within 73 years of 0");
    }
    if (time.error_ns() < 0 || time.error_ns() > kMaxErrorNs) {
      return gate::InvalidNumber("time.error_ns", static_cast<double>(time.error_ns()), "0 to a year");
    }
    marker.client_ns = time.client_ns();
    marker.monotonic_ns = time.client_ns() + time.offset_ns();
    marker.error_ns = time.error_ns();
  }
  return marker;
}

}  // namespace mwidth::rpc
