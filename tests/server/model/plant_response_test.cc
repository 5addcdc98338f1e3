// The response against the matrix exponential in 50 digits.
#include "server/model/plant_response.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/server/model/reference_plant.h"

namespace mwidth::model {
namespace {

class Draw {
 public:
  explicit Draw(unsigned seed) : random_(seed) {}
  double Uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  double LogUniform(double low, double high) { return std::exp(Uniform(std::log(low), std::log(high))); }
  bool OneIn(int n) { return std::uniform_int_distribution<int>(1, n)(random_) == 1; }

 private:
  std::mt19937_64 random_;
};

TEST(PlantResponse, HasThirteenDigitsAtAnyDamping) {
  Draw draw(1);
  for (int i = 0; i < 200; ++i) {
    const double time_s = draw.LogUniform(1e-5, 1e-2);
    const double damping_rate = draw.OneIn(8) ? 0 : draw.LogUniform(1e-8, 1e10);
    const double stiffness_rate = draw.OneIn(8) ? 0 : draw.LogUniform(1e-8, 1e4 / (time_s * time_s));
    const PlantResponse response = RespondAfter(time_s, damping_rate, stiffness_rate);
    Matrix a{};  // position, velocity, acceleration, its slope, its bend
    a[0][1] = 1;
    a[1][0] = -stiffness_rate;
    a[1][1] = -damping_rate;
    a[1][2] = 1;
    a[2][3] = 1;
    a[3][4] = 1;
    const Matrix flow = Exponential(a, time_s);
    // Accuracy is relative, except to what an oscillation reaches when it happens to pass near zero.
    const double radians = std::sqrt(stiffness_rate) * time_s;
    const double relative = 1e-13 * (1 + 0.1 * radians);
    const double impulse_scale = 1 / std::max({1 / time_s, damping_rate, std::sqrt(stiffness_rate)});
    const double step_scale = radians > 1 ? 1 / stiffness_rate : 0;
    const auto step = static_cast<double>(flow[0][2]);
    const auto ramp = static_cast<double>(flow[0][3]);
    const auto parabola = static_cast<double>(flow[0][4]);
    const auto loss = static_cast<double>(1 - flow[1][1]);
    EXPECT_NEAR(response.impulse, static_cast<double>(flow[0][1]), relative * impulse_scale) << i;
    EXPECT_NEAR(response.step, step, relative * std::max(std::abs(step), step_scale)) << i;
    EXPECT_NEAR(response.ramp, ramp, relative * ramp) << i;
    EXPECT_NEAR(response.parabola, parabola, relative * parabola) << i;
    EXPECT_NEAR(response.velocity_loss, loss,
                relative * std::max(std::abs(loss), step_scale * stiffness_rate))
        << i;
  }
}

}  // namespace
}  // namespace mwidth::model
