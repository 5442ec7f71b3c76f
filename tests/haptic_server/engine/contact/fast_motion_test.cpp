// However fast the HIP is, a tick moves the IHIP along the path of a slow hand.

#include <gtest/gtest.h>

#include <random>

#include "haptic_server/engine/contact/contact.h"
#include "tests/haptic_server/engine/contact/contact_rig.h"

namespace haptics::fast_motion_test {
namespace {

/// A ball whose vertices stand high and low, so that under a deep HIP one minimum of the distance ends after the other.
shapes::Shape roughBall(double radius) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> height(0.97, 1.03);
  return shapes::sphere(radius, 24).mapped([&](Vec3 v) { return v * height(random); });
}

TEST(FastMotion, EndsWhereSmallTicksEnd) {
  constexpr double kRadius_m = 0.04;
  constexpr double kSame_m = 1e-6;
  constexpr int kTicks = 5000;
  constexpr int kParts = 256;
  ContactRig fast;
  fast.add(roughBall(kRadius_m));
  std::mt19937_64 random(3);
  std::normal_distribution<double> push(0, 1);
  Vec3 hip(0.001, 0.002, 0.05);
  fast.place(hip);
  Vec3 step(0);
  int touching = 0;
  int elsewhere = 0;
  for (int i = 0; i < kTicks; ++i) {
    step = step * 0.9 + Vec3(push(random), push(random), push(random)) * 0.0004;
    step -= hip * (0.01 * (glm::length(hip) - 0.85 * kRadius_m) / glm::length(hip));
    ContactRig slow = fast;
    for (int part = 1; part < kParts; ++part) (void)slow.tick(hip + step * (part / static_cast<double>(kParts)));
    hip += step;
    const ContactResult small = slow.tick(hip);
    const ContactResult one = fast.tick(hip);
    touching += one.touching ? 1 : 0;
    elsewhere += glm::distance(one.ihip, small.ihip) > kSame_m ? 1 : 0;
  }
  EXPECT_GT(touching, kTicks / 2);
  EXPECT_LE(elsewhere, 0);
}

}  // namespace
}  // namespace haptics::fast_motion_test
