#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "haptic_server/servo/settling.h"
#include "haptic_server/servo/stability_search.h"

namespace haptics::settling_tests {
namespace {

class Rendered final : public ForceRenderer {
 public:
  using Law = std::function<Vec3(Vec3 measured, int tick)>;
  explicit Rendered(Law law) : law_(std::move(law)) {}
  Vec3 tick(Vec3 measured) override { return law_(measured, tick_++); }

 private:
  Law law_;
  int tick_ = 0;
};

Rendered::Law spring(double stiffness_N_per_m) {
  return [=](Vec3 measured, int) { return Vec3(0, 0, stiffness_N_per_m * std::max(0.0, -measured.z)); };
}

PressTrial trial(Rendered::Law law, const char* hand = "none", PressKind kind = {0.5, 0}) {
  return {{findDevicePreset("omni").value(), findHandPreset(hand).value(), 1e-3, 0, kind.force_N, kind.tap_m_per_s},
          std::make_unique<Rendered>(std::move(law))};
}

template <class... Trials>
bool restTogether(Trials... trials) {
  std::vector<PressTrial> all;
  (all.push_back(std::move(trials)), ...);
  return allComeToRest(all, Vec3(0));
}

TEST(Settling, ASoftSpringComesToRestAndAStiffOneRings) {
  EXPECT_TRUE(restTogether(trial(spring(800))));
  EXPECT_TRUE(restTogether(trial(spring(800), "light")));
  EXPECT_FALSE(restTogether(trial(spring(200e3))));
}

TEST(Settling, ADeviceThatNothingHoldsBackIsThrown) {
  EXPECT_FALSE(restTogether(trial([](Vec3, int) { return Vec3(0); })));
}

TEST(Settling, AllTrialsHaveToRest) {
  EXPECT_TRUE(restTogether(trial(spring(800)), trial(spring(400), "light"), trial(spring(800), "none", {0.5, 0.15})));
  EXPECT_FALSE(restTogether(trial(spring(800)), trial(spring(200e3)), trial(spring(400), "light")));
}

TEST(Settling, RestIsNotTakenForGrantedWhileTheForceStillChanges) {
  // Friction (0.26 N) holds the device against 0.5 N less what grows by 1 N/s, for half a second: then it is pushed off.
  const auto growing = [](Vec3, int tick) { return Vec3(0, 0, 0.5 + 1e-3 * tick); };
  EXPECT_FALSE(restTogether(trial(growing)));
}

TEST(Settling, TriesTheWaysOfPressingThatAreDocumented) {
  const auto kinds = pressKinds();
  ASSERT_EQ(kinds.size(), 4U);
  EXPECT_EQ(kinds[0].force_N, 0.5);
  EXPECT_EQ(kinds[1].force_N, 1);
  EXPECT_EQ(kinds[2].tap_m_per_s, 0.02);
  EXPECT_EQ(kinds[3].tap_m_per_s, 0.15);
}

TEST(StabilitySearch, FindsTheLargestThatIsStableButNothingAboveAnUnstableOneThatItTried) {
  const StabilitySearch search{.least = 50, .most = 200e3};
  const double largest = largestStable(search, [](double k) { return k <= 1000; });
  EXPECT_LE(largest, 1000);
  EXPECT_GT(largest, 1000 / search.close);
  const double firstTried = 50 * search.climb * search.climb;
  EXPECT_LT(largestStable(search, [&](double k) { return k < 0.99 * firstTried || k > 1.01 * firstTried; }),
            firstTried);
  EXPECT_EQ(largestStable(search, [](double) { return false; }), 0);
  const double all = largestStable(search, [](double) { return true; });
  EXPECT_LE(all, search.most);
  EXPECT_GT(all, search.most / search.climb);
}

TEST(StabilitySearch, OfOneThatAsksForMoreTheResultIsNeverLarger) {
  for (int seed = 1; seed < 2000; ++seed) {
    const auto unstable = [seed](double k, int salt) { return static_cast<int>(k * 7919) % (37 + salt) < seed % 3; };
    const auto first = [&](double k) { return !unstable(k, seed % 5); };
    const auto both = [&](double k) { return first(k) && !unstable(k, 5 + seed % 7); };
    EXPECT_LE(largestStable(kStiffnessSearch, both), largestStable(kStiffnessSearch, first)) << seed;
  }
}

}  // namespace
}  // namespace haptics::settling_tests
