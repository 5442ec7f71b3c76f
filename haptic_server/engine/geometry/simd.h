#pragma once

#include <array>

#include "common/maths/sse.h"
#include "common/maths/vec.h"

namespace haptics {

/// Four numbers at work at once, in two SSE registers; AVX2 was measured to gain nothing. One for each corner k, or
/// edge k (corner k to corner k + 1), of a triangle; or x, y, z. The last is not used.
struct Double4 {
  __m128d low, high;

  [[nodiscard]] double operator[](int k) const noexcept {
    if (__builtin_constant_p(k)) return k < 2 ? low[k] : high[k - 2];
    alignas(16) std::array<double, 4> lanes;  // for a k that nobody can predict, without a branch
    _mm_store_pd(lanes.data(), low);
    _mm_store_pd(lanes.data() + 2, high);
    return lanes[static_cast<std::size_t>(k)];
  }
  friend Double4 operator+(Double4 a, Double4 b) noexcept { return {a.low + b.low, a.high + b.high}; }
  friend Double4 operator-(Double4 a, Double4 b) noexcept { return {a.low - b.low, a.high - b.high}; }
  friend Double4 operator*(Double4 a, Double4 b) noexcept { return {a.low * b.low, a.high * b.high}; }
  friend Double4 operator/(Double4 a, Double4 b) noexcept { return {a.low / b.low, a.high / b.high}; }
};

/// The greater of each pair; of equals, or where one is not a number, the second. SIMDe's _mm_max_pd() has others on ARM.
inline Double4 maximum(Double4 a, Double4 b) noexcept {
  return {a.low > b.low ? a.low : b.low, a.high > b.high ? a.high : b.high};
}

/// Results of four comparisons.
struct Mask4 {
  __m128d low, high;

  /// Bit k: that of k.
  [[nodiscard]] unsigned bits() const noexcept {
    return static_cast<unsigned>(_mm_movemask_pd(low) | _mm_movemask_pd(high) << 2);
  }
  friend Mask4 operator|(Mask4 a, Mask4 b) noexcept { return {_mm_or_pd(a.low, b.low), _mm_or_pd(a.high, b.high)}; }
};
inline Mask4 operator>(Double4 a, Double4 b) noexcept {
  return {_mm_cmpgt_pd(a.low, b.low), _mm_cmpgt_pd(a.high, b.high)};
}
inline Mask4 operator>=(Double4 a, Double4 b) noexcept {
  return {_mm_cmpge_pd(a.low, b.low), _mm_cmpge_pd(a.high, b.high)};
}
inline Mask4 operator<=(Double4 a, Double4 b) noexcept {
  return {_mm_cmple_pd(a.low, b.low), _mm_cmple_pd(a.high, b.high)};
}
inline Double4 select(Mask4 which, Double4 yes, Double4 no) noexcept {
  return {_mm_blendv_pd(no.low, yes.low, which.low), _mm_blendv_pd(no.high, yes.high, which.high)};
}

inline Double4 broadcast(double v) noexcept { return {_mm_set1_pd(v), _mm_set1_pd(v)}; }
template <int k>
Double4 broadcastLane(Double4 v) noexcept {
  const __m128d half = k < 2 ? v.low : v.high;
  const __m128d both = k % 2 == 0 ? _mm_unpacklo_pd(half, half) : _mm_unpackhi_pd(half, half);
  return {both, both};
}
/// Lane k becomes lane k + 1 of three: corner k + 1 in the place of corner k.
inline Double4 rotateLanes(Double4 v) noexcept { return {_mm_shuffle_pd(v.low, v.high, 1), v.low}; }
inline Double4 toDouble4(Vec3 v) noexcept { return {_mm_setr_pd(v.x, v.y), _mm_set_sd(v.z)}; }
inline Vec3 vec3(Double4 v) noexcept { return {v[0], v[1], v[2]}; }
/// Three of four floats, and the first once more: the fourth may be a denormal float, which is slow to convert.
inline Double4 threeAndFirst(const std::array<float, 4>& v) noexcept {
  const __m128 floats = _mm_load_ps(v.data());
  return {_mm_cvtps_pd(floats), _mm_cvtps_pd(_mm_shuffle_ps(floats, floats, _MM_SHUFFLE(0, 2, 0, 2)))};
}
/// The first three of one, the third of another.
inline Double4 threeAndThird(Double4 first, Double4 other) noexcept {
  return {first.low, _mm_unpacklo_pd(first.high, other.high)};
}

/// Four vectors at work at once, each with the operations of glm in their order.
struct Vec3x4 {
  Double4 x, y, z;

  [[nodiscard]] Vec3 operator[](int k) const noexcept { return {x[k], y[k], z[k]}; }
  friend Vec3x4 operator+(const Vec3x4& a, const Vec3x4& b) noexcept { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Vec3x4 operator-(const Vec3x4& a, const Vec3x4& b) noexcept { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Vec3x4 operator*(const Vec3x4& a, Double4 s) noexcept { return {a.x * s, a.y * s, a.z * s}; }
};
inline Vec3x4 broadcast(Vec3 v) noexcept { return {broadcast(v.x), broadcast(v.y), broadcast(v.z)}; }
template <int k>
Vec3x4 broadcastLane(const Vec3x4& v) noexcept {
  return {broadcastLane<k>(v.x), broadcastLane<k>(v.y), broadcastLane<k>(v.z)};
}
/// x, y, z of the fourth, and z again.
inline Double4 xyzOfFourth(const Vec3x4& v) noexcept {
  return {_mm_unpackhi_pd(v.x.high, v.y.high), _mm_unpackhi_pd(v.z.high, v.z.high)};
}
inline Vec3x4 threeAndThird(const Vec3x4& first, const Vec3x4& other) noexcept {
  return {threeAndThird(first.x, other.x), threeAndThird(first.y, other.y), threeAndThird(first.z, other.z)};
}
inline Vec3x4 rotateLanes(const Vec3x4& v) noexcept { return {rotateLanes(v.x), rotateLanes(v.y), rotateLanes(v.z)}; }
inline Vec3x4 select(Mask4 which, const Vec3x4& yes, const Vec3x4& no) noexcept {
  return {select(which, yes.x, no.x), select(which, yes.y, no.y), select(which, yes.z, no.z)};
}
inline Vec3x4 cross(const Vec3x4& a, const Vec3x4& b) noexcept {
  return {a.y * b.z - b.y * a.z, a.z * b.x - b.z * a.x, a.x * b.y - b.x * a.y};
}
inline Double4 dot(const Vec3x4& a, const Vec3x4& b) noexcept { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Double4 squaredLength(const Vec3x4& v) noexcept { return dot(v, v); }

}  // namespace haptics
