#pragma once

#include <array>
#include <limits>

#include "common/maths/sse.h"
#include "common/maths/vec.h"
#include "haptic_server/engine/geometry/triangle_record.h"

namespace haptics {

/// A point, or an extent: four lanes, of which the last is not used.
[[nodiscard]] inline __m128 lanes(Vec3f v) noexcept { return _mm_setr_ps(v.x, v.y, v.z, 0); }
[[nodiscard]] inline std::array<float, 4> stored(__m128 lanes) noexcept {
  alignas(16) std::array<float, 4> values;
  _mm_store_ps(values.data(), lanes);
  return values;
}
[[nodiscard]] inline Vec3f vec3f(__m128 lanes) noexcept {
  const std::array<float, 4> values = stored(lanes);
  return {values[0], values[1], values[2]};
}

/// A box of floats about triangles; empty at first.
struct FloatBox {
  __m128 low = _mm_set1_ps(std::numeric_limits<float>::max());
  __m128 high = _mm_set1_ps(-std::numeric_limits<float>::max());

  FloatBox() = default;
  FloatBox(__m128 l, __m128 h) noexcept : low(l), high(h) {}
  FloatBox(Vec3f a, Vec3f b, Vec3f c) noexcept : FloatBox(lanes(a), lanes(b), lanes(c)) {}
  explicit FloatBox(const TriangleRecord& r) noexcept {
    __m128 a = _mm_load_ps(r.rows[0].data()), b = _mm_load_ps(r.rows[1].data()), c = _mm_load_ps(r.rows[2].data());
    __m128 unused = _mm_setzero_ps();
    _MM_TRANSPOSE4_PS(a, b, c, unused);
    *this = FloatBox(a, b, c);
  }

  void grow(__m128 l, __m128 h) noexcept {
    low = _mm_min_ps(low, l);
    high = _mm_max_ps(high, h);
  }
  void grow(const FloatBox& b) noexcept { grow(b.low, b.high); }

  [[nodiscard]] FloatBox padded(float by) const noexcept {
    return {_mm_sub_ps(low, _mm_set1_ps(by)), _mm_add_ps(high, _mm_set1_ps(by))};
  }
  [[nodiscard]] bool overlaps(const FloatBox& b) const noexcept {
    constexpr int kThree = 7;
    return (_mm_movemask_ps(_mm_and_ps(_mm_cmple_ps(low, b.high), _mm_cmple_ps(b.low, high))) & kThree) == kThree;
  }
  /// Of a box that is not empty, as the next.
  [[nodiscard]] float halfArea() const noexcept {
    const __m128 size = _mm_sub_ps(high, low);
    const __m128 faces = _mm_mul_ps(size, _mm_shuffle_ps(size, size, _MM_SHUFFLE(3, 0, 2, 1)));
    const __m128 two = _mm_add_ss(faces, _mm_shuffle_ps(faces, faces, _MM_SHUFFLE(3, 3, 3, 1)));
    return _mm_cvtss_f32(_mm_add_ss(two, _mm_movehl_ps(faces, faces)));
  }
  [[nodiscard]] float longest() const noexcept {
    const __m128 size = _mm_sub_ps(high, low);
    const __m128 two = _mm_max_ss(size, _mm_shuffle_ps(size, size, _MM_SHUFFLE(3, 3, 3, 1)));
    return _mm_cvtss_f32(_mm_max_ss(two, _mm_movehl_ps(size, size)));
  }

 private:
  FloatBox(__m128 a, __m128 b, __m128 c) noexcept
      : low(_mm_min_ps(_mm_min_ps(a, b), c)), high(_mm_max_ps(_mm_max_ps(a, b), c)) {}
};

}  // namespace haptics
