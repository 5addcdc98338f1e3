// mwidth: the command line of mwidthd.
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <exception>
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
  static const std::map<std::string, std::function<int(const CommandLine&)>> commands = {
      {"state", RunState},
      {"m-width", RunMWidth},
      {"sweep", RunSweep},
      {"bode", RunBode},
      {"accuracy", RunAccuracy},
      {"set-mass", RunSetMass},
      {"set-filter", RunSetFilter},
      {"stop", RunStop},
      {"clear-fault", RunClearFault},
      {"stream", RunStream},
      {"events", RunEvents},
      {"figures", RunFigures},
      {"drive", RunDriveProbe},
      {"session", RunSession}};
  try {
    return commands.at(command)(line);
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

// The whole program, but for what escapes it.
int Main(int argc, char** argv) {
  CommandLine line;
  CLI::App app;
  Define(app, line);
  try {
    app.parse(Arguments(argc, argv));
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kDone : kUsage;
  }
  return Run(app.get_subcommands().front()->get_name(), line);
}

}  // namespace
}  // namespace mwidth::cli

int main(int argc, char** argv) {
  // A closed pipe is seen where it is written to, not as a death without releasing control.
  std::signal(SIGPIPE, SIG_IGN);
  try {
    return mwidth::cli::Main(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "mwidth: %s\n", error.what());
    return mwidth::cli::kFailed;
  }
}
