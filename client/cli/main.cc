// mwidth: the command line of mwidthd.
#include <algorithm>
#include <csignal>
#include <functional>
#include <iostream>
#include <map>
#include <string>
#include <vector>

#include "client/cli/commands.h"
#include "client/cli/json.h"
#include "client/cpp/failure.h"

namespace mwidth::cli {
namespace {

int Run(const std::string& command, const CommandLine& line) {
  static const std::map<std::string, std::function<int(const CommandLine&)>> kCommands = {
      {"state", RunState},    {"m-width", RunMWidth},         {"sweep", RunSweep},
      {"bode", RunBode},      {"accuracy", RunAccuracy},      {"set-mass", RunSetMass},
      {"stop", RunStop},      {"clear-fault", RunClearFault}, {"stream", RunStream},
      {"figures", RunFigures}};
  try {
    return kCommands.at(command)(line);
  } catch (const client::Error& error) {
    if (line.json) {
      std::cout << ToJson(error.status());
    }
    std::cerr << "mwidth: " << error.what() << "\n";
    return error.DeclinedByServer() ? kRefused : kFailed;
  } catch (const std::exception& error) {
    std::cerr << "mwidth: " << error.what() << "\n";
    return kFailed;
  }
}

// The arguments in the reverse order that CLI11 wants. It takes "-.05" for options, "-0.05" for a number.
std::vector<std::string> Arguments(int argc, char** argv) {
  std::vector<std::string> arguments(argv + 1, argv + argc);
  for (auto& argument : arguments) {
    if (argument.starts_with("-.")) {
      argument.insert(1, "0");
    }
  }
  std::reverse(arguments.begin(), arguments.end());
  return arguments;
}

}  // namespace
}  // namespace mwidth::cli

int main(int argc, char** argv) {
  // A closed pipe is seen where it is written to, not as a death without releasing control.
  std::signal(SIGPIPE, SIG_IGN);  // NOLINT(cert-err33-c): cannot fail for SIGPIPE
  mwidth::cli::CommandLine line;
  CLI::App app;
  mwidth::cli::Define(app, line);
  try {
    app.parse(mwidth::cli::Arguments(argc, argv));
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? mwidth::cli::kDone : mwidth::cli::kUsage;
  }
  return mwidth::cli::Run(app.get_subcommands().front()->get_name(), line);
}
