#include "client/cli/plot/chart.h"

#include <cmath>

#include "client/cli/numbers.h"
#include "client/cli/plot/csv_file.h"

namespace mwidth::plot {

void WriteCsv(const Chart& chart, const std::filesystem::path& file) {
  CsvFile csv(file);
  csv.Row({"quantity", "curve", chart.x.column, "value"});
  for (const auto& panel : chart.panels) {
    for (const auto& curve : panel.curves) {
      for (size_t i = 0; i < curve.x.size(); ++i) {
        csv.Row({panel.y.column, curve.name, cli::Exact(curve.x[i]),
                 std::isnan(curve.y[i]) ? chart.gap : cli::Exact(curve.y[i])});
      }
    }
  }
  csv.Close();
}

}  // namespace mwidth::plot
