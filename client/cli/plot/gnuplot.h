// gnuplot as a drawing library: a child process that reads a script.
#pragma once

#include <filesystem>
#include <string>

namespace mwidth::plot {

/// Text in gnuplot's single quotes.
std::string GnuplotString(const std::string& text);

/// Runs `script` with the terminal set to draw `file`, SVG or PNG by its extension, of the given size in
/// pixels. Throws as Draw does (chart.h). Blocks.
void RunGnuplot(const std::string& script, const std::filesystem::path& file, int width, int height);

}  // namespace mwidth::plot
