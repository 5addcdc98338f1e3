// What can be typed.
#pragma once

#include <mwidth/v1/stability.pb.h>

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>

namespace mwidth::cli {

/// The parsed command line; what was not given is unset or has its default.
struct CommandLine {
  std::string server = "127.0.0.1:50051";
  std::string axis;
  bool json = false;

  // m-width
  v1::LoopParameters overrides;

  // set-mass
  double mass = 0;
  std::optional<double> hold_s;
  std::optional<double> ramp_s;
  bool validate_only = false;

  // stop
  std::string reason = "mwidth stop";

  // stream
  std::optional<std::string> csv;
  std::optional<uint64_t> samples;
  std::optional<double> seconds;
  std::optional<uint32_t> decimation;

  // figures
  std::string out;
  bool png = false;
};

/// Adds all options and subcommands to `app`; parsing fills `line`, which must outlive it.
void Define(CLI::App& app, CommandLine& line);

}  // namespace mwidth::cli
