// Loops, what is assumed around them, and margins, in words.
#pragma once

#include <mwidth/v1/rendering.pb.h>
#include <mwidth/v1/stability.pb.h>

#include <optional>
#include <string>

#include "client/cli/units.h"

namespace mwidth::cli {

/// "0.05 kg".
std::string Quantity(double value, const Unit& unit);

/// "from -0.05 to 0.35 kg", edges rounded inward, or "none" and why.
std::string IntervalText(const v1::Interval& interval, const Units& units);

/// "kalman, cut-off 20 Hz".
std::string FilterText(const v1::LoopParameters& loop);

/// Device, hand, sample rate, filter and delay on one line. Precondition: every field of `loop` is set.
std::string LoopText(const v1::LoopParameters& loop, const Units& units);

/// Hands and devices that a robust interval holds for; unset: those of the loop.
struct Assumptions {
  std::optional<v1::HandEnvelope> envelope{};
  std::optional<v1::DeviceTolerance> tolerance{};
};
/// The axis's own.
Assumptions AssumptionsOf(const v1::AxisInfo& axis);

/// What an axis or a request assumes that allows for nothing else.
inline constexpr const char* kThisLoopAlone = "this loop alone";
/// "hand stiffness 100 to 2000 N/m, a released hand, delay 0 to 0.5 ms": what may differ from `loop`;
/// kThisLoopAlone where nothing may.
std::string AssumptionsText(const Assumptions& assumptions, const v1::LoopParameters& loop,
                            const Units& units);

/// "hand stiffness 2000 N/m, hand damping 2 N s/m": in what `binding` differs from `loop`; "the nominal loop"
/// where in nothing.
std::string BindingText(const v1::LoopParameters& binding, const v1::LoopParameters& loop,
                        const Units& units);

/// "gain 2.92 dB (at 3.25 Hz), phase 41.5 deg (at 22 Hz), delay 3 ms or more, modulus 0.25 (at 31 Hz)".
std::string MarginsText(const v1::StabilityMargins& margins);

}  // namespace mwidth::cli
