#include "common/maths/elementary.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>

// Each function looks up a near argument in a table, of twice the digits, and adds what is left as a short series. The
// tables are made by the compiler.
namespace haptics::elementary {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Processors make not-a-numbers of different signs.
constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

/// The sum of two doubles, the second at most half an ULP of the first (Dekker 1971).
struct Two {
  double high = 0, low = 0;
};

/// Of |a| >= |b|, or a = 0.
constexpr Two orderedSum(double a, double b) noexcept {
  const double sum = a + b;
  return {sum, b - (sum - a)};
}

constexpr Two exactSum(double a, double b) noexcept {
  const double sum = a + b;
  const double ofB = sum - a;
  return {sum, (a - (sum - ofB)) + (b - ofB)};
}

/// In 26 bits and 26 bits, the second with a sign: products of such are exact. For |a| < 2^996.
constexpr Two halves(double a) noexcept {
  const double scaled = (0x1p27 + 1) * a;
  const double high = scaled - (scaled - a);
  return {high, a - high};
}

constexpr Two exactProduct(double a, double b) noexcept {
  const double product = a * b;
  const Two p = halves(a), q = halves(b);
  return {product, ((p.high * q.high - product) + p.high * q.low + p.low * q.high) + p.low * q.low};
}

constexpr Two operator+(Two a, Two b) noexcept {
  const Two high = exactSum(a.high, b.high), low = exactSum(a.low, b.low);
  const Two sum = orderedSum(high.high, high.low + low.high);
  return orderedSum(sum.high, sum.low + low.low);
}
constexpr Two operator-(Two a) noexcept { return {-a.high, -a.low}; }
constexpr Two operator-(Two a, Two b) noexcept { return a + -b; }
constexpr Two operator*(Two a, Two b) noexcept {
  const Two product = exactProduct(a.high, b.high);
  return orderedSum(product.high, product.low + (a.high * b.low + a.low * b.high));
}
constexpr Two operator/(Two a, Two b) noexcept {
  const double quotient = a.high / b.high;
  const Two product = exactProduct(quotient, b.high);
  const double rest = ((a.high - product.high) - product.low) + (a.low - quotient * b.low);
  return orderedSum(quotient, rest / b.high);
}

constexpr Two kHalfPi{0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54};
constexpr Two kPi{2 * kHalfPi.high, 2 * kHalfPi.low};
constexpr Two kLn2{0x1.62e42fefa39efp-1, 0x1.abc9e3b39803fp-56};

/// A table's value in 27 bits and 53: a product of the first with a half is exact.
constexpr Two inTable(Two value) noexcept {
  const double high = halves(value.high).high;
  return {high, (value.high - high) + value.low};
}

/// Added to a number below 2^51 it leaves a whole one, in the last bits of the sum.
constexpr double kToWhole = 0x1.8p52;

constexpr int kTerms = 30;  // of series that the compiler sums up

constexpr int kPowerBits = 6;
constexpr int kPowers = 1 << kPowerBits;
/// 2^(i / kPowers).
constexpr auto kPowerOfTwo = [] {
  std::array<Two, kPowers> table{};
  for (int i = 0; i < kPowers; ++i) {
    const Two x = kLn2 * Two{1.0 * i / kPowers};
    Two sum{1}, term{1};
    for (int n = 1; n < kTerms; ++n) {
      term = term * x / Two{1.0 * n};
      sum = sum + term;
    }
    table[static_cast<std::size_t>(i)] = inTable(sum);
  }
  return table;
}();

constexpr int kAngles = 128;  // of a turn
constexpr int kQuarter = kAngles / 4;
/// sin(2 pi i / kAngles).
constexpr auto kSines = [] {
  std::array<Two, kAngles> table{};
  for (int i = 0; i <= kQuarter; ++i) {
    const Two x = kHalfPi * Two{1.0 * i / kQuarter};
    Two sum = x, term = x;
    for (int n = 1; n < kTerms; ++n) {
      term = -(term * x * x / Two{2.0 * n * (2 * n + 1)});
      sum = sum + term;
    }
    for (const int at : {i, kAngles / 2 - i}) {
      table[static_cast<std::size_t>(at)] = inTable(sum);
      if (at > 0) table[static_cast<std::size_t>(kAngles - at)] = -inTable(sum);
    }
  }
  table[kAngles / 2] = {};
  return table;
}();

constexpr int kSlopes = 32;
/// atan(i / kSlopes).
constexpr auto kArcs = [] {
  std::array<Two, kSlopes + 1> table{};
  for (int i = 1; i <= kSlopes; ++i) {
    // From one to the next.
    const Two x = Two{1.0 / kSlopes} / Two{1 + 1.0 * i * (i - 1) / (kSlopes * kSlopes)};
    Two sum = x, power = x;
    for (int n = 1; n < kTerms; ++n) {
      power = -(power * x * x);
      sum = sum + power / Two{2.0 * n + 1};
    }
    table[static_cast<std::size_t>(i)] = table[static_cast<std::size_t>(i - 1)] + sum;
  }
  return table;
}();

/// An angle as index + rest: of kSines, and within half of its step.
struct Reduced {
  std::size_t index;
  Two rest_rad;
};

constexpr double kStep_rad = 2 * kPi.high / kAngles;

/// |x| < kLarge_rad. The step in 35 + 35 + 53 bits, so that what is taken off is exact (Cody and Waite 1980).
constexpr double kLarge_rad = 2048;
Reduced reducedSmall(double x) noexcept {
  constexpr double kFirst = 0x1.921fb5444p-5, kSecond = 0x1.68c234c4cp-44, kThird = 0x1.98a2e03707345p-82;
  const double shifted = x * (1 / kStep_rad) + kToWhole;
  const double steps = shifted - kToWhole;
  const Two rest = exactSum(x - steps * kFirst, -steps * kSecond);
  return {std::bit_cast<std::uint64_t>(shifted) % kAngles, orderedSum(rest.high, rest.low - steps * kThird)};
}

__extension__ typedef __int128 Int128;
__extension__ typedef unsigned __int128 UInt128;

/// Finite, |x| >= kLarge_rad: the turns are counted in whole numbers, of the digits of 2 / pi that matter (Payne and Hanek
/// 1983).
[[gnu::noinline]] Reduced reducedLarge(double x) noexcept {
  // 2 / pi, behind 64 zeros.
  constexpr std::array<std::uint64_t, 20> kTwoOverPi{
      0x0000000000000000, 0xa2f9836e4e441529, 0xfc2757d1f534ddc0, 0xdb6295993c439041, 0xfe5163abdebbc561,
      0xb7246e3a424dd2e0, 0x06492eea09d1921c, 0xfe1deb1cb129a73e, 0xe88235f52ebb4484, 0xe99c7026b45f7e41,
      0x3991d639835339f4, 0x9c845f8bbdf9283b, 0x1ff897ffde05980f, 0xef2f118b5a0a6d1f, 0x6d367ecf27cb09b7,
      0x4f463f669e5fea2d, 0x7527bac7ebe5f17b, 0x3d0739f78a5292ea, 0x6bfb5fb11f8d5d08, 0x56033046fc7b6bab};
  const auto bits = std::bit_cast<std::uint64_t>(x);
  const int exponent = static_cast<int>(bits >> 52 & 0x7ff) - 1075;
  const std::uint64_t mantissa = (bits & 0xf'ffff'ffff'ffff) | 0x10'0000'0000'0000;
  // Quarter turns modulo 4, with 126 bits behind the point: digits before `begin` make whole turns.
  const auto begin = static_cast<unsigned>(exponent + 62);
  const auto word = [&](unsigned i) {
    const std::size_t at = begin / 64 + i;
    const unsigned by = begin % 64;
    return by == 0 ? kTwoOverPi[at] : kTwoOverPi[at] << by | kTwoOverPi[at + 1] >> (64 - by);
  };
  UInt128 quarters = (UInt128{word(0)} << 64 | word(1)) * mantissa + (UInt128{word(2)} * mantissa >> 64);
  constexpr int kBehindStep = 121;  // bits
  const auto index = static_cast<std::size_t>((quarters + (UInt128{1} << (kBehindStep - 1))) >> kBehindStep);
  const auto rest = static_cast<Int128>(quarters - (UInt128{index} << kBehindStep));
  const auto high = static_cast<double>(rest);
  const Two rest_rad = Two{high * 0x1p-126, static_cast<double>(rest - static_cast<Int128>(high)) * 0x1p-126} * kHalfPi;
  return x < 0 ? Reduced{(kAngles - index) % kAngles, -rest_rad} : Reduced{index % kAngles, rest_rad};
}

Reduced reduced(double x) noexcept { return std::abs(x) < kLarge_rad ? reducedSmall(x) : reducedLarge(x); }

/// sin(a + r) of what is in the table for sin(a) and cos(a), and of the sine of r and its cosine - 1.
struct Turn {
  Two split;       // r in halves
  double cubic;    // sin(r) - r, and what r has in its low part
  double cosine1;  // cos(r) - 1

  explicit Turn(Two r) noexcept : split(halves(r.high)) {
    const double z = r.high * r.high;
    cubic = r.low + r.high * z * (-1.0 / 6 + z * (1.0 / 120 + z * (-1.0 / 5040 + z * (1.0 / 362880))));
    cosine1 = z * (-1.0 / 2 + z * (1.0 / 24 + z * (-1.0 / 720 + z * (1.0 / 40320)))) - r.high * r.low;
  }
  [[nodiscard]] double sine(Two sine, Two cosine) const noexcept {
    const Two sum = orderedSum(sine.high, cosine.high * split.high);
    const double small = cosine.high * (split.low + cubic) + cosine.low * (split.high + (split.low + cubic)) +
                         (sine.high + sine.low) * cosine1 + sine.low;
    return sum.high + (sum.low + small);
  }
};

Two sineOf(std::size_t index) noexcept { return kSines[index % kAngles]; }

/// atan(a / b) of 0 <= a <= b, b > 0, both of which may be squared; exact to some 2^-64.
Two arc(Two a, Two b) noexcept {
  const double nearest = a.high / b.high * kSlopes + kToWhole;
  const double slope = (nearest - kToWhole) / kSlopes;
  // tan(x - y) = (tan x - tan y) / (1 + tan x tan y)
  const Two ofA = halves(a.high), ofB = halves(b.high);
  const Two above = exactSum(a.high - slope * ofB.high, -slope * ofB.low);
  const Two below = orderedSum(b.high, slope * ofA.high);
  const Two t = Two{above.high, above.low + (a.low - slope * b.low)} /
                orderedSum(below.high, below.low + (slope * ofA.low + (b.low + slope * a.low)));
  const double z = t.high * t.high;
  const double cubic = t.high * z * (-1.0 / 3 + z * (1.0 / 5 + z * (-1.0 / 7 + z * (1.0 / 9 + z * (-1.0 / 11)))));
  const Two base = kArcs[std::bit_cast<std::uint64_t>(nearest) % (2 * kSlopes)];
  const Two sum = orderedSum(base.high, t.high);
  return {sum.high, sum.low + (base.low + (t.low + cubic))};
}

/// The angle of (x, y), y >= 0, whose smaller coordinate is seen from the larger one under `acute`.
double inUpperHalf(Two acute, bool steep, bool left) noexcept {
  const Two base = steep ? kHalfPi : left ? kPi : Two{};
  const double sign = steep != left ? -1 : 1;
  const Two sum = orderedSum(base.high, sign * acute.high);
  return sum.high + (sum.low + (base.low + sign * acute.low));
}

}  // namespace

double exp(double x) noexcept {
  if (!(std::abs(x) < 746)) return x > 0 ? kInfinity : x < 0 ? 0 : kNoNumber;
  constexpr double kStep = kLn2.high / kPowers;
  constexpr double kFirst = 0x1.62e42fefap-7, kSecond = 0x1.cf79abc9e3b3ap-46;  // the step, in 36 + 53 bits
  const double shifted = x * (1 / kStep) + kToWhole;
  const double steps = shifted - kToWhole;
  const double r = x - steps * kFirst;
  const Two split = halves(r);
  const double low = split.low - steps * kSecond;
  const double z = split.high + low;
  const double square = z * z * (1.0 / 2 + z * (1.0 / 6 + z * (1.0 / 24 + z * (1.0 / 120 + z * (1.0 / 720)))));

  const std::int64_t whole = std::bit_cast<std::int64_t>(shifted) - std::bit_cast<std::int64_t>(kToWhole);
  const Two power = kPowerOfTwo[static_cast<std::size_t>(whole) % kPowers];
  const Two sum = orderedSum(power.high, power.high * split.high);
  const double result = sum.high + (sum.low + (power.high * (low + square) + power.low * (z + square) + power.low));

  const auto ofTwo = [](std::int64_t exponent) { return std::bit_cast<double>((exponent + 1023) << 52); };
  const std::int64_t exponent = whole >> kPowerBits;
  if (exponent > -1022 && exponent < 1023) [[likely]]
    return result * ofTwo(exponent);
  return result * ofTwo(exponent / 2) * ofTwo(exponent - exponent / 2);
}

double sin(double angle_rad) noexcept { return sineCosine(angle_rad).sine; }

double cos(double angle_rad) noexcept { return sineCosine(angle_rad).cosine; }

SineCosine sineCosine(double angle_rad) noexcept {
  constexpr double kLinear_rad = 0x1p-27;  // below, the sine is the angle, whose bits would not bear to be divided
  if (std::abs(angle_rad) < kLinear_rad) return {angle_rad, 1};
  if (!std::isfinite(angle_rad)) return {kNoNumber, kNoNumber};
  const auto [index, rest_rad] = reduced(angle_rad);
  const Turn turn(rest_rad);
  const Two sine = sineOf(index), cosine = sineOf(index + kQuarter);
  return {turn.sine(sine, cosine), turn.sine(cosine, -sine)};
}

double atan2(double y, double x) noexcept {
  double across = std::abs(y), along = std::abs(x);
  if (std::isnan(x) || std::isnan(y)) return kNoNumber;
  if (across == along) across = along = 1;
  if (y == 0) across = 0, along = 1;
  const bool steep = across > along, left = std::signbit(x);
  if (steep) std::swap(across, along);
  constexpr double kNoPart = 0x1p-60, kMax = 0x1p500;
  Two acute;
  if (across < along * kNoPart) {
    acute = {across / along};
  } else {
    const double scale = along > kMax ? 1 / kMax / kMax : along < 1 / kMax ? kMax * kMax : 1;
    acute = arc({across * scale}, {along * scale});
  }
  return std::copysign(inUpperHalf(acute, steep, left), y);
}

double acos(double cosine) noexcept {
  const double along = std::abs(cosine);
  if (!(along <= 1)) return kNoNumber;
  const Two square = exactProduct(along, along);
  const Two rough = orderedSum(1, -square.high);
  const Two left = orderedSum(rough.high, rough.low - square.low);
  if (left.high == 0) return std::signbit(cosine) ? kPi.high : 0;
  const double root = std::sqrt(left.high);
  const Two again = exactProduct(root, root);
  const Two sine{root, (((left.high - again.high) - again.low) + left.low) / (2 * root)};
  const bool steep = root > along;
  return inUpperHalf(steep ? arc({along}, sine) : arc(sine, {along}), steep, std::signbit(cosine));
}

double hypot(double x, double y) noexcept {
  const double most = std::max(std::abs(x), std::abs(y)), least = std::min(std::abs(x), std::abs(y));
  if (std::abs(x) == kInfinity || std::abs(y) == kInfinity) return kInfinity;
  if (std::isnan(x) || std::isnan(y)) return kNoNumber;
  if (!(least > 0)) return most;
  constexpr double kMax = 0x1p450;
  const double scale = most > kMax ? 1 / kMax / kMax : most < 1 / kMax ? kMax * kMax : 1;
  const Two squares = exactProduct(most * scale, most * scale), others = exactProduct(least * scale, least * scale);
  const Two sum = orderedSum(squares.high, others.high);
  const double root = std::sqrt(sum.high);
  const Two again = exactProduct(root, root);
  const double rest = ((sum.high - again.high) - again.low) + (sum.low + (squares.low + others.low));
  return (root + rest / (2 * root)) / scale;
}

}  // namespace haptics::elementary
