// `mwidth session replay`.
#include "server/record/session/replay.h"

#include <iostream>
#include <nlohmann/json.hpp>

#include "client/cli/commands.h"
#include "client/cli/numbers.h"
#include "client/cli/session/session_files.h"
#include "client/cli/session/verbs.h"
#include "server/record/session/session_reader.h"

namespace mwidth::cli::session {
namespace {

struct Outcome {
  record::ReplayFigures figures;
  std::size_t damaged_blocks = 0;

  bool equal() const { return figures.proves() && figures.filter_unknown == 0 && damaged_blocks == 0; }
};

Outcome ReplayOf(const std::filesystem::path& file) {
  record::SessionReader reader(file);
  record::Replay replay(reader.info().axis);
  std::vector<exchange::Sample> samples;
  while (reader.Next(samples)) {
    for (const exchange::Sample& sample : samples) {
      replay.Add(sample);
    }
  }
  return {.figures = replay.figures(), .damaged_blocks = reader.damaged().size()};
}

void PrintUnjudged(const Outcome& outcome) {
  const record::ReplayFigures& figures = outcome.figures;
  const auto print = [](uint64_t count, const char* why) {
    if (count > 0) {
      std::cout << "  " << count << " " << why << "\n";
    }
  };
  print(figures.begun, "begin a row, the first one and those after lost samples: taken as recorded");
  print(figures.force_unknown,
        "have a force whose limit on its change depends on a lost sample: motion compared");
  print(figures.filter_unknown, "name a filter that does not exist: not compared");
  print(outcome.damaged_blocks, "blocks of the file cannot be trusted: left out");
}

void PrintText(const std::string& name, const Outcome& outcome) {
  const record::ReplayFigures& figures = outcome.figures;
  std::cout << name << ": ";
  if (figures.different > 0) {
    std::cout << figures.different << " of " << figures.samples
              << " samples DIFFER from what their counts give\n";
  } else if (figures.compared() == 0) {
    std::cout << "none of " << figures.samples << " samples could be compared\n";
  } else {
    std::cout << figures.compared() << " of " << figures.samples
              << " samples computed again from their counts: every bit of motion and force is the same\n";
  }
  PrintUnjudged(outcome);
  for (const record::ReplayDifference& difference : figures.first_differences) {
    std::cout << "  tick " << difference.tick << ": " << record::Name(difference.column) << " recorded "
              << Exact(difference.recorded) << ", computed " << Exact(difference.computed) << "\n";
  }
}

nlohmann::ordered_json ToJson(const std::string& name, const Outcome& outcome) {
  const record::ReplayFigures& figures = outcome.figures;
  auto differences = nlohmann::ordered_json::array();
  for (const record::ReplayDifference& difference : figures.first_differences) {
    differences.push_back({{"tick", difference.tick},
                           {"column", record::Name(difference.column)},
                           {"recorded", difference.recorded},
                           {"computed", difference.computed}});
  }
  return {{"session", name},
          {"equal", outcome.equal()},
          {"samples", figures.samples},
          {"compared", figures.compared()},
          {"begun", figures.begun},
          {"losses", figures.losses},
          {"force_unknown", figures.force_unknown},
          {"filter_unknown", figures.filter_unknown},
          {"damaged_blocks", outcome.damaged_blocks},
          {"different", figures.different},
          {"first_differences", differences}};
}

}  // namespace

int Replay(const CommandLine& line) {
  bool equal = true;
  auto json = nlohmann::ordered_json::array();
  for (const std::string& name : line.session.sessions) {
    const std::filesystem::path file = FileOf(line.session, name);
    const Outcome outcome = ReplayOf(file);
    equal = equal && outcome.equal();
    if (line.json) {
      json.push_back(ToJson(file.stem().string(), outcome));
    } else {
      PrintText(file.stem().string(), outcome);
    }
  }
  if (line.json) {
    std::cout << json.dump(2) << "\n";
  }
  return equal ? kDone : kRefused;
}

}  // namespace mwidth::cli::session
