// Any file: a configuration, or an error that names the file.
#include "server/config.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, std::size_t size) {
  const auto file = mwidth::fuzz::AsFile(data, size, ".toml");
  try {
    mwidth::fuzz::Require(!mwidth::server::LoadConfig(file).axes.empty(), "an axis");
  } catch (const mwidth::server::ConfigError& error) {
    mwidth::fuzz::Require(std::string(error.what()).starts_with(file.string()), "the error names the file");
  }
  return 0;
}
