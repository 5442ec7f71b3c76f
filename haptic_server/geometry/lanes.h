#pragma once

#include <smmintrin.h>

#include <array>

#include "common/maths/vec.h"

namespace haptics {

/// Four numbers at work at once, in two SSE registers; AVX2 was measured to gain nothing. One for each corner k, or
/// edge k (corner k to corner k + 1), of a triangle; or x, y, z. The last is not used.
struct Four {
  __m128d low, high;

  [[nodiscard]] double operator[](int k) const noexcept {
    if (__builtin_constant_p(k)) return k < 2 ? low[k] : high[k - 2];
    alignas(16) std::array<double, 4> lanes;  // for a k that nobody can predict, without a branch
    _mm_store_pd(lanes.data(), low);
    _mm_store_pd(lanes.data() + 2, high);
    return lanes[static_cast<std::size_t>(k)];
  }
  friend Four operator+(Four a, Four b) noexcept { return {a.low + b.low, a.high + b.high}; }
  friend Four operator-(Four a, Four b) noexcept { return {a.low - b.low, a.high - b.high}; }
  friend Four operator*(Four a, Four b) noexcept { return {a.low * b.low, a.high * b.high}; }
  friend Four operator/(Four a, Four b) noexcept { return {a.low / b.low, a.high / b.high}; }
};

/// Of each the greater; of equals, or where one is not a number, the second.
inline Four maximum(Four a, Four b) noexcept { return {_mm_max_pd(a.low, b.low), _mm_max_pd(a.high, b.high)}; }

/// Of a comparison, four at once.
struct FourTruths {
  __m128d low, high;

  /// Bit k: that of k.
  [[nodiscard]] unsigned bits() const noexcept {
    return static_cast<unsigned>(_mm_movemask_pd(low) | _mm_movemask_pd(high) << 2);
  }
  friend FourTruths operator|(FourTruths a, FourTruths b) noexcept {
    return {_mm_or_pd(a.low, b.low), _mm_or_pd(a.high, b.high)};
  }
};
inline FourTruths operator>(Four a, Four b) noexcept {
  return {_mm_cmpgt_pd(a.low, b.low), _mm_cmpgt_pd(a.high, b.high)};
}
inline FourTruths operator>=(Four a, Four b) noexcept {
  return {_mm_cmpge_pd(a.low, b.low), _mm_cmpge_pd(a.high, b.high)};
}
inline FourTruths operator<=(Four a, Four b) noexcept {
  return {_mm_cmple_pd(a.low, b.low), _mm_cmple_pd(a.high, b.high)};
}
inline Four select(FourTruths which, Four yes, Four no) noexcept {
  return {_mm_blendv_pd(no.low, yes.low, which.low), _mm_blendv_pd(no.high, yes.high, which.high)};
}

inline Four all(double v) noexcept { return {_mm_set1_pd(v), _mm_set1_pd(v)}; }
template <int k>
Four allOf(Four v) noexcept {
  const __m128d half = k < 2 ? v.low : v.high;
  const __m128d both = k % 2 == 0 ? _mm_unpacklo_pd(half, half) : _mm_unpackhi_pd(half, half);
  return {both, both};
}
/// Of corner k + 1 in the place of corner k.
inline Four following(Four v) noexcept { return {_mm_shuffle_pd(v.low, v.high, 1), v.low}; }
inline Four four(Vec3 v) noexcept { return {_mm_setr_pd(v.x, v.y), _mm_set_sd(v.z)}; }
inline Vec3 vec3(Four v) noexcept { return {v[0], v[1], v[2]}; }
/// Three of four floats, and the first once more: what is in the fourth may be a denormal float, which is slow to convert.
inline Four threeAndFirst(const std::array<float, 4>& v) noexcept {
  const __m128 floats = _mm_load_ps(v.data());
  return {_mm_cvtps_pd(floats), _mm_cvtps_pd(_mm_shuffle_ps(floats, floats, _MM_SHUFFLE(0, 2, 0, 2)))};
}
/// The first three of one, the third of another.
inline Four threeAndThird(Four first, Four other) noexcept {
  return {first.low, _mm_unpacklo_pd(first.high, other.high)};
}

/// Four vectors at work at once, each with the operations of glm in their order.
struct FourVec3 {
  Four x, y, z;

  [[nodiscard]] Vec3 operator[](int k) const noexcept { return {x[k], y[k], z[k]}; }
  friend FourVec3 operator+(const FourVec3& a, const FourVec3& b) noexcept { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend FourVec3 operator-(const FourVec3& a, const FourVec3& b) noexcept { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend FourVec3 operator*(const FourVec3& a, Four s) noexcept { return {a.x * s, a.y * s, a.z * s}; }
};
inline FourVec3 all(Vec3 v) noexcept { return {all(v.x), all(v.y), all(v.z)}; }
template <int k>
FourVec3 allOf(const FourVec3& v) noexcept {
  return {allOf<k>(v.x), allOf<k>(v.y), allOf<k>(v.z)};
}
/// x, y, z of the fourth, and z again.
inline Four xyzOfFourth(const FourVec3& v) noexcept {
  return {_mm_unpackhi_pd(v.x.high, v.y.high), _mm_unpackhi_pd(v.z.high, v.z.high)};
}
inline FourVec3 threeAndThird(const FourVec3& first, const FourVec3& other) noexcept {
  return {threeAndThird(first.x, other.x), threeAndThird(first.y, other.y), threeAndThird(first.z, other.z)};
}
inline FourVec3 following(const FourVec3& v) noexcept { return {following(v.x), following(v.y), following(v.z)}; }
inline FourVec3 select(FourTruths which, const FourVec3& yes, const FourVec3& no) noexcept {
  return {select(which, yes.x, no.x), select(which, yes.y, no.y), select(which, yes.z, no.z)};
}
inline FourVec3 cross(const FourVec3& a, const FourVec3& b) noexcept {
  return {a.y * b.z - b.y * a.z, a.z * b.x - b.z * a.x, a.x * b.y - b.x * a.y};
}
inline Four dot(const FourVec3& a, const FourVec3& b) noexcept { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Four squaredLength(const FourVec3& v) noexcept { return dot(v, v); }

}  // namespace haptics
