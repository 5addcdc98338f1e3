// A request that CPUs stay out of the idle states from which they wake slowly.
#pragma once

#include <filesystem>
#include <string>

namespace mwidth::render {

/// Asks the kernel, through its PM QoS device, for CPUs that wake at once: idle ones poll, or rest in a state
/// that has no exit latency. Holds for every CPU, as long as the object lives; the kernel takes the request
/// back when the process ends, however it ends. Costs power and heat. Not Rt.
class CpuLatencyRequest {
 public:
  explicit CpuLatencyRequest(const std::filesystem::path& device = "/dev/cpu_dma_latency");
  CpuLatencyRequest(const CpuLatencyRequest&) = delete;
  CpuLatencyRequest& operator=(const CpuLatencyRequest&) = delete;
  ~CpuLatencyRequest();

  /// Empty where the request holds; else the reason, and what to do about it.
  const std::string& refusal() const noexcept { return refusal_; }

 private:
  int file_ = -1;
  std::string refusal_;
};

}  // namespace mwidth::render
