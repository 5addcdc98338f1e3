// What can be typed.
#pragma once

#include <mwidth/v1/session.pb.h>
#include <mwidth/v1/stability.pb.h>
#include <mwidth/v1/telemetry.pb.h>

#include <CLI/CLI.hpp>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace mwidth::cli {

/// `mwidth session VERB`.
struct SessionOptions {
  std::string verb;
  /// Where sessions are.
  std::string folder = "mwidth-sessions";
  /// Their names, or files.
  std::vector<std::string> sessions;

  // start
  v1::SessionLabels labels;

  // mark
  std::string marker;
  std::string marker_kind;
  std::map<std::string, std::string> marker_metadata;

  // export
  std::string to;
  std::string format;
  bool force = false;
};

/// The parsed command line; what was not given is unset or has its default.
struct CommandLine {
  std::string server = "127.0.0.1:50051";
  std::string axis;
  bool json = false;

  // state
  bool timing = false;

  // m-width, sweep, bode, accuracy
  v1::LoopParameters overrides;
  std::string offline;
  std::optional<std::string> plot;

  // m-width
  std::optional<v1::HandEnvelope> envelope;
  std::optional<v1::DeviceTolerance> tolerance;

  // sweep
  v1::SweepMWidthRequest sweep;

  // bode
  v1::GetFrequencyResponseRequest bode;

  // accuracy
  v1::GetAccuracyRequest accuracy;

  // set-mass, bode, accuracy
  double mass = 0;

  // set-mass
  std::optional<double> hold_s;
  std::optional<double> ramp_s;

  // set-filter
  v1::EstimatorKind estimator = v1::ESTIMATOR_KIND_UNSPECIFIED;
  double cutoff_hz = 0;

  // set-mass, set-filter
  bool validate_only = false;

  // stop
  std::string reason = "mwidth stop";

  // stream, m-width, sweep, bode, accuracy
  std::optional<std::string> csv;

  // stream
  std::optional<uint64_t> samples;
  std::optional<double> seconds;
  std::optional<uint32_t> decimation;
  std::optional<uint32_t> min_batch;
  v1::Reduction reduction = v1::REDUCTION_PICK;

  // events
  std::optional<uint64_t> events_after;

  // drive probe
  std::string config;
  std::string drive;

  // figures
  std::string out;
  bool png = false;

  SessionOptions session;
};

/// Adds a subcommand with its description and its examples as a footer.
CLI::App* Subcommand(CLI::App& app, const std::string& name, const std::string& description,
                     const std::string& examples);

/// Adds --estimator NAME, which hands the estimator of that name to `take`.
CLI::Option* AddEstimatorOption(CLI::App* command, const std::string& description,
                                const std::function<void(v1::EstimatorKind)>& take);

/// Adds m-width, sweep, bode and accuracy (analysis_options.cc).
void DefineAnalyses(CLI::App& app, CommandLine& line);

/// Adds session and its own subcommands (session_options.cc).
void DefineSession(CLI::App& app, CommandLine& line);

/// Adds all options and subcommands to `app`; parsing fills `line`, which must outlive it.
void Define(CLI::App& app, CommandLine& line);

}  // namespace mwidth::cli
