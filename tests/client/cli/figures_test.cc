// The paper's figures, held against what its text and its equations say.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <map>
#include <stdexcept>

#include "client/cli/figures/figures.h"
#include "client/cli/figures/paper_loops.h"
#include "client/cli/figures/simulated_edge.h"
#include "server/model/m_width.h"

namespace mwidth::figures {
namespace {

using ::testing::ElementsAre;

const plot::Curve& CurveNamed(const plot::Chart& chart, const std::string& quantity,
                              const std::string& name) {
  for (const auto& panel : chart.panels) {
    for (const auto& curve : panel.curves) {
      if (panel.y.column == quantity && curve.name == name) {
        return curve;
      }
    }
  }
  throw std::out_of_range(quantity + ", " + name);
}

// The value at `x`, which is one of the points.
double ValueAt(const plot::Curve& curve, double x) {
  for (size_t i = 0; i < curve.x.size(); ++i) {
    if (std::abs(curve.x[i] - x) < 1e-9 * x) {
      return curve.y[i];
    }
  }
  throw std::out_of_range(curve.name);
}

double Spread(const std::vector<double>& values) {
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  return *most - *least;
}

constexpr char kPositive[] = "ω* for M > 0";
constexpr char kNegative[] = "ω* for M < 0";

TEST(FiguresTest, Figure4HasTheGainMarginsOfThePrintedEquations) {
  const auto chart = SampleRateFigure();
  const auto& positive = CurveNamed(chart, "magnitude_db", kPositive);
  const auto& negative = CurveNamed(chart, "magnitude_db", kNegative);
  constexpr size_t kAt1000Hz = 2;
  ASSERT_EQ(chart.panels[0].curves[kAt1000Hz].name, "1000 Hz");
  EXPECT_NEAR(positive.x[kAt1000Hz], 1199, 0.5);
  EXPECT_NEAR(positive.y[kAt1000Hz], -34.7, 0.05);
  EXPECT_NEAR(negative.x[kAt1000Hz], 106, 0.5);
  EXPECT_NEAR(negative.y[kAt1000Hz], -10.9, 0.05);
  // "The sample rate affects the gain margin greatly for positive virtual mass, but not for negative."
  EXPECT_GT(Spread(positive.y), 20);
  EXPECT_LT(Spread(negative.y), 1);
}

// The marks come from the edges, the curves from the frequency response: they meet.
TEST(FiguresTest, MarksLieOnTheCurves) {
  for (const auto& chart :
       {SampleRateFigure(), NaturalFrequencyFigure(), ModelComparisonFigure(), DampingRatioFigure()}) {
    for (const auto& panel : chart.panels) {
      const size_t loops = panel.curves.size() - 2;
      for (const auto& marks : {panel.curves[loops], panel.curves[loops + 1]}) {
        ASSERT_EQ(marks.x.size(), loops);
        for (size_t i = 0; i < loops; ++i) {
          const auto& curve = panel.curves[i];
          const auto after = std::lower_bound(curve.x.begin(), curve.x.end(), marks.x[i]) - curve.x.begin();
          const auto right = static_cast<size_t>(after);
          ASSERT_GT(right, 0U);
          const double part = (marks.x[i] - curve.x[right - 1]) / (curve.x[right] - curve.x[right - 1]);
          const double value = std::lerp(curve.y[right - 1], curve.y[right], part);
          // What straight lines between 300 points leave, at the sharpest resonance.
          EXPECT_NEAR(marks.y[i], value, panel.y.column == "phase_deg" ? 2 : 0.5)
              << chart.title << curve.name;
        }
      }
    }
  }
}

TEST(FiguresTest, Figure5SaysThatTheHandMattersToNegativeMassOnly) {
  const auto chart = NaturalFrequencyFigure();
  EXPECT_LT(Spread(CurveNamed(chart, "magnitude_db", kPositive).y), 3);
  EXPECT_GT(Spread(CurveNamed(chart, "magnitude_db", kNegative).y), 15);
}

TEST(FiguresTest, Figure6sSimulatedBoundariesAreTheExactOnes) {
  const auto chart = StabilityFigure();
  for (const std::string rate : {"500 Hz", "1000 Hz", "2000 Hz", "5000 Hz"}) {
    for (const char* quantity : {"largest_mass_ratio", "smallest_mass_ratio"}) {
      const auto& simulated = CurveNamed(chart, quantity, rate + " simulated");
      ASSERT_EQ(simulated.x.size(), 9U);
      for (size_t i = 0; i < simulated.x.size(); ++i) {
        const auto loop = TableTwoLoop(std::stod(rate), simulated.x[i]);
        const auto edges = model::ComputeMWidth(loop);
        const double exact = (simulated.y[i] < 0 ? edges.lower : edges.upper).mass / loop.device_mass;
        EXPECT_NEAR(simulated.y[i], exact, 2e-3 * std::abs(exact)) << rate << " " << simulated.x[i];
      }
    }
  }
}

TEST(FiguresTest, Figure7sContinuousModelLagsMore) {
  const auto chart = ModelComparisonFigure();
  const auto& marks = CurveNamed(chart, "phase_deg", kPositive);
  EXPECT_LT(marks.x.at(0), marks.x.at(1)) << "w* of the continuous model comes first";
}

TEST(FiguresTest, Figure8IsIdealBelowTheCutOffAndTheDeviceAboveIt) {
  const auto chart = RenderedMassFigure();
  for (const auto& [mass, ideal] : std::map<std::string, double>{{"M/m = 3", 4}, {"M/m = -0.5", 0.5}}) {
    const auto& rendered = CurveNamed(chart, "effective_mass_ratio", mass + ", rendered");
    EXPECT_NEAR(CurveNamed(chart, "effective_mass_ratio", mass + ", ideal").y.front(), ideal, 1e-12);
    EXPECT_NEAR(rendered.y.front(), ideal, 0.01 * ideal);
    for (const char* quantity : {"magnitude_db", "phase_deg", "effective_damping_ratio"}) {
      const double device = CurveNamed(chart, quantity, mass + ", device").y.back();
      EXPECT_NEAR(CurveNamed(chart, quantity, mass + ", rendered").y.back(), device, 0.05 * std::abs(device))
          << quantity;
    }
  }
}

TEST(FiguresTest, Figure9HasTheErrorsOfThePaperAndTheyShrink) {
  const auto chart = PerceivedMassFigure();
  for (const char* how : {" predicted", " simulated"}) {
    const auto& positive = CurveNamed(chart, "error", std::string("M/m = 3") + how);
    const auto& negative = CurveNamed(chart, "error", std::string("M/m = -0.5") + how);
    EXPECT_NEAR(ValueAt(positive, 10), -0.100, 0.01);
    EXPECT_NEAR(ValueAt(negative, 10), 0.160, 0.01);
    EXPECT_LT(std::abs(positive.y.back()), 0.1 * std::abs(positive.y.front()));
    EXPECT_LT(std::abs(negative.y.back()), 0.1 * std::abs(negative.y.front()));
  }
}

TEST(FiguresTest, Figure9LeavesOutWhatIsUnstable) {
  const auto chart = PerceivedMassFigure();
  const auto& curve = CurveNamed(chart, "error", "M/m = -0.9 simulated");
  EXPECT_FALSE(std::isnan(curve.y.front()));
  EXPECT_TRUE(std::isnan(curve.y.back()));
  EXPECT_EQ(chart.gap, "unstable");
}

TEST(FiguresTest, Figure10SaysThatDampingMattersToNegativeMassOnly) {
  const auto chart = DampingRatioFigure();
  EXPECT_LT(Spread(CurveNamed(chart, "magnitude_db", kPositive).y), 4);
  EXPECT_GT(Spread(CurveNamed(chart, "magnitude_db", kNegative).y), 20);
}

TEST(FiguresTest, TableIHasTheEffectsOfThePaper) {
  constexpr size_t kPaperRows = 5;
  const auto table = GainMarginTable();
  ASSERT_GE(table.rows.size(), kPaperRows);
  for (size_t i = 0; i < kPaperRows; ++i) {
    EXPECT_EQ(table.rows[i].at(2), table.rows[i].at(3)) << table.rows[i].at(0);
    EXPECT_EQ(table.rows[i].at(5), table.rows[i].at(6)) << table.rows[i].at(0);
  }
  // Where the text and the equations part: a stiffer hand narrows the negative side unless its damping grows.
  const auto& stiffness = table.rows[kPaperRows];
  EXPECT_EQ(stiffness.at(0), "k_h at fixed b_h");
  EXPECT_LT(std::stod(stiffness.at(4)), 0);
}

TEST(FiguresTest, TableIIHasTheEdges) {
  const auto table = ParameterTable();
  EXPECT_THAT(table.rows, ::testing::IsSupersetOf(std::vector<std::vector<std::string>>{
                              {"M, discrete model", "-1.398", "34.25", "times m"},
                              {"M, continuous model", "-1.383", "25.93", "times m"},
                              {"M, discrete model without the z in H", "-1.366", "14.52", "times m"}}));
}

TEST(SimulatedEdgeTest, APushGrowsOutsideOfTheMWidthOnly) {
  const auto loop = TableTwoLoop(1000, 10);
  const auto edges = model::ComputeMWidth(loop);
  for (const auto& edge : {edges.lower, edges.upper}) {
    EXPECT_TRUE(PushDiesOut(loop, 0.999 * edge.mass));
    EXPECT_FALSE(PushDiesOut(loop, 1.001 * edge.mass));
  }
}

TEST(FiguresTest, EveryFigureIsAPictureWithItsData) {
  ASSERT_NE(std::signal(SIGPIPE, SIG_IGN), SIG_ERR);
  const auto folder = std::filesystem::path(::testing::TempDir()) / "figures" / "anew";
  std::vector<std::string> progress;
  WriteAllFigures(folder, ".svg", [&](size_t number, size_t count, const std::string& name) {
    EXPECT_EQ(count, 9U);
    EXPECT_EQ(number, progress.size() + 1);
    progress.push_back(name);
  });
  EXPECT_THAT(progress, ElementsAre("table-1", "table-2", "figure-4", "figure-5", "figure-6", "figure-7",
                                    "figure-8", "figure-9", "figure-10"));
  for (const auto& name : progress) {
    for (const char* extension : {".svg", ".csv"}) {
      EXPECT_GT(std::filesystem::file_size(folder / (name + extension)), 100U) << name << extension;
    }
  }
  std::filesystem::remove_all(folder.parent_path());
}

}  // namespace
}  // namespace mwidth::figures
