#pragma once

namespace haptics::elementary {

// What the C library has under these names, as a function of the arguments' bits alone: made of +, -, *, / and sqrt, which
// every processor rounds alike. A C library takes the code that suits the processor, and another one in another version, so
// that the last bit of a force would depend on both. All are within 0.501 ULP of the exact result, and within 1 ULP where
// that is subnormal. Infinities, zeros and what is not a number are treated as by the C library; errno is left alone. They
// neither allocate, lock nor call the system.

struct SineCosine {
  double sine, cosine;
};

[[nodiscard]] double exp(double x) noexcept;
[[nodiscard]] double sin(double angle_rad) noexcept;
[[nodiscard]] double cos(double angle_rad) noexcept;
/// Both of one angle, cheaper than one after the other.
[[nodiscard]] SineCosine sineCosine(double angle_rad) noexcept;
/// Of the point (x, y), rad from the x axis, -pi to pi.
[[nodiscard]] double atan2(double y, double x) noexcept;
/// 0 to pi rad.
[[nodiscard]] double acos(double cosine) noexcept;
[[nodiscard]] double hypot(double x, double y) noexcept;

}  // namespace haptics::elementary
