#include "server/render/cpu_latency.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdint>
#include <fstream>

#include "tests/support/temporary_file.h"

namespace mwidth::render {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

TEST(CpuLatencyRequestTest, AsksForNoLatencyInTheFormOfTheKernel) {
  const TemporaryFile device("....");
  const CpuLatencyRequest request(device.path());
  EXPECT_THAT(request.refusal(), IsEmpty());
  int32_t asked_us = -1;
  std::ifstream(device.path(), std::ios::binary).read(reinterpret_cast<char*>(&asked_us), sizeof(asked_us));
  EXPECT_EQ(asked_us, 0);
}

TEST(CpuLatencyRequestTest, SaysHowToGetAMissingDevice) {
  const CpuLatencyRequest request("/no/such/device");
  EXPECT_THAT(request.refusal(), HasSubstr("/no/such/device: No such file"));
  EXPECT_THAT(request.refusal(), HasSubstr("--device"));
  EXPECT_THAT(request.refusal(), HasSubstr("allow_deep_idle"));
}

TEST(CpuLatencyRequestTest, SaysHowToGetADeviceThatRefuses) {
  const CpuLatencyRequest request("/dev/full");
  EXPECT_THAT(request.refusal(), HasSubstr("No space left"));
  EXPECT_THAT(request.refusal(), HasSubstr("udev"));
}

TEST(CpuLatencyRequestTest, HoldsWhileItLives) {
  const int device = open("/dev/cpu_dma_latency", O_RDONLY | O_CLOEXEC);
  if (device < 0) {
    GTEST_SKIP() << "this host, or this user, has no /dev/cpu_dma_latency";
  }
  int32_t in_force_us = -1;
  {
    const CpuLatencyRequest request;
    ASSERT_THAT(request.refusal(), IsEmpty());
    ASSERT_EQ(pread(device, &in_force_us, sizeof(in_force_us), 0), sizeof(in_force_us));
    EXPECT_EQ(in_force_us, 0);
  }
  close(device);
}

}  // namespace
}  // namespace mwidth::render
