#include "server/model/bode.h"

#include <cmath>
#include <complex>
#include <numbers>

#include "server/model/continuous_loop.h"
#include "server/model/frequency_response.h"
#include "server/model/m_width.h"

namespace mwidth::model {
namespace {

using Complex = std::complex<double>;

constexpr double kLowestHz = 1e-6;
constexpr double kDegrees = 180 / std::numbers::pi;

std::vector<double> EqualRatios(const FrequencyRange& range) {
  std::vector<double> frequencies(range.count);
  for (uint32_t i = 0; i < range.count; ++i) {
    frequencies[i] =
        range.min_hz * std::pow(range.max_hz / range.min_hz, static_cast<double>(i) / (range.count - 1));
  }
  frequencies.back() = range.max_hz;
  return frequencies;
}

// The model's loop per unit of mass, and its stiffness as the hand feels it.
class Response {
 public:
  Response(const LoopParameters& loop, double mass, ResponseModel model)
      : loop_(loop), mass_(mass), model_(model), sampled_(loop) {}

  Complex UnitLoop(double frequency_hz) const {
    return model_ == ResponseModel::kDiscrete ? sampled_.Loop(1, frequency_hz)
                                              : ContinuousLoop(loop_, 1, frequency_hz);
  }
  Complex Stiffness(double frequency_hz) const {
    return model_ == ResponseModel::kDiscrete ? sampled_.ToHand(mass_, frequency_hz).hand_force
                                              : RenderedStiffness(loop_, mass_, frequency_hz);
  }
  MWidth StableMasses() const {
    return model_ == ResponseModel::kDiscrete ? ComputeMWidth(loop_) : ComputeContinuousMWidth(loop_);
  }

 private:
  const LoopParameters& loop_;
  double mass_;
  ResponseModel model_;
  SampledResponse sampled_;
};

void AddLoop(const Response& response, double mass, Bode& bode) {
  const double mass_db = 20 * std::log10(std::abs(mass));
  for (const double frequency_hz : bode.frequency_hz) {
    const Complex unit = response.UnitLoop(frequency_hz);
    bode.magnitude_db.push_back(mass_db + 20 * std::log10(std::abs(unit)));
    double phase = kDegrees * std::arg(mass < 0 ? -unit : unit);
    if (!bode.phase_deg.empty()) {
      phase += 360 * std::round((bode.phase_deg.back() - phase) / 360);
    } else if (phase == -180) {
      phase = 180;
    }
    bode.phase_deg.push_back(phase);
  }
}

void AddEffectiveRatios(const LoopParameters& loop, const Response& response, Bode& bode) {
  for (const double frequency_hz : bode.frequency_hz) {
    const EffectiveRatios ratios =
        ComputeEffectiveRatios(loop, response.Stiffness(frequency_hz), frequency_hz);
    bode.effective_mass_ratio.push_back(ratios.mass);
    if (ratios.damping) {
      bode.effective_damping_ratio.push_back(*ratios.damping);
    }
  }
}

std::string WhyNothingIsFelt(const LoopParameters& loop, double mass, const MWidth& stable) {
  if (stable.empty()) {
    return stable.empty_reason;
  }
  if (!stable.Contains(mass)) {
    return "the mass is outside of the M-width: the loop is unstable, and the hand feels an oscillation that "
           "grows";
  }
  if (loop.hand_stiffness == 0 && loop.hand_damping == 0) {
    return "the hand holds with neither stiffness nor damping, and feels nothing";
  }
  return "";
}

}  // namespace

std::optional<ParameterError> Validate(const FrequencyRange& range, double period_s) {
  const double half_rate_hz = 0.5 / period_s;
  if (!(range.min_hz >= kLowestHz && range.min_hz <= half_rate_hz)) {
    return ParameterError{"min_hz", range.min_hz, "1e-6 to half the sample rate"};
  }
  if (!(range.max_hz > range.min_hz && range.max_hz <= half_rate_hz)) {
    return ParameterError{"max_hz", range.max_hz, "above min_hz, at most half the sample rate"};
  }
  if (range.count < 2 || range.count > kMaxFrequencies) {
    return ParameterError{"count", static_cast<double>(range.count), "2 to 10000"};
  }
  return std::nullopt;
}

Bode ComputeBode(const LoopParameters& loop, double mass, const FrequencyRange& range, ResponseModel model) {
  const Response response(loop, mass, model);
  Bode bode;
  bode.frequency_hz = EqualRatios(range);
  AddLoop(response, mass, bode);
  bode.effective_missing = WhyNothingIsFelt(loop, mass, response.StableMasses());
  if (bode.effective_missing.empty()) {
    AddEffectiveRatios(loop, response, bode);
  }
  return bode;
}

}  // namespace mwidth::model
