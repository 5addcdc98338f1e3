// Any file: reaches that can be played, or an error that names the file.
#include <cmath>
#include <stdexcept>

#include "device/hand_motion.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, std::size_t size) {
  const auto file = mwidth::fuzz::AsFile(data, size, ".csv");
  try {
    const mwidth::device::RecordedMotion motion(file, mwidth::model::AxisKind::kRotary, {});
    for (int i = 0; i < 100; ++i) {
      mwidth::fuzz::Require(std::isfinite(motion.PositionAt(0.05 * i)), "a finite position");
    }
  } catch (const std::runtime_error& error) {
    mwidth::fuzz::Require(std::string(error.what()).find(file.string()) != std::string::npos,
                          "the error names the file");
  }
  return 0;
}
