#include "common/maths/elementary.h"

#include <gtest/gtest.h>
#include <mpfr.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

namespace haptics::elementary_test {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();
constexpr double kLargest = std::numeric_limits<double>::max();
constexpr double kSmallest = std::numeric_limits<double>::denorm_min();
constexpr double kSmallestNormal = std::numeric_limits<double>::min();
constexpr double kMaxError_ulp = 0.501;

/// A number of MPFR, of far more digits than a double.
class Exact {
 public:
  explicit Exact(double value = 0) { mpfr_init2(number_, 300), mpfr_set_d(number_, value, MPFR_RNDN); }
  ~Exact() { mpfr_clear(number_); }
  Exact(const Exact&) = delete;
  Exact& operator=(const Exact&) = delete;
  operator mpfr_ptr() { return number_; }

  /// Of a double, in units of the last place that a double of this size has.
  [[nodiscard]] double error_ulp(double of) {
    const long exponent = std::max<long>(mpfr_zero_p(number_) ? -1100 : mpfr_get_exp(number_), -1021);
    mpfr_sub_d(number_, number_, of, MPFR_RNDN);
    mpfr_mul_2si(number_, number_, 53 - exponent, MPFR_RNDN);
    return std::abs(mpfr_get_d(number_, MPFR_RNDN));
  }

 private:
  mpfr_t number_;
};

using Judge = int (*)(mpfr_ptr, mpfr_srcptr, mpfr_rnd_t);
using Judge2 = int (*)(mpfr_ptr, mpfr_srcptr, mpfr_srcptr, mpfr_rnd_t);

double error_ulp(double result, Judge judge, double x) {
  Exact exact, of(x);
  judge(exact, of, MPFR_RNDN);
  return exact.error_ulp(result);
}
double error_ulp(double result, Judge2 judge, double x, double y) {
  Exact exact, ofX(x), ofY(y);
  judge(exact, ofX, ofY, MPFR_RNDN);
  return exact.error_ulp(result);
}

class Numbers {
 public:
  [[nodiscard]] double within(double low, double high) {
    return low + (high - low) * (static_cast<double>(engine_() >> 11) * 0x1p-53);
  }
  /// Any finite one, of any size.
  [[nodiscard]] double any() {
    for (;;) {
      const auto number = std::bit_cast<double>(engine_());
      if (std::isfinite(number)) return number;
    }
  }
  /// Of either sign and any size between two powers of two.
  [[nodiscard]] double ofSize(int least, int most) {
    const int exponent = least + static_cast<int>(engine_() % static_cast<unsigned>(most - least + 1));
    const double magnitude = std::ldexp(within(1, 2), exponent);
    return engine_() % 2 == 0 ? magnitude : -magnitude;
  }

 private:
  std::mt19937_64 engine_{1};
};

constexpr int kMany = 50'000;

/// The largest error of a function of one argument.
double worst(double (*function)(double), Judge judge, const std::function<double()>& next, int count = kMany) {
  double most = 0;
  for (int i = 0; i < count; ++i) {
    const double x = next();
    most = std::max(most, error_ulp(function(x), judge, x));
  }
  return most;
}
double worst(double (*function)(double, double), Judge2 judge, const std::function<double()>& next) {
  double most = 0;
  for (int i = 0; i < kMany; ++i) {
    const double x = next(), y = next();
    most = std::max(most, error_ulp(function(x, y), judge, x, y));
  }
  return most;
}

void isPlus0(double value) { EXPECT_TRUE(value == 0 && !std::signbit(value)) << value; }
void isMinus0(double value) { EXPECT_TRUE(value == 0 && std::signbit(value)) << value; }

TEST(Elementary, ExponentialIsExactButForItsRounding) {
  Numbers numbers;
  EXPECT_LT(worst(elementary::exp, mpfr_exp, [&] { return numbers.within(-708, 709.7); }), kMaxError_ulp);
  EXPECT_LT(worst(elementary::exp, mpfr_exp, [&] { return numbers.within(-1, 1); }), kMaxError_ulp);
  EXPECT_LT(worst(elementary::exp, mpfr_exp, [&] { return numbers.ofSize(-60, 6); }), kMaxError_ulp);
  EXPECT_LT(worst(elementary::exp, mpfr_exp, [&] { return numbers.within(-746, -708); }), 1);
  // Nearly halfway between two doubles (Lefevre and Muller 2001).
  for (const double x : {0x1.d6336a88077aap-1, 0x1.e8bdbfcd9144ep+3, -0x1.12a9eb2ed1fc2p-1, 0x1.83d4bcdebb3f4p+2})
    EXPECT_LT(error_ulp(elementary::exp(x), mpfr_exp, x), kMaxError_ulp) << x;
}

TEST(Elementary, ExponentialOfLimitsIsThatOfC) {
  EXPECT_EQ(elementary::exp(0), 1);
  EXPECT_EQ(elementary::exp(-0.0), 1);
  EXPECT_EQ(elementary::exp(kSmallest), 1);
  EXPECT_EQ(elementary::exp(kInfinity), kInfinity);
  isPlus0(elementary::exp(-kInfinity));
  EXPECT_TRUE(std::isnan(elementary::exp(kNoNumber)));
  EXPECT_EQ(elementary::exp(0x1.62e42fefa39efp+9), 0x1.fffffffffff2ap+1023);  // the last finite one
  EXPECT_EQ(elementary::exp(0x1.62e42fefa39f0p+9), kInfinity);
  EXPECT_EQ(elementary::exp(-0x1.74910d52d3051p+9), kSmallest);  // the last that is not zero
  isPlus0(elementary::exp(-0x1.74910d52d3052p+9));
  EXPECT_EQ(elementary::exp(kLargest), kInfinity);
  isPlus0(elementary::exp(-kLargest));
}

TEST(Elementary, SineAndCosineAreExactButForTheirRounding) {
  Numbers numbers;
  const auto expectOf = [](const std::function<double()>& next) {
    EXPECT_LT(worst(elementary::sin, mpfr_sin, next), kMaxError_ulp);
    EXPECT_LT(worst(elementary::cos, mpfr_cos, next), kMaxError_ulp);
  };
  expectOf([&] { return numbers.within(-4, 4); });
  expectOf([&] { return numbers.ofSize(-40, 2); });
  expectOf([&] { return numbers.within(-3000, 3000); });
  expectOf([&] { return numbers.ofSize(11, 1023); });
  expectOf([&] { return numbers.any(); });
}

TEST(Elementary, SineAndCosineKnowTheirZeros) {
  const auto expectAt = [](double x) {
    EXPECT_LT(error_ulp(elementary::sin(x), mpfr_sin, x), kMaxError_ulp) << x;
    EXPECT_LT(error_ulp(elementary::cos(x), mpfr_cos, x), kMaxError_ulp) << x;
  };
  for (int i = 1; i < 20'000; ++i) {
    const double x = i * (std::numbers::pi / 2);
    for (const double at : {x, std::nextafter(x, 0), std::nextafter(x, kInfinity), -x}) expectAt(at);
  }
  // Of all doubles the nearest to a multiple of pi / 2 (Muller 1997), and others that are near.
  expectAt(0x1.6ac5b262ca1ffp+849);
  for (const double x : {0x1.921fb54442d18p+1000, 0x1p1023, kLargest, 0x1.0p11, 0x1.fffffffffffffp10}) expectAt(x);
}

TEST(Elementary, SineAndCosineOfLimitsAreThoseOfC) {
  isPlus0(elementary::sin(0));
  isMinus0(elementary::sin(-0.0));
  EXPECT_EQ(elementary::sin(kSmallest), kSmallest);
  EXPECT_EQ(elementary::sin(-kSmallestNormal), -kSmallestNormal);
  EXPECT_EQ(elementary::cos(0), 1);
  EXPECT_EQ(elementary::cos(-kSmallest), 1);
  for (const double x : {kInfinity, -kInfinity, kNoNumber}) {
    EXPECT_TRUE(std::isnan(elementary::sin(x)));
    EXPECT_TRUE(std::isnan(elementary::cos(x)));
  }
}

TEST(Elementary, BothOfAnAngleAreEachOfThem) {
  Numbers numbers;
  for (int i = 0; i < 1000; ++i) {
    const double x = numbers.within(-100, 100);
    const auto [sine, cosine] = elementary::sineCosine(x);
    EXPECT_EQ(sine, elementary::sin(x));
    EXPECT_EQ(cosine, elementary::cos(x));
    EXPECT_EQ(-sine, elementary::sin(-x));
    EXPECT_EQ(cosine, elementary::cos(-x));
  }
}

TEST(Elementary, AngleIsExactButForItsRounding) {
  Numbers numbers;
  EXPECT_LT(worst(elementary::atan2, mpfr_atan2, [&] { return numbers.within(-1, 1); }), kMaxError_ulp);
  EXPECT_LT(worst(elementary::atan2, mpfr_atan2, [&] { return numbers.ofSize(-20, 20); }), kMaxError_ulp);
  EXPECT_LT(worst(elementary::atan2, mpfr_atan2, [&] { return numbers.ofSize(-540, -460); }), kMaxError_ulp);
  EXPECT_LT(worst(elementary::atan2, mpfr_atan2, [&] { return numbers.ofSize(460, 540); }), kMaxError_ulp);
  EXPECT_LT(worst(elementary::atan2, mpfr_atan2, [&] { return numbers.any(); }), 1);
  EXPECT_LT(worst(elementary::atan2, mpfr_atan2, [&] { return numbers.ofSize(-1070, -1000); }), 1);
}

TEST(Elementary, AngleOfLimitsIsThatOfC) {
  using std::numbers::pi;
  isPlus0(elementary::atan2(0, 1));
  isMinus0(elementary::atan2(-0.0, 1));
  isPlus0(elementary::atan2(0, 0));
  isMinus0(elementary::atan2(-0.0, 0));
  EXPECT_EQ(elementary::atan2(0, -0.0), pi);
  EXPECT_EQ(elementary::atan2(-0.0, -0.0), -pi);
  EXPECT_EQ(elementary::atan2(-0.0, -1), -pi);
  EXPECT_EQ(elementary::atan2(1, 0), pi / 2);
  EXPECT_EQ(elementary::atan2(-kSmallest, -0.0), -pi / 2);
  EXPECT_EQ(elementary::atan2(kInfinity, kInfinity), pi / 4);
  EXPECT_EQ(elementary::atan2(-kInfinity, -kInfinity), -3 * pi / 4);
  EXPECT_EQ(elementary::atan2(kInfinity, -1), pi / 2);
  EXPECT_EQ(elementary::atan2(1, -kInfinity), pi);
  isMinus0(elementary::atan2(-kLargest, kInfinity));
  isPlus0(elementary::atan2(kSmallest, kLargest));
  EXPECT_EQ(elementary::atan2(kSmallest, kSmallest), pi / 4);
  EXPECT_EQ(elementary::atan2(kLargest, kLargest), pi / 4);
  EXPECT_EQ(elementary::atan2(kSmallest, 1), kSmallest);
  EXPECT_TRUE(std::isnan(elementary::atan2(kNoNumber, 1)));
  EXPECT_TRUE(std::isnan(elementary::atan2(kInfinity, kNoNumber)));
}

TEST(Elementary, ArcCosineIsExactButForItsRounding) {
  Numbers numbers;
  EXPECT_LT(worst(elementary::acos, mpfr_acos, [&] { return numbers.within(-1, 1); }), kMaxError_ulp);
  EXPECT_LT(worst(elementary::acos, mpfr_acos, [&] { return numbers.ofSize(-1070, -1); }), kMaxError_ulp);
  EXPECT_LT(worst(elementary::acos, mpfr_acos, [&] { return 1 - std::abs(numbers.ofSize(-53, -2)); }), kMaxError_ulp);
  EXPECT_LT(worst(elementary::acos, mpfr_acos, [&] { return std::abs(numbers.ofSize(-53, -2)) - 1; }), kMaxError_ulp);
  isPlus0(elementary::acos(1));
  EXPECT_EQ(elementary::acos(-1), std::numbers::pi);
  EXPECT_EQ(elementary::acos(0), std::numbers::pi / 2);
  for (const double x : {std::nextafter(1, 2), -1.5, kInfinity, -kInfinity, kNoNumber})
    EXPECT_TRUE(std::isnan(elementary::acos(x))) << x;
}

TEST(Elementary, HypotenuseIsExactButForItsRounding) {
  Numbers numbers;
  EXPECT_LT(worst(elementary::hypot, mpfr_hypot, [&] { return numbers.within(-1, 1); }), kMaxError_ulp);
  EXPECT_LT(worst(elementary::hypot, mpfr_hypot, [&] { return numbers.ofSize(-40, 40); }), kMaxError_ulp);
  EXPECT_LT(worst(elementary::hypot, mpfr_hypot, [&] { return numbers.ofSize(-470, -430); }), kMaxError_ulp);
  EXPECT_LT(worst(elementary::hypot, mpfr_hypot, [&] { return numbers.ofSize(430, 470); }), kMaxError_ulp);
  EXPECT_LT(worst(elementary::hypot, mpfr_hypot, [&] { return numbers.ofSize(-1070, -1000); }), 1);
  EXPECT_LT(worst(elementary::hypot, mpfr_hypot, [&] { return numbers.ofSize(900, 1022); }), kMaxError_ulp);
  EXPECT_EQ(elementary::hypot(3, -4), 5);
  EXPECT_EQ(elementary::hypot(-0.0, -2), 2);
  isPlus0(elementary::hypot(-0.0, -0.0));
  EXPECT_EQ(elementary::hypot(kSmallest, 0), kSmallest);
  EXPECT_EQ(elementary::hypot(kLargest, kLargest), kInfinity);
  EXPECT_EQ(elementary::hypot(-kInfinity, kNoNumber), kInfinity);
  EXPECT_TRUE(std::isnan(elementary::hypot(1, kNoNumber)));
}

// What makes forces the same everywhere: the figure is that of every processor, compiler and C library.
TEST(Elementary, BitsAreTheSameEverywhere) {
  Numbers numbers;
  std::uint64_t hash = 0xcbf29ce484222325;  // FNV-1a
  const auto add = [&](double result) {
    for (int byte = 0; byte < 8; ++byte)
      hash = (hash ^ (std::bit_cast<std::uint64_t>(result) >> (8 * byte) & 0xff)) * 0x100000001b3;
  };
  for (int i = 0; i < 100'000; ++i) {
    const double x = numbers.ofSize(-30, 9), y = numbers.ofSize(-30, 9), any = numbers.any();
    add(elementary::exp(x));
    add(elementary::sin(x));
    add(elementary::cos(y));
    add(elementary::sin(any));
    add(elementary::cos(any));
    add(elementary::atan2(y, x));
    add(elementary::atan2(any, y));
    add(elementary::acos(numbers.within(-1, 1)));
    add(elementary::hypot(x, y));
  }
  EXPECT_EQ(hash, 8429857208422693106U);
}

}  // namespace
}  // namespace haptics::elementary_test
