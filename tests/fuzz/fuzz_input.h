// Numbers and files out of a fuzzer's bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>

#include <unistd.h>

namespace mwidth::fuzz {

/// Stops the fuzzer where a promise is broken.
inline void Require(bool promise, const char* what) {
  if (!promise) {
    std::fprintf(stderr, "broken promise: %s\n", what);
    std::abort();
  }
}

/// Takes values off the front of the input; zeros when it is used up.
class Input {
 public:
  Input(const uint8_t* data, std::size_t size) : data_(data), left_(size) {}

  template <typename T>
  T Take() {
    T value{};
    if (left_ >= sizeof value) {
      std::memcpy(&value, data_, sizeof value);
      data_ += sizeof value;
      left_ -= sizeof value;
    }
    return value;
  }

  /// Any double, or one between `min` and `max`: raw bytes alone are hardly ever in a range.
  double Number(double min, double max) {
    const auto kind = Take<uint8_t>();
    if (kind < 16) {
      return Take<double>();
    }
    return min + (max - min) * Take<uint32_t>() / 4294967295.0;
  }

 private:
  const uint8_t* data_;
  std::size_t left_;
};

/// A file with the input in it, the same one for each run of this process.
inline std::filesystem::path AsFile(const uint8_t* data, std::size_t size, const char* extension) {
  const std::filesystem::path file = "/dev/shm/mwidth-fuzz-" + std::to_string(getpid()) + extension;
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  return file;
}

}  // namespace mwidth::fuzz
