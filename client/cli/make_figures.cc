#include <iostream>

#include "client/cli/commands.h"
#include "client/cli/figures/figures.h"

namespace mwidth::cli {

int RunFigures(const CommandLine& line) {
  figures::WriteAllFigures(line.out, line.png ? ".png" : ".svg",
                           [](size_t number, size_t count, const std::string& name) {
                             std::cerr << "[" << number << "/" << count << "] " << name << "\n";
                           });
  std::cout << "Figures 4 to 10 and Tables I and II, each as a picture and as CSV: " << line.out << "\n";
  return kDone;
}

}  // namespace mwidth::cli
