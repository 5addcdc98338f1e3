#include <cstdio>

#include "server/model/m_width.h"

int main() {
  const mwidth::model::MWidth m_width = mwidth::model::ComputeMWidth({.device_mass = 0.07,
                                                                      .device_damping = 0.005,
                                                                      .hand_damping = 5,
                                                                      .hand_stiffness = 700,
                                                                      .period_s = 0.001,
                                                                      .cutoff_hz = 10});
  std::printf("%.7f %.7f\n", m_width.lower.mass / 0.07, m_width.upper.mass / 0.07);
}
