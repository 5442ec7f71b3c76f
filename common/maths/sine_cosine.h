#pragma once

#include "common/maths/sse.h"

namespace haptics {

struct TwoSinesAndCosines {
  __m128d sine, cosine;
};

/// Sines and cosines of two angles (rad), each within 2^-52 and four roundings of the angle: bit-identical with every C
/// library. The angle is taken to within pi/4 of a multiple of pi/2, which three numbers add up to (Cody and Waite
/// 1980); the polynomials there are those of the Cephes library (Moshier 1992).
[[nodiscard]] inline TwoSinesAndCosines sineCosine(__m128d angle_rad) noexcept {
  const auto all = [](double number) { return _mm_set1_pd(number); };
  const __m128d quarters = _mm_floor_pd(angle_rad * all(0.63661977236758134308) + all(0.5));
  const __m128d x = ((angle_rad - quarters * all(1.57079625129699707031)) - quarters * all(7.54978941586159635336e-8)) -
                    quarters * all(5.39030285815811905290e-15);
  const __m128d z = x * x;
  __m128d s = all(1.58962301576546568060e-10);
  s = s * z - all(2.50507477628578072866e-8);
  s = s * z + all(2.75573136213857245213e-6);
  s = s * z - all(1.98412698295895385996e-4);
  s = s * z + all(8.33333333332211858878e-3);
  s = s * z - all(1.66666666666666307295e-1);
  s = x + x * z * s;
  __m128d c = all(-1.13585365213876817300e-11);
  c = c * z + all(2.08757008419747316778e-9);
  c = c * z - all(2.75573141792967388112e-7);
  c = c * z + all(2.48015872888517045348e-5);
  c = c * z - all(1.38888888888730564116e-3);
  c = c * z + all(4.16666666666665929218e-2);
  c = all(1) - all(0.5) * z + z * z * c;

  const __m128d quarter = quarters - all(4) * _mm_floor_pd(quarters * all(0.25));  // 0 to 3
  const __m128d isSecond = _mm_cmpeq_pd(quarter, all(1)), isThird = _mm_cmpeq_pd(quarter, all(2)),
                isFourth = _mm_cmpeq_pd(quarter, all(3));
  const __m128d odd = _mm_or_pd(isSecond, isFourth), minus = all(-0.0);
  return {_mm_xor_pd(_mm_blendv_pd(s, c, odd), _mm_and_pd(_mm_or_pd(isThird, isFourth), minus)),
          _mm_xor_pd(_mm_blendv_pd(c, s, odd), _mm_and_pd(_mm_or_pd(isSecond, isThird), minus))};
}

}  // namespace haptics
