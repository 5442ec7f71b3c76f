#include "common/maths/sine_cosine.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace haptics::sine_cosine_test {
namespace {

/// @param most  Of the angle, rad.
void expectThoseOfTheLibrary(double most) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> angle(-most, most);
  const double tolerance = 0x1p-52 + most * 0x1p-51;
  for (int i = 0; i < 100'000; ++i) {
    const double first = angle(random), second = angle(random);
    const auto [sine, cosine] = sineCosine(_mm_set_pd(second, first));
    ASSERT_NEAR(sine[0], std::sin(first), tolerance) << first;
    ASSERT_NEAR(sine[1], std::sin(second), tolerance) << second;
    ASSERT_NEAR(cosine[0], std::cos(first), tolerance) << first;
    ASSERT_NEAR(cosine[1], std::cos(second), tolerance) << second;
  }
}

TEST(SineCosine, AreThoseOfTheLibrary) {
  expectThoseOfTheLibrary(1e-9);
  expectThoseOfTheLibrary(10);
  expectThoseOfTheLibrary(1e5);
  expectThoseOfTheLibrary(1e11);
}

}  // namespace
}  // namespace haptics::sine_cosine_test
