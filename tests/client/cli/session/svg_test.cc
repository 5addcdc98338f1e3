#include "client/cli/session/svg.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <random>
#include <string>

namespace mwidth::cli::session {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

// The points of the first path, in pixels; each piece begins with the y of NaN.
std::vector<Point> PathIn(const std::string& svg) {
  const auto begin = svg.find(" d=\"") + 4;
  const std::string path = svg.substr(begin, svg.find('"', begin) - begin);
  std::vector<Point> points;
  char command = 0;
  char number[2][32] = {};
  int length = 0;
  for (const char* at = path.c_str();
       std::sscanf(at, "%c%31[-0-9.] %31[-0-9.]%n", &command, number[0], number[1], &length) == 3;
       at += length) {
    if (command == 'M') {
      points.push_back({0, std::nan("")});
    }
    points.push_back({std::stod(number[0]), std::stod(number[1])});
  }
  return points;
}

Picture Drawing(std::vector<Point> points, double x_max) {
  return {.title = "a <picture>",
          .x_label = "time, s",
          .x_max = x_max,
          .panels = {{.y_label = "position & more", .curves = {{"position", std::move(points)}}}}};
}

TEST(SvgTest, EscapesItsTexts) {
  const std::string svg = Svg(Drawing({{0, 0}, {1, 1}}, 1));
  EXPECT_THAT(svg, HasSubstr("a &lt;picture&gt;"));
  EXPECT_THAT(svg, HasSubstr("position &amp; more"));
}

TEST(SvgTest, LeavesOutOnlyWhatNobodySees) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, 0.001);
  std::vector<Point> points;
  for (int i = 0; i <= 2000; ++i) {
    points.push_back({i / 2000.0, std::sin(i / 150.0) + noise(random)});
  }
  const Picture picture = Drawing(points, 1);
  const std::vector<Point> drawn = PathIn(Svg(picture));
  EXPECT_LT(drawn.size(), 1200);
  // Pixels of the ends tell the scale: 676 wide, 120 high for 2.16 of y and a little noise.
  const double left = drawn[1].x;
  const double right = drawn.back().x;
  std::size_t k = 1;
  double worst = 0;
  const auto [low, high] = std::minmax_element(points.begin(), points.end(),
                                               [](const Point& a, const Point& b) { return a.y < b.y; });
  const double middle = (low->y + high->y) / 2;
  const double half = (high->y - low->y) / 2 * 1.08;
  for (const Point& point : points) {
    const double x = left + point.x * (right - left);
    const double y = 20 + 60 - (point.y - middle) / half * 60;
    while (k + 1 < drawn.size() - 1 && drawn[k + 1].x < x) {
      ++k;
    }
    const double share = std::clamp((x - drawn[k].x) / std::max(drawn[k + 1].x - drawn[k].x, 1e-9), 0.0, 1.0);
    worst = std::max(worst, std::abs(drawn[k].y + share * (drawn[k + 1].y - drawn[k].y) - y));
  }
  // A tenth of a pixel across a steep line is more along y; and numbers are rounded to tenths.
  EXPECT_LT(worst, 0.6);
}

TEST(SvgTest, DrawsAStraightLineWithFewPointsAndInterruptsItWhereItIsNotKnown) {
  std::vector<Point> points;
  for (int i = 0; i < 90; ++i) {
    points.push_back({i / 100.0, i < 30 || i > 40 ? 2.0 * i : std::nan("")});
  }
  const auto drawn = PathIn(Svg(Drawing(points, 1)));
  EXPECT_EQ(std::count_if(drawn.begin(), drawn.end(), [](const Point& p) { return std::isnan(p.y); }), 2);
  EXPECT_EQ(drawn.size(), 6);
}

TEST(SvgTest, ShowsAConstantAndNothingAtAll) {
  for (const auto& points : {std::vector<Point>{}, {{0, 0}, {1, 0}}, {{0, 1e9}, {1, 1e9}}}) {
    const std::string svg = Svg(Drawing(points, 1));
    EXPECT_EQ(svg.find("nan"), std::string::npos);
    EXPECT_EQ(svg.find("inf"), std::string::npos);
  }
}

TEST(TicksTest, AreRoundAndInside) {
  EXPECT_THAT(Ticks(0, 10, 5), ElementsAre(0, 2, 4, 6, 8, 10));
  EXPECT_THAT(Ticks(-0.31, 0.29, 3),
              ElementsAre(testing::DoubleNear(-0.2, 1e-15), testing::DoubleNear(0, 1e-15),
                          testing::DoubleNear(0.2, 1e-15)));
}

TEST(ThinTest, KeepsEveryPeak) {
  std::vector<Point> points;
  for (int i = 0; i < 10'000; ++i) {
    points.push_back({static_cast<double>(i), i == 5003 ? 100.0 : i == 777 ? -100.0 : std::sin(i)});
  }
  const auto thin = Thin(points, 100);
  EXPECT_EQ(thin.size(), 200);
  EXPECT_TRUE(
      std::is_sorted(thin.begin(), thin.end(), [](const Point& a, const Point& b) { return a.x < b.x; }));
  EXPECT_EQ(std::count_if(thin.begin(), thin.end(), [](const Point& p) { return std::abs(p.y) == 100; }), 2);
  EXPECT_EQ(Thin({{1, 2}, {3, 4}}, 100).size(), 2);
}

}  // namespace
}  // namespace mwidth::cli::session
