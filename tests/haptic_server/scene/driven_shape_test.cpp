// Lattices that come in a stream, from the edit to the force.
#include "haptic_server/scene/driven_shape.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "haptic_server/engine/step/two_hands.h"
#include "haptic_server/scene/servo_scene_builder.h"
#include "tests/haptic_server/engine/step/virtual_servo.h"
#include "tests/haptic_server/scene/scene_edits.h"

namespace haptics::driven_shape_test {
namespace {

using namespace test;
using ::testing::HasSubstr;
using ::testing::SizeIs;

constexpr SessionId kAlice = 11;
constexpr double kSide_m = 0.2, kStiffness_N_per_m = 800;
constexpr StepConfig kConfig{.period_s = 1e-3, .maxForce_N = 100};

/// Of the box of the mesh, so many points a side, all of them by `shift` from where they do nothing, grown by `growth`.
[[nodiscard]] SetDeformation lattice(Vec3 size, Vec3 shift, std::uint32_t points = 2, Vec3 growth = Vec3(1)) {
  Lattice lattice{.low_m = -size / 2.0, .size_m = size, .points = {points, points, points}, .control_m = {}};
  for (std::uint32_t i = 0; i < points * points * points; ++i) {
    const Vec3 share(i % points, i / points % points, i / (points * points));
    lattice.control_m.emplace_back((lattice.low_m + share / (points - 1.0) * size) * growth + shift);
  }
  SetDeformation set{named("a"), {}, true};
  set.deformation.lattice = std::move(lattice);
  return set;
}

[[nodiscard]] Operation plain(SetDeformation set) {
  set.kinematic = false;
  return set;
}

class DrivenShapeTest : public ::testing::Test {
 protected:
  void accept(const Transaction& transaction) {
    const EditOutcome outcome = sequencer.submit(kAlice, ++seq, transaction);
    if (const auto* error = std::get_if<Error>(&outcome)) ADD_FAILURE() << error->text();
  }
  [[nodiscard]] Error reject(const Transaction& transaction) {
    return std::get<Error>(sequencer.submit(kAlice, ++seq, transaction));
  }
  [[nodiscard]] std::shared_ptr<const ServoScene> scene() {
    return builder.make(sequencer, 0, ServoSceneBuilder::Plan::kKeep);
  }
  [[nodiscard]] DrivenShape shape() const {
    const auto& all = sequencer.drivenShapes();
    return all.empty() ? DrivenShape{} : all.begin()->second;
  }
  void addBox(Vec3 size, std::uint32_t segments = 4) {
    AddObject object{"a", MeshSource{BoxSource{size, segments}}, {}, {}};
    object.material.stiffness_N_per_m = kStiffness_N_per_m;
    object.material.damping_Ns_per_m = 0;
    accept(edit(object));
  }

  BoxResolver resolver;
  Sequencer sequencer{1, resolver};
  ServoSceneBuilder builder{nullptr, {.hands = 2}};
  std::uint64_t seq = 0;
};

TEST_F(DrivenShapeTest, ASampleMakesNoRevisionAndIsOneMoreInEachEdit) {
  addBox(Vec3(0.1));
  const auto before = sequencer.history();
  accept(edit(lattice(Vec3(0.1), {0, 0, 0.01})));
  EXPECT_EQ(sequencer.history(), before);
  const std::uint64_t first = shape().number;
  EXPECT_EQ(shape().first(), first);
  ASSERT_THAT(shape().samples, SizeIs(2));
  EXPECT_FALSE(shape().samples[0]->lattice) << "before it comes the object's own";
  accept(edit(lattice(Vec3(0.1), {0, 0, 0.02}), lattice(Vec3(0.1), {0, 0, 0.03})));
  EXPECT_EQ(shape().number, first + 1) << "only the last of an edit is given to the servo";
  ASSERT_THAT(shape().samples, SizeIs(3));
  EXPECT_FLOAT_EQ(shape().samples[2]->lattice->control_m[0].z, -0.05F + 0.03F);
  for (int i = 0; i < 5; ++i) accept(edit(lattice(Vec3(0.1), {0, 0, 0.01 * i})));
  EXPECT_THAT(shape().samples, SizeIs(ShapeSamples::kMax));
  EXPECT_EQ(shape().first(), 0U) << "the first is not among them any more";
}

TEST_F(DrivenShapeTest, EndsWithWhatSetsTheShapeOrMakesTheObjectUnfit) {
  const auto drive = [] { return lattice(Vec3(0.1), {0, 0, 0.01}); };
  SurfaceEdit rounded;
  rounded.shading = std::optional<Shading>(Shading{.crease_rad = 0.5});
  MotionProperties moving, tool;
  moving.mass_kg = 0.1;
  tool.tool = ToolProperties{.spacing_m = 0.003, .torsion_Nm_per_rad = 0.5};
  addBox(Vec3(0.1));
  std::uint64_t last = 0;
  for (const Operation& end : {plain(drive()), Operation(RemeshObject{named("a"), box()}), setSurface(rounded),
                               Operation(SetMotion{named("a"), moving})}) {
    accept(edit(drive()));
    EXPECT_GT(shape().number, last) << "a later stream has numbers of its own";
    last = shape().number;
    accept(edit(moveTo("a", {0, 0, 1})));
    EXPECT_EQ(shape().number, last) << "a pose leaves it";
    accept(edit(end));
    EXPECT_EQ(shape().number, 0U);
    accept(edit(remove("a")));
    addBox(Vec3(0.1));
  }
  accept(edit(drive()));
  accept(edit(add("bar", box(0.02)), SetMotion{named("bar"), tool}));
  EXPECT_EQ(shape().number, 0U);
  EXPECT_THAT(reject(edit(drive())).text(), HasSubstr("set_deformation.kinematic: is not for scenes with a tool"));
}

TEST_F(DrivenShapeTest, RefusesWhatIsNoMotionOfVertices) {
  addBox(Vec3(0.1));
  const auto drive = [] { return lattice(Vec3(0.1), {0, 0, 0.01}); };
  const auto refusal = [this](SetDeformation set) { return reject(edit(std::move(set))).text(); };
  SetDeformation soft = drive(), none = drive();
  soft.deformation.softness = std::optional<Softness>(Softness{.stiffness_N_per_m = 1, .radius_m = 0.1});
  none.deformation.lattice = std::optional<Lattice>();
  EXPECT_THAT(refusal(soft), HasSubstr("operations[0].set_deformation.deformation: has a lattice"));
  EXPECT_THAT(refusal(none), HasSubstr("operations[0].set_deformation.deformation: has a lattice"));
  EXPECT_THAT(refusal(lattice(Vec3(0.1), Vec3(0), 2, {1, 1, -1})), HasSubstr("deformation.lattice: turns the object"));
  EXPECT_THAT(refusal(lattice(Vec3(0.05), Vec3(0))), HasSubstr("deformation.lattice.low_m"));
  EXPECT_THAT(reject(edit(drive(), remove("a"))).text(), HasSubstr("operations[1]"));
  EXPECT_EQ(shape().number, 0U);
  MotionProperties moving, met;
  moving.mass_kg = 0.1;
  met.fixed = true;
  met.collision.emplace();
  accept(edit(SetMotion{named("a"), moving}));
  EXPECT_THAT(refusal(drive()), HasSubstr("kinematic: is not for \"a\", which moves by itself"));
  accept(edit(SetMotion{named("a"), met}));
  EXPECT_THAT(refusal(drive()), HasSubstr("which meets other bodies"));

  Sequencer small(1, resolver, {.driven_triangles = 100});
  static_cast<void>(small.submit(kAlice, 1, edit(add("a", MeshSource{BoxSource{Vec3(0.1), 4}}))));
  EXPECT_THAT(std::get<Error>(small.submit(kAlice, 2, edit(drive()))).text(),
              HasSubstr("of 192 triangles; at most 100"));
}

/// A plate whose upper face goes up under two hands by lattices of so many points that come every so many ticks.
struct Stream {
  double speed_m_per_s;
  int period;
  std::uint32_t points;
};
class StreamedPlate : public DrivenShapeTest, public ::testing::WithParamInterface<Stream> {};

TEST_P(StreamedPlate, PushesBothHandsAndPassesNone) {
  const auto [speed_m_per_s, period, points] = GetParam();
  constexpr double kHip_m = 0.15 + 5e-5 + 1e-4;  // two of the streams first touch it in the tick of a sample
  const Vec3 size(kSide_m, kSide_m, 1e-4);
  addBox(size);
  HapticState second(kConfig);
  followFirstHand(second);
  fixture::VirtualServo first([](std::uint64_t) { return Vec3(0.013, 0.007, kHip_m); }, kConfig);
  const Vec3 secondHip(-0.031, 0.022, kHip_m + 0.004);
  std::shared_ptr<const ServoScene> now = scene(), before;
  const auto give = [&] {
    before = std::exchange(now, scene());
    first.adopt(now);
    ASSERT_TRUE(first.adopted());
    ASSERT_TRUE(adoptScene(*now, second, first.tick()));
  };
  give();
  double to_m = 0, top_m = 0;
  for (int tick = 0, due = 600; top_m < kHip_m + 0.02; ++tick) {  // after the force has come
    if (tick == due) {
      due += period;
      to_m += speed_m_per_s * 1e-3 * period;
      accept(edit(lattice(size, {0, 0, to_m}, points)));
      give();
    }
    const TelemetrySample felt = first.step();
    const StepInput input{first.tick() - 1, 0, {secondHip, DeviceState::kReady, {}}};
    const TelemetrySample feltBySecond = hapticStep(*now, second, kConfig, input);
    const CollisionMesh& surface = *first.state().bodies[0].surface;
    ASSERT_NEAR(surface.low().z - second.bodies[0].surface->low().z, 0, 1e-9);
    const double last_m = std::exchange(top_m, surface.high().z);
    ASSERT_LE(top_m - last_m, 1.07 * std::max(speed_m_per_s, 1.0) * 1e-3) << "no jump, tick " << tick;
    if (tick < 700) continue;  // it has caught up
    ASSERT_NEAR(top_m - last_m, speed_m_per_s * 1e-3, 1e-3 * speed_m_per_s * 1e-3 + 1e-8) << tick;
    ASSERT_NEAR(felt.force.written.z, kStiffness_N_per_m * std::max(top_m - kHip_m, 0.0), 1e-3) << tick;
    ASSERT_NEAR(feltBySecond.force.written.z, kStiffness_N_per_m * std::max(top_m - secondHip.z, 0.0), 1e-3) << tick;
  }
}
INSTANTIATE_TEST_SUITE_P(Streams, StreamedPlate,
                         ::testing::Values(Stream{0.02, 16, 2}, Stream{0.3, 5, 8}, Stream{1, 16, 3}, Stream{1, 50, 2}));

TEST_F(DrivenShapeTest, SamplesThatComeAtOnceAndPausesMakeNoJump) {
  const Vec3 size(kSide_m, kSide_m, 0.01);
  addBox(size);
  fixture::VirtualServo servo([](std::uint64_t) { return Vec3(0.013, 0.007, 0.03); }, kConfig);
  servo.adopt(scene());
  double top_m = 0, to_m = 0;
  for (int tick = 0; tick < 3000; ++tick) {
    if (tick > 600 && tick < 2800 && tick % 16 == 0 && tick % 500 > 150) {
      const int atOnce = tick % 160 == 0 ? 3 : 1;
      for (int i = 0; i < atOnce; ++i) {
        to_m += 0.0003;
        accept(edit(lattice(size, {0, 0, to_m})));
        servo.adopt(scene());  // of some only the last one is adopted
      }
    }
    static_cast<void>(servo.step());
    const double last_m = std::exchange(top_m, servo.state().bodies[0].surface->high().z);
    ASSERT_LE(tick > 0 ? std::abs(top_m - last_m) : 0, 1.1e-3) << tick;
  }
  EXPECT_NEAR(top_m, 0.005 + to_m, 1e-6);
}

TEST_F(DrivenShapeTest, APlainEditPutsTheVerticesBackUnderTheScene) {
  const Vec3 size(kSide_m, kSide_m, 0.01);
  addBox(size);
  fixture::VirtualServo servo([](std::uint64_t) { return Vec3(0.013, 0.007, 0.1); }, kConfig);
  servo.adopt(scene());
  servo.run(600);
  accept(edit(lattice(size, {0, 0, 0.02})));
  servo.adopt(scene());
  servo.run(50);
  EXPECT_NEAR(servo.state().bodies[0].surface->high().z, 0.025, 1e-7);
  accept(edit(plain(lattice(size, {0, 0, 0.001}))));
  servo.adopt(scene());
  servo.run(2);
  EXPECT_NEAR(servo.state().bodies[0].surface->high().z, 0.006, 1e-7);
  EXPECT_EQ(servo.state().reshaped.count, 0U);
  accept(edit(lattice(size, {0, 0, 0.01})));
  accept(edit(plain(lattice(size, {0, 0, 0.001}))));
  accept(edit(lattice(size, {0, 0, 0.02})));
  servo.adopt(scene());
  servo.step();
  EXPECT_NEAR(servo.state().bodies[0].surface->high().z, 0.007, 1e-6) << "it goes from the scene's, at 1 m/s";
}

}  // namespace
}  // namespace haptics::driven_shape_test
