#include "graphics_client/viewer/palette.h"

#include <gtest/gtest.h>

namespace haptics::palette {
namespace {

/// WCAG 2.1.
constexpr double kReadable = 4.5;

double luminance(Shade shade) {
  const auto light = [](double part) { return part <= 0.04045 ? part / 12.92 : std::pow((part + 0.055) / 1.055, 2.4); };
  return 0.2126 * light(shade.red) + 0.7152 * light(shade.green) + 0.0722 * light(shade.blue);
}

double contrast(Shade a, Shade b) {
  const auto [less, more] = std::minmax({luminance(a), luminance(b)});
  return (more + 0.05) / (less + 0.05);
}

TEST(Palette, MeasuresContrastAsTheStandardDoes) {
  EXPECT_NEAR(contrast({0, 0, 0}, {1, 1, 1}), 21, 1e-9);
  EXPECT_NEAR(contrast({0.4667, 0.4667, 0.4667}, {1, 1, 1}), 4.48, 0.01);  // #777, the usual example of too little
}

TEST(Palette, WordsOnCardsAreReadWhateverIsBehindThem) {
  for (const Shade behind : {Shade{0, 0, 0}, Shade{1, 1, 1}, kSkyTop, kForceHigh, kIhip}) {
    const Shade card = mix(behind, kCard, kCardOpacity);
    for (const Shade words : {kText, kLabel, kGood, kWarning, kBad}) {
      EXPECT_GE(contrast(words, card), kReadable)
          << words.red << ' ' << words.green << " over " << behind.red << ' ' << behind.green;
    }
  }
}

TEST(Palette, WordsOnBannersAreRead) {
  for (const Shade banner : {kWarning, kBad}) {
    EXPECT_GE(contrast(kCard, mix({1, 1, 1}, banner, kCardOpacity)), kReadable);
    EXPECT_GE(contrast(kCard, banner), kReadable);
  }
}

}  // namespace
}  // namespace haptics::palette
