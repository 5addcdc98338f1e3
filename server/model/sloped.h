// Numbers that know their slopes by two parameters: forward differentiation, of numbers and of intervals.
#pragma once

namespace mwidth::model {

/// A value and its slopes by damping and by stiffness.
template <typename T>
struct Sloped {
  T value{};
  T by_damping{};
  T by_stiffness{};
};

template <typename T>
Sloped<T> operator+(const Sloped<T>& x, const Sloped<T>& y) noexcept {
  return {x.value + y.value, x.by_damping + y.by_damping, x.by_stiffness + y.by_stiffness};
}
template <typename T>
Sloped<T> operator-(const Sloped<T>& x) noexcept {
  return {-x.value, -x.by_damping, -x.by_stiffness};
}
template <typename T>
Sloped<T> operator-(const Sloped<T>& x, const Sloped<T>& y) noexcept {
  return x + -y;
}
template <typename T>
Sloped<T> operator*(const Sloped<T>& x, const Sloped<T>& y) noexcept {
  return {x.value * y.value, x.value * y.by_damping + x.by_damping * y.value,
          x.value * y.by_stiffness + x.by_stiffness * y.value};
}
template <typename T>
Sloped<T> operator*(const T& factor, const Sloped<T>& x) noexcept {
  return {factor * x.value, factor * x.by_damping, factor * x.by_stiffness};
}

}  // namespace mwidth::model
