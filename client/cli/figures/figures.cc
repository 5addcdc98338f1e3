#include "client/cli/figures/figures.h"

namespace mwidth::figures {

const std::vector<Figure>& AllFigures() {
  static const std::vector<Figure> figures = {
      {"table-1", GainMarginTable},     {"table-2", ParameterTable},
      {"figure-4", SampleRateFigure},   {"figure-5", NaturalFrequencyFigure},
      {"figure-6", StabilityFigure},    {"figure-7", ModelComparisonFigure},
      {"figure-8", RenderedMassFigure}, {"figure-9", PerceivedMassFigure},
      {"figure-10", DampingRatioFigure}};
  return figures;
}

void WriteAllFigures(const std::filesystem::path& folder, const std::string& extension,
                     const Progress& progress) {
  std::filesystem::create_directories(folder);
  const auto& figures = AllFigures();
  for (size_t i = 0; i < figures.size(); ++i) {
    progress(i + 1, figures.size(), figures[i].name);
    const auto write = [&](const auto& figure) {
      plot::WriteCsv(figure, folder / (figures[i].name + ".csv"));
      plot::Draw(figure, folder / (figures[i].name + extension));
    };
    std::visit(write, figures[i].compute());
  }
}

}  // namespace mwidth::figures
