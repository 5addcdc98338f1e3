#include "client/cli/plot/gnuplot.h"

#include <sys/wait.h>

#include <cstdio>
#include <stdexcept>

namespace mwidth::plot {
namespace {

std::string Terminal(const std::filesystem::path& file, int width, int height) {
  const auto size = std::to_string(width) + "," + std::to_string(height);
  // No enhanced text: an underscore in an axis's name is an underscore.
  if (file.extension() == ".svg") {
    return "set terminal svg noenhanced size " + size + " font 'sans-serif,12' background 'white'\n";
  }
  if (file.extension() == ".png") {
    return "set terminal pngcairo noenhanced size " + size + " font 'sans,10' background 'white'\n";
  }
  throw std::runtime_error("cannot draw " + file.string() + ": the name of a picture ends in .svg or .png");
}

}  // namespace

std::string GnuplotString(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text) {
    // A line break would end the string.
    quoted += c == '\'' ? "''" : std::string(1, c == '\n' ? ' ' : c);
  }
  return quoted + "'";
}

void RunGnuplot(const std::string& script, const std::filesystem::path& file, int width, int height) {
  const auto whole = Terminal(file, width, height) + "set output " + GnuplotString(file.string()) + "\n" +
                     script + "unset output\n";
  // Where the file cannot be opened gnuplot would draw to standard output.
  // NOLINTNEXTLINE(cert-env33-c): a fixed command; names and data travel through the pipe, never the shell
  FILE* const pipe = popen("gnuplot -d - >/dev/null", "w");
  if (pipe == nullptr) {
    throw std::runtime_error("cannot start gnuplot");
  }
  const bool written = std::fwrite(whole.data(), 1, whole.size(), pipe) == whole.size();
  const int status = pclose(pipe);
  constexpr int kNotFound = 127;
  if (WIFEXITED(status) && WEXITSTATUS(status) == kNotFound) {
    throw std::runtime_error("pictures need gnuplot (Debian package gnuplot-nox)");
  }
  if (!written || status != 0) {
    throw std::runtime_error("gnuplot could not draw " + file.string());
  }
}

}  // namespace mwidth::plot
