#include <gtest/gtest.h>

#include <random>

#include "common/maths/rotation.h"
#include "haptic_server/device/movable_workspace.h"
#include "haptic_server/engine/geometry/spaced_points.h"
#include "haptic_server/engine/step/tool_step.h"
#include "tests/haptic_server/engine/step/surface_world.h"

namespace haptics::fixture::clutch_tests {
namespace {

/// 30 N/s: what an edit may do too.
constexpr double kMaxStep_N = 0.03;
constexpr double kRadius_m = 0.05;
constexpr int kEngagements = 1000;
/// Of at most 2.5 N, at 30 N/s.
constexpr int kFades = 90;
const StepConfig kConfig{.maxForce_N = 2.5, .rotation = {.radius_m = kRadius_m, .maxTorque_Nm = 0.1}};

class PutDevice final : public Device {
 public:
  [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }
  [[nodiscard]] DeviceReading read(std::uint64_t) noexcept override { return reading; }
  void write(Vec3) noexcept override {}
  void stop() noexcept override {}

  DeviceReading reading{{.position = {0, 0, 0.02}, .state = DeviceState::kReady}};

 private:
  DeviceInfo info_;
};

/// A hand that comes down on what is there, and then takes hold of its workspace and lets it go again and again: it moves at
/// random in contact, rests for a moment, presses, moves anywhere, rests, lets go.
class ClutchingHand {
 public:
  ClutchingHand(const std::shared_ptr<const ServoScene>& scene, unsigned seed)
      : servo_({}, kConfig, scene), random_(seed) {
    EXPECT_TRUE(workspace_.move({.scale = 1.5, .rotation = rotationBy({0, 0, 0.7}), .clutchButtons = 1}));
    (void)step();
  }

  /// In the world, at 0.1 m/s.
  void moveTo(Vec3 world, Vec3 turn_rad) {
    const Vec3 from = device_.reading.position,
               to = from + glm::conjugate(rotationBy({0, 0, 0.7})) * (world - at_) / 1.5;
    const Quat turned = device_.reading.rotation;
    const int ticks = 1 + static_cast<int>(glm::distance(world, at_) / 1e-4);
    for (int i = 1; i <= ticks; ++i) {
      device_.reading.position = glm::mix(from, to, static_cast<double>(i) / ticks);
      device_.reading.rotation = rotationBy(turn_rad * static_cast<double>(i) / static_cast<double>(ticks)) * turned;
      (void)step();
    }
  }
  /// The largest step of the force, N, and of the torque, on its radius, while the hand rests.
  double rest(int ticks) {
    double largest = 0;
    for (int i = 0; i < ticks; ++i) {
      const Vec3 force = sample_.force.written, torque = torque_;
      (void)step();
      largest =
          std::max({largest, glm::distance(force, sample_.force.written), glm::distance(torque, torque_) / kRadius_m});
    }
    return largest;
  }
  void press(bool pressed) { device_.reading.status.buttons = pressed ? 1 : 0; }
  /// What the hand does with its device while the workspace moves with it.
  void wander() {
    for (int i = 0; i < 20; ++i) {
      device_.reading.position += Vec3(any(), any(), any()) * 0.01;
      device_.reading.rotation = glm::normalize(rotationBy(0.1 * Vec3(any(), any(), any())) * device_.reading.rotation);
      (void)step();
      EXPECT_EQ(sample_.force.written, Vec3(0));
    }
  }
  double any() { return std::uniform_real_distribution<double>(-1, 1)(random_); }
  [[nodiscard]] const TelemetrySample& sample() const { return sample_; }
  [[nodiscard]] Vec3 torque() const { return torque_; }

 private:
  const TelemetrySample& step() {
    const DeviceReading reading = workspace_.read(servo_.tick());
    sample_ = servo_.stepWith(reading);
    at_ = reading.position;
    torque_ = writtenTorque_Nm(servo_.state());
    return sample_;
  }

  PutDevice device_;
  MovableWorkspace workspace_{device_, 1e-3};
  VirtualServo servo_;
  std::mt19937 random_;
  TelemetrySample sample_;
  Vec3 at_{0}, torque_{0};
};

/// @param settled_N  By so much the force at rest may still change.
/// @return How many of the engagements were in contact, with friction, and with a torque.
std::array<int, 3> engage(ClutchingHand& hand, double deepest_m, double settled_N) {
  std::array<int, 3> were{};
  for (int i = 0; i < kEngagements; ++i) {
    hand.moveTo({0.005 * hand.any(), 0.005 * hand.any(), deepest_m * (hand.any() - 0.7) / 2},
                0.05 * Vec3(hand.any(), hand.any(), hand.any()));
    (void)hand.rest(20);
    const Vec3 force = hand.sample().force.written;
    were[0] += hand.sample().object != 0;
    were[1] += glm::length(hand.sample().force.friction) > 0.1;
    were[2] += hand.torque() != Vec3(0);
    hand.press(true);
    EXPECT_LE(hand.rest(kFades), kMaxStep_N + 1e-9) << i;
    EXPECT_EQ(hand.sample().force.written, Vec3(0));
    hand.wander();
    hand.press(false);
    EXPECT_LE(hand.rest(kFades), kMaxStep_N + 1e-9) << i;
    EXPECT_LT(glm::distance(hand.sample().force.written, force), settled_N) << i << ": the contact is what it was";
    if (testing::Test::HasFailure()) break;
  }
  return were;
}

TEST(Clutch, EngagesInContactAndFrictionWithoutAStep) {
  ClutchingHand hand(sceneOf(1, {with(slab(), friction(0.8, 0.5))}), 1);
  const auto [contact, rubbing, torque] = engage(hand, 0.003, 1e-3);
  EXPECT_GT(contact, kEngagements / 2);
  EXPECT_GT(rubbing, kEngagements / 2);
}

TEST(Clutch, EngagesAToolInContactWithoutAStep) {
  const TriMesh bar = makeBox({0.04, 0.02, 0.01}, 2).value();
  ServoObject tool = objectOf(2, surfaceOf(bar), {}, kStiffness);
  tool.tool = std::make_shared<const Tool>(Tool{tool.surface, makeToolShell(*tool.surface, 0.004).value()});
  tool.torsion_Nm_per_rad = 0.5;
  ServoObject floor = slab();
  floor.sharp = std::make_shared<const std::vector<Vec3>>(sharpPoints(*floor.surface, 0.004, kMaxToolPoints));
  ClutchingHand hand(sceneOf(1, {floor, tool}), 2);
  const auto [contact, rubbing, torque] = engage(hand, 0.008, 0.05);
  EXPECT_GT(contact, kEngagements / 2);
  EXPECT_GT(torque, kEngagements / 2);
}

}  // namespace
}  // namespace haptics::fixture::clutch_tests
