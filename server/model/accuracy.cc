#include "server/model/accuracy.h"

#include <algorithm>
#include <array>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <cmath>
#include <complex>
#include <cstddef>
#include <exception>
#include <numbers>
#include <string>

#include "server/model/accelerometer_simulation.h"
#include "server/model/estimator.h"
#include "server/model/hybrid_simulation.h"
#include "server/model/m_width.h"
#include "server/model/plant.h"

namespace mwidth::model {
namespace {

constexpr double kMaxPeriods = 1e7;

// Why there is no perceived mass, if so.
std::optional<PerceivedMass> Imperceptible(const LoopParameters& loop, double mass) {
  if (!ComputeMWidth(loop).Contains(mass)) {
    return PerceivedMass{.perception = Perception::kUnstable};
  }
  if (loop.hand_stiffness == 0 && loop.hand_damping == 0) {
    return PerceivedMass{.perception = Perception::kNotMoved};
  }
  return std::nullopt;
}

PerceivedMass Perceived(double m_hat, double ideal) {
  PerceivedMass perceived{.perception = Perception::kKnown, .mass = m_hat};
  if (ideal != 0) {
    perceived.error = (m_hat - ideal) / ideal;
  }
  return perceived;
}

// The hand's chirp, of amplitude 1, from its turning point at rest.
class Chirp {
 public:
  Chirp(const MotionBand& band, const LoopParameters& loop)
      : lowest_hz_(band.lowest_hz),
        rate_hz_per_s_((band.highest_hz - band.lowest_hz) / band.duration_s),
        damping_(loop.hand_damping),
        stiffness_(loop.hand_stiffness) {}

  static constexpr double kStart = -1;
  // What the hand exerts on a device at rest at 0: b_h x_h' + k_h x_h.
  double DriveAt(double time_s) const {
    const double phase = 2 * std::numbers::pi * (lowest_hz_ + rate_hz_per_s_ / 2 * time_s) * time_s;
    const double frequency_hz = lowest_hz_ + rate_hz_per_s_ * time_s;
    return damping_ * 2 * std::numbers::pi * frequency_hz * std::sin(phase) - stiffness_ * std::cos(phase);
  }

 private:
  double lowest_hz_;
  double rate_hz_per_s_;
  double damping_;
  double stiffness_;
};

// Which of the commanded forces acts at a tick.
class ActingForce {
 public:
  ActingForce(const SampledPlant& plant, TickInstant instant)
      : age_ticks_(static_cast<std::size_t>(plant.delay_ticks)) {
    if (instant == TickInstant::kBeforeForceStep || plant.hold[2] != 0) {
      ++age_ticks_;
    }
  }

  // Takes F_a(k); returns what acts at kT.
  double After(double commanded) {
    std::copy_backward(commands_.begin(), commands_.end() - 1, commands_.end());
    commands_[0] = commanded;
    return commands_[age_ticks_];
  }

 private:
  std::size_t age_ticks_;
  std::array<double, 5> commands_{};
};

// Ends a quadrature that does not converge.
struct Unresolved : std::exception {};

// What is measured.
struct ChirpedLoop {
  const LoopParameters& loop;
  double mass;
  const MotionBand& band;
  TickInstant instant;
};

// Steps `device` through the chirp; `estimate` has the loop's a_hat(k) from it.
template <typename Device, typename Estimate>
PerceivedMass Measure(const ChirpedLoop& chirped, Device device, Estimate estimate) {
  const LoopParameters& loop = chirped.loop;
  const Chirp chirp(chirped.band, loop);
  device.Reset(Chirp::kStart, 0, 0);
  ActingForce acting_force(Discretize(loop), chirped.instant);
  LeastSquaresMass fit;
  const auto ticks = static_cast<int>(chirped.band.duration_s / loop.period_s);
  double drive = chirp.DriveAt(0);
  for (int k = 0; k < ticks; ++k) {
    const double force = chirped.mass * estimate(device);
    // Eqs. 2 and 1. The force between hand mass and device is what is left when the hand mass has its share.
    const double pull =
        drive - loop.hand_damping * device.velocity() - loop.hand_stiffness * device.position();
    const double acceleration = (pull - loop.device_damping * device.velocity() - acting_force.After(force)) /
                                (loop.device_mass + loop.hand_mass);
    fit.Add(acceleration, pull - loop.hand_mass * acceleration);
    const double drive_next = chirp.DriveAt((k + 1) * loop.period_s);
    device.Command(force);
    device.AdvanceUnder(drive, chirp.DriveAt((k + 0.5) * loop.period_s), drive_next);
    drive = drive_next;
  }
  const std::optional<double> m_hat = fit.mass();
  return m_hat ? Perceived(*m_hat, loop.device_mass + chirped.mass) : PerceivedMass{};
}

}  // namespace

std::optional<ParameterError> Validate(const MotionBand& band, double period_s) {
  // Written so that NaN is refused.
  const double highest_hz = 0.5 / period_s;
  if (!(band.lowest_hz > 0 && band.lowest_hz < highest_hz)) {
    return ParameterError{"lowest_hz", band.lowest_hz, "above 0 and below half the sample rate"};
  }
  if (!(band.highest_hz > band.lowest_hz && band.highest_hz <= highest_hz)) {
    return ParameterError{"highest_hz", band.highest_hz, "above lowest_hz, at most half the sample rate"};
  }
  if (!(band.duration_s >= 1 / band.lowest_hz && band.duration_s <= kMaxPeriods * period_s)) {
    return ParameterError{"duration_s", band.duration_s, "at least 1/lowest_hz, at most 1e7 sample periods"};
  }
  return std::nullopt;
}

PerceivedMass PredictPerceivedMass(const LoopParameters& loop, double mass, const MotionBand& band,
                                   TickInstant instant) {
  if (const auto imperceptible = Imperceptible(loop, mass)) {
    return *imperceptible;
  }
  using Quadrature = boost::math::quadrature::gauss_kronrod<double, 31>;
  constexpr unsigned kMaxHalvings = 20;
  constexpr double kTolerance = 1e-10;
  // Some tens of thousands do where there is something to find.
  int evaluations_left = 500'000;
  const SampledResponse sampled(loop);
  const auto integrate = [&](auto integrand) {
    return Quadrature::integrate(
        [&](double frequency_hz) {
          if (--evaluations_left < 0) {
            throw Unresolved();
          }
          return integrand(sampled.ToHand(mass, frequency_hz, instant));
        },
        band.lowest_hz, band.highest_hz, kMaxHalvings, kTolerance);
  };
  try {
    // The imaginary part, which is what damps, is integrated along: where it dwarfs the real part, the real
    // part has its rounding errors, and ten digits of it alone are not to be had.
    const double explained = integrate([](const HandResponse& response) {
                               return response.hand_force * std::conj(response.acceleration);
                             }).real();
    const double motion =
        integrate([](const HandResponse& response) { return std::norm(response.acceleration); });
    return Perceived(explained / motion, loop.device_mass + mass);
  } catch (const Unresolved&) {
    return {.perception = Perception::kUnresolved};
  }
}

PerceivedMass MeasurePerceivedMass(const LoopParameters& loop, double mass, const MotionBand& band,
                                   TickInstant instant) {
  if (const auto imperceptible = Imperceptible(loop, mass)) {
    return *imperceptible;
  }
  const ChirpedLoop chirped{.loop = loop, .mass = mass, .band = band, .instant = instant};
  switch (loop.estimator) {
    case EstimatorKind::kAccelerometer:
      return Measure(chirped, AccelerometerSimulation(loop),
                     [](const AccelerometerSimulation& device) { return device.sensed(); });
    case EstimatorKind::kFilteredAccelerometer:
      return Measure(
          chirped, AccelerometerSimulation(loop),
          [filter = FirstOrderLowPass(FirstOrderLowPass::Factors(loop.period_s, loop.cutoff_hz))](
              const AccelerometerSimulation& device) mutable { return filter.Update(device.sensed()); });
    default:
      return Measure(
          chirped, HybridSimulation(loop),
          [estimator = AccelerationEstimator(loop.period_s, loop.cutoff_hz, loop.estimator)](
              const HybridSimulation& device) mutable { return estimator.Update(device.position()); });
  }
}

}  // namespace mwidth::model
