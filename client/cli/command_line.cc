#include "client/cli/command_line.h"

#include <map>
#include <string>
#include <utility>

#include "client/cli/estimator_name.h"

namespace mwidth::cli {
namespace {

constexpr const char* kExitCodes = R"(Exit codes:
  0  done
  1  the server said no: an unstable mass, control held by another client, a wrong state, a fault while holding;
     a drive that cannot be armed; a session that is damaged, or an export that would replace something
  2  the command line is wrong
  3  the server cannot be reached, or something else failed

Examples:
  mwidth state
  mwidth m-width --hand-stiffness 0 --hand-damping 0
  mwidth bode 0.1 --offline paper --plot bode.svg
  mwidth set-mass -0.05 --hold 10
  mwidth set-filter --estimator butterworth 20
  mwidth --server robot:50051 stream --csv reach.csv --seconds 5
  mwidth session export sub-01_task-reach_run-01_20261122T063200Z --to study --format bids
  mwidth stop)";

void DefineSetMass(CLI::App& app, CommandLine& line) {
  auto* command =
      Subcommand(app, "set-mass",
                 "Take control, render a virtual mass and hold it until Ctrl-C; the mass then ramps to "
                 "zero and control is given back",
                 "  mwidth set-mass 0.1\n"
                 "  mwidth set-mass -0.05 --hold 10 --ramp 1\n"
                 "  mwidth set-mass 2 --validate-only");
  command->add_option("mass", line.mass, "Virtual mass, kg or kg m²; negative makes the device feel lighter")
      ->required();
  command->add_option("--hold", line.hold_s, "Seconds to hold the mass, instead of until Ctrl-C")
      ->check(CLI::NonNegativeNumber);
  command
      ->add_option("--ramp", line.ramp_s,
                   "Seconds of the ramp to the mass, 0 to 10; the server's default: 0.2")
      ->check(CLI::NonNegativeNumber);
  command->add_flag("--validate-only", line.validate_only, "Only ask whether the mass would be admitted");
}

void DefineSetFilter(CLI::App& app, CommandLine& line) {
  auto* command =
      Subcommand(app, "set-filter",
                 "Change how acceleration is estimated, until the next change or the server's end: take "
                 "control, change it, and give control back. A server that starts anew has the "
                 "filter of its configuration again",
                 "  mwidth set-filter 20\n"
                 "  mwidth set-filter --estimator kalman 20\n"
                 "  mwidth set-filter 40 --validate-only");
  command
      ->add_option("cutoff_hz", line.cutoff_hz,
                   "Cut-off, Hz; at most half the sample rate, 0.49 of it for butterworth")
      ->required();
  AddEstimatorOption(command, "Estimator; default: the running one",
                     [&line](v1::EstimatorKind estimator) { line.estimator = estimator; });
  command->add_flag("--validate-only", line.validate_only,
                    "Only ask whether it would be admitted, and which masses with it");
}

void DefineStream(CLI::App& app, CommandLine& line) {
  auto* command =
      Subcommand(app, "stream",
                 "Show the samples of the loop as they happen: ten rows a second, or every one as CSV. "
                 "Ticks without a sample are reported on standard error",
                 "  mwidth stream\n"
                 "  mwidth stream --csv reach.csv --seconds 5\n"
                 "  mwidth stream --csv slow.csv --decimation 10 --reduction low-pass\n"
                 "  mwidth stream --csv --samples 1000 | your-program");
  command
      ->add_option("--csv", line.csv, "Write CSV with 17 significant digits to FILE, or to standard output")
      ->expected(0, 1)
      ->default_str("-")
      ->type_name("[FILE]");
  command->add_option("--samples", line.samples, "End after so many samples")->check(CLI::PositiveNumber);
  command->add_option("--seconds", line.seconds, "End after so much time of the loop, s")
      ->check(CLI::PositiveNumber);
  command
      ->add_option(
          "--decimation", line.decimation,
          "Take one of so many ticks; default 1 for CSV and JSON, a tenth of a second for the terminal")
      ->check(CLI::PositiveNumber);
  command
      ->add_option(
          "--reduction", line.reduction,
          "How many ticks become one: pick takes one as it is; low-pass filters before (flat to 0.8 of "
          "half the new rate); min-max adds the least and greatest value since the one before. Default: pick")
      ->transform(CLI::Transformer(std::map<std::string, v1::Reduction>{{"pick", v1::REDUCTION_PICK},
                                                                        {"low-pass", v1::REDUCTION_LOW_PASS},
                                                                        {"min-max", v1::REDUCTION_MIN_MAX}}))
      ->type_name("pick|low-pass|min-max");
  command
      ->add_option(
          "--min-batch", line.min_batch,
          "Hold samples back until so many are there, 1 to 1000: less work; default: show what is there")
      ->check(CLI::Range(1, 1000));
}

void DefineFigures(CLI::App& app, CommandLine& line) {
  auto* command = Subcommand(app, "figures",
                             "Compute Figures 4 to 10 and Tables I and II of the M-width paper anew, as "
                             "pictures with their data; needs no server",
                             "  mwidth figures --out figures\n"
                             "  mwidth figures --out figures --png");
  command->add_option("--out", line.out, "Folder for the files; made where it does not exist")
      ->required()
      ->type_name("DIR");
  command->add_flag("--png", line.png, "Pictures as PNG instead of SVG");
}

void DefineDrive(CLI::App& app, CommandLine& line) {
  auto* drive = Subcommand(app, "drive", "Look at a drive; needs no server",
                           "  mwidth drive probe --config modbus --drive 127.0.0.1:15020");
  drive->require_subcommand(1);
  auto* probe =
      Subcommand(*drive, "probe",
                 "Read what a drive says of itself - state, position, watchdog - and command nothing. Exit "
                 "code 1 where it could not be armed as it is",
                 "  mwidth drive probe --config robot.toml\n"
                 "  mwidth drive probe --config modbus --drive /dev/ttyUSB0");
  probe->add_option("--config", line.config, "The server's configuration: a TOML file or a shipped one")
      ->required();
  probe->add_option("--drive", line.drive,
                    "Where the drive is, instead of where the configuration has it: HOST:PORT, a serial "
                    "device, or a CAN interface");
}

// What is wrong with the command line, and where to read more. CLI11 says of an unknown command that one is
// required.
std::string Complaint(const CLI::App* app, const CLI::Error& error) {
  const auto commands = app->get_subcommands();
  const auto unknown = app->remaining();
  const auto name = "mwidth" + (commands.empty() ? "" : " " + commands.front()->get_name());
  return name + ": " +
         (commands.empty() && !unknown.empty() ? "'" + unknown.front() + "' is no command" : error.what()) +
         "\n" + name + " --help tells what can be asked.\n";
}

}  // namespace

CLI::Option* AddEstimatorOption(CLI::App* command, const std::string& description,
                                const std::function<void(v1::EstimatorKind)>& take) {
  return command
      ->add_option_function<std::string>(
          "--estimator", [take](const std::string& name) { take(EstimatorNamed(name)); }, description)
      ->type_name("NAME")
      ->check(CLI::IsMember(EstimatorNames()));
}

CLI::App* Subcommand(CLI::App& app, const std::string& name, const std::string& description,
                     const std::string& examples) {
  auto* command = app.add_subcommand(name, description);
  command->footer("Examples:\n" + examples);
  return command;
}

void Define(CLI::App& app, CommandLine& line) {
  app.name("mwidth");
  app.description("Command line of mwidthd, the server that renders virtual mass.");
  app.footer(kExitCodes);
  app.require_subcommand(1);
  app.failure_message(Complaint);
  // Global options may also follow the subcommand.
  app.fallthrough();
  app.add_option("--server", line.server, "HOST:PORT of mwidthd")
      ->envname("MWIDTH_SERVER")
      ->capture_default_str();
  app.add_option("--axis", line.axis, "Name of the axis; may be left out where there is only one");
  app.add_flag("--json", line.json,
               "Answer with JSON, field names as in the API; a refusal or an error is a google.rpc.Status");
  app.set_version_flag("--version", "mwidth " MWIDTH_VERSION);

  auto* state = Subcommand(app, "state", "Show the axes and what they are doing",
                           "  mwidth state\n  mwidth state --timing\n  mwidth --json state");
  state->add_flag("--timing", line.timing,
                  "Also how punctual each loop is: wake-up latency, computing, drive I/O and loop delay");
  DefineAnalyses(app, line);
  DefineSetMass(app, line);
  DefineSetFilter(app, line);
  auto* stop =
      Subcommand(app, "stop",
                 "Emergency stop: zero force at once, drive disabled, fault latched. For anyone, whoever "
                 "has control; on every axis, whichever --axis names",
                 "  mwidth stop\n  mwidth stop --reason 'strap came loose'");
  stop->add_option("--reason", line.reason, "For the record")->capture_default_str();
  Subcommand(app, "clear-fault", "Clear a latched fault, once its cause is gone", "  mwidth clear-fault");
  DefineStream(app, line);
  auto* events =
      Subcommand(app, "events",
                 "Show what happens on the axis - states, faults, masses granted and refused, sessions - "
                 "until Ctrl-C",
                 "  mwidth events\n  mwidth events --after 0");
  events->add_option("--after", line.events_after,
                     "Begin behind the event of this number; 0: with the first that the server remembers");
  DefineFigures(app, line);
  DefineDrive(app, line);
  DefineSession(app, line);
}

}  // namespace mwidth::cli
