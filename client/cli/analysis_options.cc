// m-width, sweep, bode and accuracy: what may be asked about a loop, of a server or without one.
#include "client/cli/command_line.h"
#include "client/cli/sweep_range.h"

namespace mwidth::cli {
namespace {

void AddLoopOptions(CLI::App* command, CommandLine& line) {
  constexpr const char* kGroup = "Instead of the axis's own";
  using Setter = void (v1::LoopParameters::*)(double);
  const auto add = [&](const std::string& name, Setter set, const std::string& description) {
    return command
        ->add_option_function<double>(
            name, [&line, set](double value) { (line.overrides.*set)(value); }, description)
        ->group(kGroup);
  };
  add("--device-mass", &v1::LoopParameters::set_device_mass, "Inertia of the device, kg or kg m²");
  add("--device-damping", &v1::LoopParameters::set_device_damping, "Its damping, N s/m or N m s/rad");
  add("--hand-mass", &v1::LoopParameters::set_hand_mass, "Inertia of the hand, rigidly added, kg or kg m²");
  add("--hand-damping", &v1::LoopParameters::set_hand_damping, "Damping of its hold, N s/m or N m s/rad");
  add("--hand-stiffness", &v1::LoopParameters::set_hand_stiffness,
      "Stiffness of its hold, N/m or N m/rad; 0: released");
  auto* period = add("--period-s", &v1::LoopParameters::set_period_s, "Sample period, s");
  command
      ->add_option_function<double>(
          "--rate-hz", [&line](double rate_hz) { line.overrides.set_period_s(1 / rate_hz); },
          "Sample rate, Hz")
      ->check(CLI::PositiveNumber)
      ->excludes(period)
      ->group(kGroup);
  AddEstimatorOption(command, "How acceleration is estimated", [&line](v1::EstimatorKind estimator) {
    line.overrides.set_estimator(estimator);
  })->group(kGroup);
  add("--cutoff-hz", &v1::LoopParameters::set_cutoff_hz, "Its cut-off, Hz");
  add("--accelerometer-bandwidth-hz", &v1::LoopParameters::set_accelerometer_bandwidth_hz,
      "Bandwidth of the sensor itself, Hz; of accelerometers only");
  add("--delay-s", &v1::LoopParameters::set_delay_s, "Loop delay beyond the zero-order hold, s");
}

// Of m-width: several hands and devices.
void AddEnvelopeOptions(CLI::App* command, CommandLine& line) {
  constexpr const char* kGroup = "Robust for these, instead of all that the axis allows for";
  const auto add = [&](const std::string& name, const std::string& description, const auto& range) {
    command
        ->add_option_function<std::string>(
            name, [name, range](const std::string& text) { *range() = ParseParameterRange(name, text); },
            description)
        ->type_name("MIN:MAX")
        ->group(kGroup);
  };
  const auto hand = [&line]() -> v1::HandEnvelope& {
    return line.envelope ? *line.envelope : line.envelope.emplace();
  };
  const auto device = [&line]() -> v1::DeviceTolerance& {
    return line.tolerance ? *line.tolerance : line.tolerance.emplace();
  };
  add("--hand-stiffness-range", "Hands that hold less and more firmly, N/m or N m/rad",
      [hand] { return hand().mutable_stiffness(); });
  add("--hand-damping-range", "Damping of their hold, N s/m or N m s/rad",
      [hand] { return hand().mutable_damping(); });
  add("--hand-mass-range", "Their inertia, kg or kg m²", [hand] { return hand().mutable_mass(); });
  command
      ->add_flag_callback(
          "--released-hand", [hand] { hand().set_include_released_hand(true); },
          "Also a hand that has let go")
      ->group(kGroup);
  add("--device-mass-range", "Devices like this one, kg or kg m²",
      [device] { return device().mutable_mass(); });
  add("--device-damping-range", "Their damping, N s/m or N m s/rad",
      [device] { return device().mutable_damping(); });
}

// What all four have: whom to ask, about which loop, and where the answer goes.
CLI::App* Analysis(CLI::App& app, CommandLine& line, const std::string& name, const std::string& description,
                   const std::string& picture, const std::string& examples) {
  auto* command = Subcommand(app, name, description, examples);
  command
      ->add_option(
          "--offline", line.offline,
          "Answer from a configuration file, or a shipped configuration such as paper or elbow, without a "
          "server; the same code, so the same numbers")
      ->type_name("CONFIG");
  command->add_option("--csv", line.csv, "Write the numbers as CSV, with 17 significant digits")
      ->type_name("FILE");
  command->add_option("--plot", line.plot, "Draw " + picture + "; SVG or PNG by the name")
      ->type_name("FILE.svg|FILE.png");
  AddLoopOptions(command, line);
  return command;
}

void DefineSweep(CLI::App& app, CommandLine& line) {
  auto* command = Analysis(app, line, "sweep",
                           "Show which virtual masses are stable over a grid of one or two parameters",
                           "the edges: curves over one parameter, maps over two",
                           "  mwidth sweep cutoff-hz=1:100:50:log\n"
                           "  mwidth sweep cutoff-hz=1:100:33:log hand-stiffness=0:2000:33 --plot map.png\n"
                           "  mwidth sweep period-s=1e-4:1e-2:20:log --offline paper --csv rates.csv");
  const auto add = [&](const std::string& name, const std::string& description, const auto& side) {
    return command
        ->add_option_function<std::string>(
            name, [side](const std::string& text) { *side() = ParseSweepRange(text); }, description)
        ->type_name("NAME=FIRST:LAST[:COUNT][:log]");
  };
  add("x",
      "Parameter, as its option without the dashes, and its values: 21 at equal steps unless told otherwise",
      [&line] { return line.sweep.mutable_x(); })
      ->required();
  add("y", "A second one", [&line] { return line.sweep.mutable_y(); });
}

void DefineBode(CLI::App& app, CommandLine& line) {
  auto* command =
      Analysis(app, line, "bode",
               "Show what the loop with a virtual mass does to a sinusoid, and how heavy and how damped the "
               "device feels over frequency",
               "magnitude, phase and the effective ratios",
               "  mwidth bode 0.1\n"
               "  mwidth bode -0.03 --min-hz 1 --max-hz 50 --count 100 --csv bode.csv\n"
               "  mwidth bode 0.21 --offline paper --plot bode.svg");
  command->add_option("mass", line.mass, "Virtual mass, kg or kg m²")->required();
  const auto add = [&](const std::string& name, void (v1::GetFrequencyResponseRequest::*set)(double),
                       const std::string& description) {
    command
        ->add_option_function<double>(
            name, [&line, set](double value) { (line.bode.*set)(value); }, description)
        ->check(CLI::PositiveNumber);
  };
  add("--min-hz", &v1::GetFrequencyResponseRequest::set_min_hz, "Lowest frequency; default: 0.1 Hz");
  add("--max-hz", &v1::GetFrequencyResponseRequest::set_max_hz, "Highest; default: half the sample rate");
  command
      ->add_option_function<uint32_t>(
          "--count", [&line](uint32_t count) { line.bode.set_count(count); },
          "Number of frequencies; default: 200 for files and JSON, 25 for the terminal")
      ->check(CLI::Range(2, 10'000));
  command->add_flag_callback(
      "--continuous", [&line] { line.bode.set_model(v1::RESPONSE_MODEL_CONTINUOUS); },
      "The paper's continuous approximation instead of the sampled loop");
}

void DefineAccuracy(CLI::App& app, CommandLine& line) {
  auto* command = Analysis(app, line, "accuracy", "Show how truly and how quietly a virtual mass is rendered",
                           "the error of the perceived mass over the filter's cut-off",
                           "  mwidth accuracy 0.21\n"
                           "  mwidth accuracy 0.21 --max-hz 2 --simulate\n"
                           "  mwidth accuracy -0.035 --offline paper --plot accuracy.png");
  command->add_option("mass", line.mass, "Virtual mass, kg or kg m²")->required();
  const auto add = [&](const std::string& name, void (v1::MotionBand::*set)(double),
                       const std::string& description) {
    command
        ->add_option_function<double>(
            name, [&line, set](double value) { (line.accuracy.mutable_band()->*set)(value); }, description)
        ->check(CLI::PositiveNumber);
  };
  add("--min-hz", &v1::MotionBand::set_min_hz, "Lowest frequency of the motion; default: 0.1 Hz");
  add("--max-hz", &v1::MotionBand::set_max_hz, "Highest; default: 5 Hz");
  add("--duration-s", &v1::MotionBand::set_duration_s, "Length of the simulated chirp; default: 60 s");
  command->add_flag_callback(
      "--simulate", [&line] { line.accuracy.set_simulate(true); }, "Simulate as well as predict");
}

}  // namespace

void DefineAnalyses(CLI::App& app, CommandLine& line) {
  auto* m_width = Analysis(app, line, "m-width",
                           "Show which virtual masses are stable, for the axis's loop or for one like it",
                           "the nominal edges over the filter's cut-off",
                           "  mwidth m-width\n"
                           "  mwidth m-width --rate-hz 500 --estimator kalman --cutoff-hz 30\n"
                           "  mwidth m-width --hand-stiffness-range 100:2000 --released-hand\n"
                           "  mwidth --json m-width --hand-stiffness 0\n"
                           "  mwidth m-width --offline elbow --plot m-width.svg");
  AddEnvelopeOptions(m_width, line);
  DefineSweep(app, line);
  DefineBode(app, line);
  DefineAccuracy(app, line);
}

}  // namespace mwidth::cli
