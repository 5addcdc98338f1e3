#include "server/render/cpu_latency.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <system_error>

namespace mwidth::render {
namespace {

// Microseconds, as a 32-bit integer of the host: what the device takes.
constexpr int32_t kNoLatencyUs = 0;

std::string Refusal(const std::filesystem::path& device, int error) {
  const std::string reason = "CPUs may fall into deep idle states (" + device.string() + ": " +
                             std::generic_category().message(error) + "): ";
  const std::string otherwise = "; or set allow_deep_idle = true in [axis.realtime] to do without";
  if (error == ENOENT || error == ENXIO) {
    return reason + "in a container, pass it on with --device " + device.string() + otherwise;
  }
  return reason + R"(let this user write it, such as by the udev rule KERNEL=="cpu_dma_latency", )" +
         R"(GROUP="realtime", MODE="0660")" + otherwise;
}

}  // namespace

CpuLatencyRequest::CpuLatencyRequest(const std::filesystem::path& device)
    : file_(open(device.c_str(), O_WRONLY | O_CLOEXEC)) {
  if (file_ < 0 || write(file_, &kNoLatencyUs, sizeof(kNoLatencyUs)) != sizeof(kNoLatencyUs)) {
    refusal_ = Refusal(device, errno);
  }
}

CpuLatencyRequest::~CpuLatencyRequest() {
  if (file_ >= 0) {
    close(file_);
  }
}

}  // namespace mwidth::render
