#include "server/model/open_loop.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <stdexcept>

namespace mwidth::model {
namespace {

using Complex = std::complex<double>;

int Degree(const DifferencePolynomial& polynomial) { return static_cast<int>(polynomial.size()) - 1; }

// w = z - 1.
Complex DifferenceAt(double s) { return {-2 * s, 2 * std::sqrt(s * (1 - s))}; }

}  // namespace

OpenLoop::OpenLoop(const SampledPlant& plant, const LinearEstimator& estimator, double mass)
    : plant_(plant), b_(estimator.denominator), gain_(mass * plant.gain) {
  const DifferencePolynomial& numerator = estimator.numerator;
  if (numerator.size() < 3 || numerator[0] != 0 || numerator[1] != 0 || b_.empty()) {
    throw std::invalid_argument("an estimator of acceleration has the factor (z - 1)^2");
  }
  a_.assign(numerator.begin() + 2, numerator.end());
  if (Degree(a_) + Degree(b_) > kMaxEstimatorDegree) {
    throw std::invalid_argument("the estimator is of too high an order for this analysis");
  }
}

OpenLoop::OpenLoop(const SampledPlant& plant, const SampledAcceleration& acceleration,
                   const LinearEstimator& filter, double moving_mass, double mass)
    : plant_(plant),
      senses_acceleration_(true),
      b_(Multiply(filter.denominator, {acceleration.sensor.circle.at_c, 1})),
      gain_(mass / moving_mass) {
  const auto& rise = acceleration.rise;
  plant_.hold = {1, 0, 0};
  plant_.delay_ticks += rise[2] == 0 ? 2 : 3;
  a_ = {rise[0], rise[1], rise[2]};
  if (IsFree()) {
    // w N(w) = w^2 (rise[1] + rise[2] w), and w^2 = -u z.
    a_ = {rise[1], rise[2]};
    --plant_.delay_ticks;
  }
  if (a_.back() == 0) {
    a_.pop_back();
  }
  // The paper's filter has a z in its numerator, which makes good for a tick.
  a_ = Multiply(a_, {filter.numerator[0]});
  if (filter.numerator.size() > 1) {
    --plant_.delay_ticks;
  }
}

OpenLoopValue OpenLoop::At(double half_sine_squared) const {
  const double u = 4 * half_sine_squared;
  const Complex w = DifferenceAt(half_sine_squared);
  const Complex z(1 - 2 * half_sine_squared, w.imag());
  const auto& n = plant_.hold;
  Complex held = n[0] * z + n[1] + n[2] * std::conj(z);
  for (int i = 0; i < plant_.delay_ticks; ++i) {
    held *= std::conj(z);
  }
  if (IsFree()) {
    return {.top = -gain_ * Evaluate(a_, w) * held, .bottom = -Evaluate(b_, w)};
  }
  const Complex raised = senses_acceleration_ ? w : Complex(-u);
  const Complex resonance(plant_.static_gap - u * (1 - plant_.loss / 2), plant_.loss * w.imag());
  return {.top = gain_ * raised * Evaluate(a_, w) * held, .bottom = Evaluate(b_, w) * resonance};
}

Complex OpenLoop::Ratio(double half_sine_squared) const {
  if (half_sine_squared == 0 && !IsFree()) {
    return 0;
  }
  const OpenLoopValue value = At(half_sine_squared);
  return value.top / value.bottom;
}

double OpenLoop::StepSize(double half_sine_squared) const {
  const double u = 4 * half_sine_squared;
  const double reach = std::abs(gain_ * Evaluate(a_, DifferenceAt(half_sine_squared))) * std::sqrt(u);
  return IsFree() ? reach : u * reach;
}

std::vector<Arc> OpenLoop::Divide() const {
  constexpr double kShrink = 8;
  // rho = 0 at the resonance; relative to q it changes by less than `smear` where the damping hides it.
  const double resonance = plant_.static_gap / (4 - 2 * plant_.loss);
  const double smear = plant_.loss / std::sqrt(plant_.static_gap);
  std::vector<double> ends{0, 1};
  if (resonance > 0 && resonance < 1) {
    double way = 1 / kShrink;
    while (way > smear / 2 && way > 1e-12) {
      ends.push_back(resonance * (1 - way));
      ends.push_back(std::min(resonance * (1 + way), 1.0));
      way /= kShrink;
    }
  }
  std::sort(ends.begin(), ends.end());
  std::vector<Arc> arcs;
  for (std::size_t i = 1; i < ends.size(); ++i) {
    if (ends[i] > ends[i - 1]) {
      arcs.push_back({.low = ends[i - 1], .high = ends[i]});
    }
  }
  return arcs;
}

// |n0 + n1/z + n2/z^2|^2: the squares of its values at z = 1 and z = -1 are all there is of it without n2.
ArcForm OpenLoop::HoldSquared(const Arc& arc) const {
  const auto& n = plant_.hold;
  const ArcForm s = LinearForm(arc.low, arc.high);
  const ArcForm c = LinearForm(1 - arc.low, 1 - arc.high);
  const double sum = n[0] + n[1] + n[2];
  const double alternating = n[0] - n[1] + n[2];
  if (n[2] == 0) {
    return Add(Multiply(ConstantForm(sum * sum), c), alternating * alternating, s);
  }
  const double middle = 2 * (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]) - 12 * n[0] * n[2];
  const ArcForm ends =
      Add(Multiply(ConstantForm(sum * sum), Multiply(c, c)), alternating * alternating, Multiply(s, s));
  return Add(ends, middle, Multiply(c, s));
}

// (n0 + n1/z + n2/z^2) z^(1 - delay_ticks).
ComplexArcForm OpenLoop::HeldAndDelayed(const Arc& arc) const {
  const auto& n = plant_.hold;
  const ArcForm cosine = LinearForm(1 - 2 * arc.low, 1 - 2 * arc.high);
  const ComplexArcForm earlier{.re = cosine, .im = ConstantForm(-1)};
  ComplexArcForm value{.re = ConstantForm(n[1]), .im = {}};
  if (n[2] != 0) {
    value = Multiply({.re = ConstantForm(n[2]), .im = {}}, earlier, arc);
    value.re = Add(value.re, n[1], ConstantForm(1));
  }
  value = Multiply(value, earlier, arc);
  value.re = Add(value.re, n[0], ConstantForm(1));
  for (int i = plant_.delay_ticks; i < 1; ++i) {
    value = Multiply(value, Conjugate(earlier), arc);
  }
  for (int i = 1; i < plant_.delay_ticks; ++i) {
    value = Multiply(value, earlier, arc);
  }
  return value;
}

OpenLoopOnArc OpenLoop::Expand(const Arc& arc) const {
  const ArcForm u = LinearForm(4 * arc.low, 4 * arc.high);
  ComplexArcForm resonance{.re = ConstantForm(-1), .im = {}};
  // -u, or the w of an accelerometer, or what is left of them.
  ComplexArcForm raised{.re = ConstantForm(-1), .im = {}};
  ArcForm raised_squared = ConstantForm(1);
  if (!IsFree()) {
    const auto rho = [this](double s) { return plant_.static_gap - 4 * s * (1 - plant_.loss / 2); };
    resonance = {.re = LinearForm(rho(arc.low), rho(arc.high)), .im = ConstantForm(plant_.loss)};
    raised = {.re = Add({}, -1, u), .im = {}};
    raised_squared = Multiply(u, u);
    if (senses_acceleration_) {
      raised = {.re = LinearForm(-2 * arc.low, -2 * arc.high), .im = ConstantForm(1)};
      raised_squared = u;
    }
  }
  const ArcForm resonance_squared = Multiply(resonance, Conjugate(resonance), arc).re;
  const ArcForm reach = Multiply(ConstantForm(gain_ * gain_), Multiply(SizeSquared(a_, arc), raised_squared));
  OpenLoopOnArc on{.arc = arc,
                   .top_squared = Multiply(reach, HoldSquared(arc)),
                   .bottom_squared = Multiply(SizeSquared(b_, arc), resonance_squared),
                   .sum_squared = {},
                   .step_squared = Multiply(reach, u),
                   .imaginary = {}};
  const ComplexArcForm estimate = Multiply(OnArc(a_, arc), Conjugate(OnArc(b_, arc)), arc);
  const ComplexArcForm cross =
      Multiply(Multiply(estimate, HeldAndDelayed(arc), arc), Conjugate(resonance), arc);
  on.sum_squared = Add(Add(on.top_squared, 1, on.bottom_squared), 2 * gain_, Multiply(raised, cross, arc).re);
  on.imaginary = cross.im;
  return on;
}

std::vector<OpenLoopOnArc> OpenLoop::Arcs() const {
  std::vector<OpenLoopOnArc> arcs;
  for (const Arc& arc : Divide()) {
    arcs.push_back(Expand(arc));
  }
  return arcs;
}

}  // namespace mwidth::model
