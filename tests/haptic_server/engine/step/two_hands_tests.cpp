#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include "haptic_server/engine/motion/solid.h"
#include "haptic_server/engine/step/moving_bodies.h"
#include "haptic_server/engine/step/two_hands.h"
#include "haptic_server/servo/allocation_tripwire.h"
#include "tests/haptic_server/engine/step/surface_world.h"

namespace haptics::fixture::two_hands_tests {
namespace {

const StepConfig kConfig{.maxForce_N = 20};
constexpr Vec3 kAway{0, 0, 1};
constexpr double kHalf_m = 0.02;

ServoObject brick(std::uint64_t id, Vec3 at, double mass_kg = 0.1) {
  const TriMesh mesh = makeBox(Vec3(2 * kHalf_m), 1).value();
  ServoObject object = objectOf(id, surfaceOf(mesh), at);
  const Solid solid = solidOf(mesh.vertices, mesh.triangles);
  RigidBody body;
  EXPECT_EQ(spreadMass(mass_kg, solid.centre, mass_kg / solid.volume_m3 * solid.inertia, body.mass), MassDefect::kNone);
  body.gravity_m_per_s2 = Vec3(0);
  object.motion = std::make_shared<const RigidBody>(body);
  return object;
}

/// Both hands under HIPs that a test leads.
class TwoHands {
 public:
  explicit TwoHands(std::shared_ptr<const ServoScene> scene, const StepConfig& config = kConfig) : config_(config) {
    followFirstHand(second_->state);
    adopt(std::move(scene));
  }
  void adopt(std::shared_ptr<const ServoScene> scene) {
    for (Hand* hand : {first_.get(), second_.get()}) hand->next = scene;
  }
  void tick(Vec3 hip, std::optional<Vec3> secondHip) {
    for (Hand* hand : {first_.get(), second_.get()}) {
      if (hand->next && adoptScene(*hand->next, hand->state, tick_)) hand->scene = std::exchange(hand->next, nullptr);
    }
    first_->input = {tick_, 0, {hip, DeviceState::kReady}};
    second_->input = {tick_, 0, {secondHip.value_or(Vec3(0)), secondHip ? DeviceState::kReady : DeviceState::kAbsent}};
    ++tick_;
    for (Hand* hand : {first_.get(), second_.get()}) {
      hand->result = {};
      computeForce(*hand->scene, hand->state, config_, hand->input, hand->result);
    }
    finishSteps(first_->tick(config_), second_->tick(config_), first, second);
  }
  [[nodiscard]] const HapticState& state(int hand) const { return hand == 0 ? first_->state : second_->state; }
  [[nodiscard]] Vec3 placeOf(std::size_t body, int hand = 0) const { return state(hand).bodies[body].current.position; }

  TelemetrySample first, second;

 private:
  struct Hand {
    explicit Hand(const StepConfig& config) : state(config) {}
    [[nodiscard]] HandTick tick(const StepConfig& config) { return {*scene, state, config, input, result}; }

    HapticState state;
    std::shared_ptr<const ServoScene> scene = std::make_shared<ServoScene>(), next;
    StepInput input;
    ForceResult result;
  };
  StepConfig config_;
  std::unique_ptr<Hand> first_ = std::make_unique<Hand>(kConfig), second_ = std::make_unique<Hand>(kConfig);
  std::uint64_t tick_ = 0;
};

Vec3 from(double x_m) { return {x_m, 0, 0}; }

TEST(TwoHands, PushABodyByTheSumOfWhatTheyGive) {
  TwoHands hands(sceneOf(1, {brick(1, Vec3(0))}));
  for (int i = 0; i < 300; ++i) hands.tick(from(-0.03 + 4e-5 * i), from(0.03 - 4e-5 * i));
  EXPECT_GT(hands.first.penetration_m, 1e-3);
  EXPECT_NEAR(hands.first.force.written.x, -hands.second.force.written.x, 1e-9);
  EXPECT_NEAR(hands.placeOf(0).x, 0, 1e-9) << "between equal pushes it stays";
  for (int i = 0; i < 200; ++i) hands.tick(from(-0.018), kAway);
  EXPECT_GT(hands.placeOf(0).x, 1e-3) << "pushed by one alone it goes";
}

TEST(TwoHands, SecondHandPushesLikeAFirst) {
  TwoHands alone(sceneOf(1, {brick(1, Vec3(0))})), other(sceneOf(1, {brick(1, Vec3(0))}));
  for (int i = 0; i < 600; ++i) {
    const Vec3 hip = from(-0.03 + 5e-5 * i);
    alone.tick(hip, kAway);
    other.tick(kAway, hip);
    ASSERT_EQ(alone.first.force.written, other.second.force.written) << i;
    ASSERT_EQ(alone.placeOf(0), other.placeOf(0)) << i;
    ASSERT_EQ(alone.first.energyGiven_J, other.second.energyGiven_J) << i;
  }
  EXPECT_GT(alone.placeOf(0).x, 5e-3);
}

TEST(TwoHands, SeeEveryBodyAtTheSamePlace) {
  TwoHands hands(sceneOf(1, {brick(1, Vec3(0)), brick(2, Vec3(0.1, 0, 0)), brick(5, Vec3(0, 0.1, 0))}));
  for (int i = 0; i < 800; ++i) {
    hands.tick(from(-0.03 + 5e-5 * i), Vec3(0.002 * std::sin(0.01 * i), 0.13 - 5e-5 * i, 0));
    for (std::size_t body = 0; body < 3; ++body) {
      const Body &first = hands.state(0).bodies[body], &second = hands.state(1).bodies[body];
      ASSERT_EQ(first.current, second.current) << i << ' ' << body;
    }
  }
  EXPECT_GT(hands.placeOf(0).x, 1e-3);
  EXPECT_LT(hands.placeOf(2).y, 0.099);
}

TEST(TwoHands, EachHasFaultsOfItsOwn) {
  TwoHands hands(sceneOf(1, {slab()}));
  for (int i = 0; i < 100; ++i) hands.tick({0, 0, -0.002}, std::nullopt);
  EXPECT_EQ(hands.first.fault, Fault::kNone);
  EXPECT_EQ(hands.second.fault, Fault::kDeviceLost);
  for (int i = 0; i < 200; ++i) hands.tick({0, 0, 0.01 - 6e-5 * i}, Vec3(0.02, 0, 0.01 - 6e-5 * i));
  EXPECT_GT(hands.first.force.written.z, 0.5);
  EXPECT_GT(hands.second.force.written.z, 0.5);
  for (int i = 0; i < 40; ++i) hands.tick({0, 0, -0.002}, Vec3(std::nan("")));
  EXPECT_EQ(hands.first.fault, Fault::kNone);
  EXPECT_GT(hands.first.force.written.z, 0.5);
  EXPECT_EQ(hands.second.fault, Fault::kNonFiniteInput);
  EXPECT_EQ(hands.second.force.written, Vec3(0));
}

/// A pose edit under one hand is a motion there, while the other hand has it done at once: the body stands still until both
/// have it where it is to be, and falls on from there.
TEST(TwoHands, EditOfThePoseUnderOneHandHoldsTheBodyUntilBothHaveIt) {
  for (const bool underSecond : {false, true}) {
    ServoObject object = brick(1, Vec3(0), 5);
    RigidBody body = *object.motion;
    body.gravity_m_per_s2 = {0, 0, -1};
    TwoHands hands(sceneOf(1, {object}));
    double height_m = kHalf_m + 0.001;
    const auto tick = [&] {
      const Vec3 touching(0, 0, height_m);
      hands.tick(underSecond ? kAway : touching, underSecond ? touching : kAway);
    };
    for (int i = 0; i < 30; ++i, height_m -= 1e-4) tick();
    ASSERT_EQ(underSecond ? hands.second.object : hands.first.object, 1U);
    object.motion = std::make_shared<const RigidBody>(body);
    object.pose.position = {0, 0, 0.001};
    object.poseRevision = 2;
    hands.adopt(sceneOf(2, {object}));
    double before_N = glm::length(underSecond ? hands.second.force.written : hands.first.force.written);
    int stood = 0;
    for (int i = 0; i < 150; ++i) {
      tick();
      const double now_N = glm::length(underSecond ? hands.second.force.written : hands.first.force.written);
      ASSERT_LT(std::abs(now_N - before_N), 0.2) << i;
      before_N = now_N;
      stood += hands.placeOf(0, underSecond ? 0 : 1) == object.pose.position ? 1 : 0;
    }
    EXPECT_GT(stood, 5) << underSecond;
    for (int i = 0; i < 300; ++i) hands.tick(kAway, kAway);
    EXPECT_EQ(hands.placeOf(0, 0), hands.placeOf(0, 1)) << underSecond;
    EXPECT_LT(hands.placeOf(0).z, 0.001);
  }
}

TEST(TwoHands, SecondHandDoesNotTouchTheToolOfTheFirst) {
  ServoObject tool = objectOf(1, surfaceOf(makeBox(Vec3(0.04), 2).value()), Vec3(0));
  tool.tool = std::make_shared<const Tool>(Tool{tool.surface, makeToolShell(*tool.surface, 0.005).value()});
  tool.torsion_Nm_per_rad = 1;
  TwoHands hands(sceneOf(1, {tool, slab(2, {0, 0, -0.2})}));
  for (int i = 0; i < 400; ++i) hands.tick(Vec3(0), from(-0.03 + 1e-4 * i));
  EXPECT_EQ(hands.second.object, 0U);
  EXPECT_TRUE(hands.state(0).features.tool);
  EXPECT_FALSE(hands.state(1).features.tool);
}

TEST(TwoHands, SecondHandLeavesNoMarkInPlasticTissue) {
  ServoObject soft = slab();
  soft.tissue = std::make_shared<const SoftTissue>(SoftTissue{Falloff(0.02, 2), 300, 0, 0.9});
  TwoHands hands(sceneOf(1, {soft}));
  for (int i = 0; i < 600; ++i) hands.tick(kAway, Vec3(0, 0, 0.002 - 2e-5 * std::min(i, 500)));
  EXPECT_EQ(hands.state(1).dents.count, 1U);
  for (int i = 0; i < 3'000; ++i) hands.tick(kAway, kAway);
  EXPECT_EQ(hands.state(1).dents.count, 0U);
}

TEST(TwoHands, AllocateNothing) {
  TwoHands hands(sceneOf(1, {brick(1, Vec3(0)), brick(2, Vec3(0.1, 0, 0))}));
  hands.tick(kAway, kAway);
  const std::uint64_t before = AllocationTripwire::count();
  {
    const AllocationTripwire armed;
    for (int i = 0; i < 300; ++i) hands.tick(from(-0.03 + 5e-5 * i), from(0.13 - 5e-5 * i));
  }
  EXPECT_EQ(AllocationTripwire::count(), before);
}

}  // namespace
}  // namespace haptics::fixture::two_hands_tests
