#include "client/cli/plot/map.h"

#include <sstream>

#include "client/cli/numbers.h"
#include "client/cli/plot/gnuplot.h"

namespace mwidth::plot {
namespace {

constexpr int kDigits = 8;
// Viridis of matplotlib at five points: even in lightness, so that a print in grey still tells low from high.
constexpr const char* kPalette =
    "set palette defined (0 '#440154', 1 '#3b528b', 2 '#21918c', 3 '#5ec962', 4 '#fde725')\n";

void AppendAxis(const std::string& name, const Axis& axis, std::ostream& out) {
  out << "set " << name << "label " << GnuplotString(axis.label) << "\n"
      << (axis.logarithmic ? "set" : "unset") << " logscale " << name << "\n"
      << "set autoscale " << name << "fix\n";
}

}  // namespace

void Draw(const Map& map, const std::filesystem::path& file) {
  constexpr int kWidth = 520;
  constexpr int kHeight = 420;
  std::ostringstream script;
  script << "set multiplot layout 1," << map.layers.size() << " title " << GnuplotString(map.title) << "\n"
         << "set view map\nset pm3d corners2color mean\nunset key\nset lmargin 12\nset rmargin 12\n"
         << kPalette;
  AppendAxis("x", map.x, script);
  AppendAxis("y", map.y, script);
  for (size_t layer = 0; layer < map.layers.size(); ++layer) {
    script << "$layer_" << layer << " << END\n";
    for (size_t i = 0; i < map.y_values.size(); ++i) {
      for (size_t k = 0; k < map.x_values.size(); ++k) {
        script << cli::Rounded(map.x_values[k], kDigits) << " " << cli::Rounded(map.y_values[i], kDigits)
               << " " << cli::Rounded(map.layers[layer].rows[i][k], kDigits) << "\n";
      }
      // A blank line ends a row.
      script << "\n";
    }
    script << "END\n"
           << (map.layers[layer].logarithmic ? "set" : "unset") << " logscale cb\nset title "
           << GnuplotString(map.layers[layer].label) << "\nsplot $layer_" << layer
           << " using 1:2:3 with pm3d\n";
  }
  script << "unset multiplot\n";
  RunGnuplot(script.str(), file, kWidth * static_cast<int>(map.layers.size()), kHeight);
}

}  // namespace mwidth::plot
