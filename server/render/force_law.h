// The force that makes a joint feel heavier or lighter.
#pragma once

namespace mwidth::render {

/// F_a(k) = M a_hat(k), eq. 5: against the positive direction, so a positive mass resists acceleration. N or
/// N m. Rt.
inline double VirtualForce(double mass, double acceleration) noexcept { return mass * acceleration; }

}  // namespace mwidth::render
