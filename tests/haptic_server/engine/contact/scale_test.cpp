// Nothing depends on the unit of length. S12 of the failure scenes.

#include <gtest/gtest.h>

#include <bit>
#include <random>

#include "haptic_server/engine/contact/contact.h"
#include "tests/haptic_server/engine/contact/contact_rig.h"

namespace haptics::scale_test {
namespace {

/// A walk over overlapping, moving and self-crossing bodies, all lengths times `scale`.
std::vector<Vec3> walk(double scale) {
  shapes::Shape crossed = shapes::bumpy(0.03, 8);
  crossed.add(shapes::box({0.02, 0.02, 0.08}, 4), Vec3(0.01, 0.004, 0));
  ContactRig world;
  world.add(crossed.scaled(scale));
  world.add(shapes::torus(0.03, 0.01, 24, 12).scaled(scale), Vec3(0.02, 0, 0.01) * scale);
  const int moving = world.add(shapes::box({0.03, 0.03, 0.001}, 3).scaled(scale), Vec3(0, 0.02, 0) * scale);
  world.add(shapes::sheet(0.06, 4).scaled(scale), Vec3(-0.02, 0, 0.005) * scale);
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> at(-0.001, 0.001);
  Vec3 hip{0, 0, 0.07};
  Vec3 speed(0);
  world.place(hip * scale);
  std::vector<Vec3> ihips;
  for (int i = 0; i < 4000; ++i) {
    speed = speed * 0.95 + Vec3(at(random), at(random), at(random)) - hip * 0.001;
    hip += speed;
    world.move(moving,
               {glm::angleAxis(0.002 * i, Vec3(0.6, 0, 0.8)), Vec3(0.01 * std::sin(0.01 * i), 0.02, 0) * scale});
    const ContactResult r = world.tick(hip * scale);
    ihips.push_back(r.ihip / scale);
    EXPECT_TRUE(isFinite(r.ihip));
  }
  return ihips;
}

TEST(Scale, PowersOfTwoChangeNoBit) {
  const std::vector<Vec3> expected = walk(1);
  for (const double scale : {0x1p-10, 0x1p-3, 0x1p10}) {
    const std::vector<Vec3> scaled = walk(scale);
    for (std::size_t i = 0; i < expected.size(); ++i) {
      for (int d = 0; d < 3; ++d) {
        ASSERT_EQ(std::bit_cast<std::uint64_t>(scaled[i][d]), std::bit_cast<std::uint64_t>(expected[i][d]))
            << "tick " << i << " at " << scale;
      }
    }
  }
}

TEST(Scale, PowersOfTenAgreeToFourDigits) {
  // Rounding the vertices anew changes the shape by 2^-24; a walk on a sphere stays the same walk.
  const auto slide = [](double scale) {
    ContactRig world(shapes::sphere(0.05, 16).scaled(scale));
    world.place(Vec3(0, 0, 0.051) * scale);
    std::vector<Vec3> ihips;
    for (int i = 0; i < 1000; ++i) {
      const double a = 0.003 * i;
      ihips.push_back(world.tick(Vec3(std::sin(a), std::sin(0.3 * a), std::cos(a)) * 0.047 * scale).ihip / scale);
    }
    return ihips;
  };
  const std::vector<Vec3> expected = slide(1);
  for (const double scale : {1e-3, 0.1, 1e3}) {
    const std::vector<Vec3> scaled = slide(scale);
    for (std::size_t i = 0; i < expected.size(); ++i)
      EXPECT_NEAR(glm::distance(scaled[i], expected[i]), 0, 0.05 * 1e-5);
  }
}

}  // namespace
}  // namespace haptics::scale_test
