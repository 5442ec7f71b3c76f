// Objects that are driven: motions that push the hand, in every tick or from sample to sample.
#include <gtest/gtest.h>

#include <algorithm>

#include "common/maths/rotation.h"
#include "common/mesh/generators.h"
#include "haptic_server/engine/step/kinematic_motion.h"
#include "haptic_server/engine/step/moving_bodies.h"
#include "tests/haptic_server/engine/step/virtual_servo.h"

namespace haptics::kinematic_motion_tests {
namespace {

using namespace fixture;

constexpr StepConfig kConfig{.period_s = 1e-3, .maxForce_N = 100};
constexpr double kStiffness_N_per_m = 800;
constexpr std::uint64_t kSamplePeriod = 16;  // ticks

/// A plate of 0.2 x 0.2 m whose upper face is at z = 0, driven from sample to sample under a hand.
class DrivenPlate : public ::testing::TestWithParam<double> {
 protected:
  explicit DrivenPlate(double hip_m = 0) : hip_m_(hip_m) {}

  static std::shared_ptr<const CollisionMesh> plate(double thickness_m) {
    return surfaceOf(makeBox(Vec3(0.2, 0.2, thickness_m), 2).value());
  }
  void use(double thickness_m) {
    half_m_ = thickness_m / 2;
    object_ = objectOf(1, plate(thickness_m), Vec3(0, 0, -0.05 - half_m_), kStiffness_N_per_m);
    object_.damping_Ns_per_m = 0;
    servo_.adopt(sceneOf(++revision_, {object_}));
    servo_.run(10);
  }
  /// Its upper face is to go to this height.
  void drive(double height_m) {
    sample_ = {sample_.number + 1, Pose{Quat(1, 0, 0, 0), Vec3(0, 0, height_m - half_m_)}, sample_.first_s};
    adopt();
  }
  void adopt() {
    auto scene = sceneOf(++revision_, {object_});
    scene->kinematic = {sample_};
    servo_.adopt(std::move(scene));
  }
  [[nodiscard]] double height_m() const { return servo_.state().bodies[0].current.position.z + half_m_; }

  double hip_m_;
  double half_m_ = 0;
  ServoObject object_;
  KinematicPose sample_;
  std::uint64_t revision_ = 0;
  VirtualServo servo_{[this](std::uint64_t) { return Vec3(0.013, 0.007, hip_m_); }, kConfig};
};

TEST_P(DrivenPlate, PushesTheRestingHandAtAnySpeed) {
  use(1e-4);
  const double perSample_m = GetParam() * kSamplePeriod * kConfig.period_s;
  double to_m = height_m();
  for (int sample = 0; sample < 12; ++sample) drive(to_m), servo_.run(kSamplePeriod);  // the stream begins at rest
  for (int sample = 0; to_m < 0.06; ++sample) {
    drive(to_m += perSample_m);
    for (std::uint64_t i = 0; i < kSamplePeriod; ++i) {
      const TelemetrySample felt = servo_.step();
      const double depth_m = std::max(height_m() - hip_m_, 0.0);
      ASSERT_NEAR(felt.force.written.z, kStiffness_N_per_m * depth_m, 1e-6);
    }
    ASSERT_NEAR(height_m(), to_m, 1e-15) << "it is there when the next sample comes";
  }
  EXPECT_GT(height_m(), 0.05);
}
INSTANTIATE_TEST_SUITE_P(Speeds, DrivenPlate, ::testing::Values(0.001, 0.03, 0.3, 1.0));

TEST_F(DrivenPlate, MovesEvenlyBetweenSamples) {
  use(0.01);
  const double from_m = height_m();
  drive(from_m);
  servo_.run(kSamplePeriod);
  drive(from_m + 0.016);
  for (int i = 1; i <= 16; ++i) {
    servo_.step();
    EXPECT_NEAR(height_m(), from_m + 1e-3 * i, 1e-12);
  }
  servo_.step();
  EXPECT_FALSE(servo_.state().bodies[0].moving) << "until the next sample comes it stays";
}

TEST_F(DrivenPlate, ASampleInEveryTickIsReachedInThatTick) {
  use(0.01);
  const double from_m = height_m();
  for (int i = 1; i <= 60; ++i) {
    drive(from_m + 1e-3 * i);
    servo_.step();
    ASSERT_DOUBLE_EQ(height_m(), from_m + 1e-3 * i);
  }
}

TEST_F(DrivenPlate, AFirstSampleIsReachedAtFirstSpeedOrWithinTheLongestPause) {
  use(0.01);
  const double from_m = height_m();
  drive(from_m + 0.02);
  servo_.step();
  EXPECT_NEAR(height_m(), from_m + kFirstSpeed_m_per_s * kConfig.period_s, 1e-9);
  servo_.run(19);
  EXPECT_DOUBLE_EQ(height_m(), from_m + 0.02);
  servo_.run(200);
  drive(from_m + 2);
  servo_.run(99);
  EXPECT_LT(height_m(), from_m + 2);
  servo_.step();
  EXPECT_DOUBLE_EQ(height_m(), from_m + 2);
}

TEST_F(DrivenPlate, AClientsFirstSampleIsNoBlowToAHandThatPresses) {
  use(0.01);
  hip_m_ = -0.052;
  servo_.run(10);
  sample_.first_s = kFirstSample_s;
  const double to_m = height_m() + 3e-4;
  double last_N = servo_.step().force.written.z;
  ASSERT_NEAR(last_N, kStiffness_N_per_m * 0.002, 1e-6);
  drive(to_m);
  for (int i = 0; i < 17; ++i) {
    const double now_N = servo_.step().force.written.z;
    EXPECT_NEAR(now_N - last_N, kStiffness_N_per_m * 3e-4 / 17, 1e-6) << i;
    last_N = now_N;
  }
  EXPECT_DOUBLE_EQ(height_m(), to_m);
}

TEST_F(DrivenPlate, StaysWhereItIsOverOtherEditsAndGoesBackByAPose) {
  use(0.01);
  const double from_m = height_m();
  drive(from_m - 0.02);
  servo_.run(200);
  object_.stiffness_N_per_m = 500;
  adopt();
  servo_.run(5);
  EXPECT_DOUBLE_EQ(height_m(), from_m - 0.02);
  sample_ = {};
  object_.poseRevision = revision_ + 1;
  adopt();
  servo_.run(5);
  EXPECT_DOUBLE_EQ(height_m(), from_m);
  MotionState motion;
  static_cast<void>(updateMotionState(servo_.state(), servo_.tick(), motion));
  EXPECT_EQ(motion.bodyCount, 0U);
}

TEST_F(DrivenPlate, IsReportedAsABodyThatMoves) {
  use(0.01);
  drive(height_m() - 0.02);
  servo_.step();
  MotionState motion;
  EXPECT_TRUE(updateMotionState(servo_.state(), servo_.tick(), motion));
  ASSERT_EQ(motion.bodyCount, 1U);
  EXPECT_EQ(motion.body[0].object, 1U);
  EXPECT_EQ(motion.body[0].pose, servo_.state().bodies[0].current);
  EXPECT_EQ(motion.body[0].condition, BodyCondition::kAwake);
}

}  // namespace
}  // namespace haptics::kinematic_motion_tests
