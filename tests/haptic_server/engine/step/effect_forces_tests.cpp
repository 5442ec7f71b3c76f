// Effects in the step: frames that move, what bodies are given, edits under the hand, energy, copies.
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <random>

#include "common/mesh/generators.h"
#include "haptic_server/device/simulated_device.h"
#include "haptic_server/engine/motion/solid.h"
#include "haptic_server/engine/motion/support_points.h"
#include "haptic_server/recording/state_image.h"
#include "haptic_server/scene/effect_limits.h"
#include "haptic_server/servo/stiffness_limit.h"
#include "tests/haptic_server/engine/step/surface_world.h"

namespace haptics::fixture::effect_forces_tests {
namespace {

using Kind = Effect::Kind;
constexpr double kPeriod_s = 1e-3;
const StepConfig kWide{.period_s = kPeriod_s, .maxForce_N = 1e6};
constexpr double kRate_N = 0.03;  // of an edit in a tick

std::unique_ptr<ServoScene> carrying(std::uint64_t revision, ServoObject object, const std::vector<Effect>& effects) {
  auto scene = sceneOf(revision, {std::move(object)});
  for (std::size_t i = 0; i < effects.size(); ++i)
    scene->effects.push_back({0, i, std::make_shared<const EffectField>(effects[i])});
  return scene;
}

/// Far from the hand.
ServoObject away() { return slab(1, Vec3(0, 0, -5)); }

ServoObject floatingBox(double mass_kg, double damping_per_s) {
  const TriMesh mesh = makeBox(Vec3(0.02), 2).value();
  const Solid solid = solidOf(mesh.vertices, mesh.triangles);
  RigidBody body;
  EXPECT_EQ(spreadMass(mass_kg, solid.centre, mass_kg / solid.volume_m3 * solid.inertia, body.mass), MassDefect::kNone);
  body.setSupport(supportPoints(mesh.vertices));
  body.gravity_m_per_s2 = Vec3(0);
  body.linearDamping_per_s = body.angularDamping_per_s = damping_per_s;
  ServoObject object = objectOf(1, surfaceOf(mesh), Vec3(0));
  object.motion = std::make_shared<RigidBody>(body);
  return object;
}

/// In the frame of the body.
struct MassLaw {
  Vec3 at{0}, velocity{0};
  bool isThere = false;

  /// By m du/dt = -F, F = k (y - x) + b (u - v) at the tick's end, solved for F.
  Vec3 follow(const Effect& effect, Vec3 hip, Vec3 v) {
    if (!isThere) at = hip;
    isThere = true;
    const double k = effect.stiffness_N_per_m, b = effect.damping_Ns_per_m, m = effect.mass_kg, T = kPeriod_s;
    const Vec3 force = (k * (at + T * velocity - hip) + b * (velocity - v)) * m / (m + T * (b + T * k));
    velocity -= T / m * force;
    at += T * velocity;
    return force;
  }
};

/// Of the surface of floatingBox() or of its vertices: its sides have two segments.
Vec3 nearestOfBox(Kind kind, Vec3 x) {
  const auto half = static_cast<double>(0.01F);  // vertices are floats
  Vec3 nearest = glm::clamp(x, -half, half);
  if (kind == Kind::kMagnet) return nearest;
  if (kind == Kind::kSpringToVertex) {
    nearest = glm::round(nearest / half) * half;
    if (nearest == Vec3(0)) nearest = Vec3(1e9);
    for (int axis = 0; axis < 3; ++axis) {  // in the middle there is none
      Vec3 side = glm::round(glm::clamp(x, -half, half) / half) * half;
      side[axis] = x[axis] < 0 ? -half : half;
      if (glm::distance(side, x) < glm::distance(nearest, x)) nearest = side;
    }
    return nearest;
  }
  nearest = Vec3(1e9);
  for (int axis = 0; axis < 3; ++axis) {  // edges along it
    Vec3 on(x.x < 0 ? -half : half, x.y < 0 ? -half : half, x.z < 0 ? -half : half);
    on[axis] = glm::clamp(x[axis], -half, half);
    if (glm::distance(on, x) < glm::distance(nearest, x)) nearest = on;
  }
  return nearest;
}

/// By the poses of this tick and the last, in the world: the field's points and directions are taken there.
Vec3 inMovingFrame(const Effect& effect, const Pose& before, const Pose& now, Vec3 hip, Vec3 v, MassLaw& mass) {
  const Vec3 point = now.position + now.rotation * effect.point_m, n = now.rotation * effect.direction;
  const Vec3 at = glm::inverse(now.rotation) * (hip - now.position);
  const Vec3 relative = v - (hip - (before.position + before.rotation * at)) / kPeriod_s;
  const Vec3 from = hip - point;
  const double k = effect.stiffness_N_per_m, b = effect.damping_Ns_per_m;
  switch (effect.kind) {
    case Kind::kConstant:
      return effect.amplitude_N * n;
    case Kind::kSpringToPoint:
      return -k * from - b * relative;
    case Kind::kSpringToLine:
      return -k * (from - glm::dot(from, n) * n) - b * (relative - glm::dot(relative, n) * n);
    case Kind::kSpringToPlane:
      return -(k * glm::dot(from, n) + b * glm::dot(relative, n)) * n;
    case Kind::kViscosity:
      return -b * relative;
    case Kind::kMagnet: {
      const Vec3 way = nearestOfBox(effect.kind, at) - at, pullsTo = now.rotation * glm::normalize(way);
      const double pull = k * glm::length(way);
      return (pull + std::clamp(-b * glm::dot(relative, pullsTo), -pull, pull)) * pullsTo;
    }
    case Kind::kSpringToVertex:
      return now.rotation * (k * (nearestOfBox(effect.kind, at) - at)) - b * relative;
    case Kind::kSpringToEdge:
      return now.rotation * (k * (nearestOfBox(effect.kind, at) - at));
    case Kind::kInertia:
      return now.rotation * mass.follow(effect, at, glm::inverse(now.rotation) * relative);
    default:
      return Vec3(0);
  }
}

TEST(EffectForces, MoveAndTurnWithTheirBody) {
  std::mt19937 engine(7);
  std::uniform_real_distribution<double> number(-1, 1);
  const auto vector = [&] { return Vec3(number(engine), number(engine), number(engine)); };
  int moved = 0;
  for (int scenes = 0; scenes < 100; ++scenes) {
    std::vector<Effect> effects;
    for (const Kind kind :
         {Kind::kConstant, Kind::kSpringToPoint, Kind::kSpringToLine, Kind::kSpringToPlane, Kind::kViscosity,
          Kind::kMagnet, Kind::kSpringToVertex, Kind::kSpringToEdge, Kind::kInertia}) {
      Effect effect{.kind = kind, .point_m = 0.02 * vector(), .direction = glm::normalize(vector())};
      if (kind == Kind::kConstant) effect.amplitude_N = 0.1;
      if (kind != Kind::kConstant && kind != Kind::kViscosity) effect.stiffness_N_per_m = 20 + 10 * number(engine);
      if (kind != Kind::kConstant && kind != Kind::kSpringToEdge) effect.damping_Ns_per_m = 0.1;
      if (kind == Kind::kInertia) effect.mass_kg = 0.05;
      if (EffectField(effect).isOfMesh()) {  // softer: they pull the body to the hand
        effect.stiffness_N_per_m /= 20;
        effect.reach_m = 1;
      }
      effects.push_back(effect);
    }
    Vec3 hand(0.06, 0, 0);
    Vec3 towards(0);
    MassLaw mass;
    VirtualServo servo([&](std::uint64_t) { return hand; }, kWide, carrying(1, floatingBox(0.5, 20), effects));
    for (int i = 0; i < 1000; ++i) {
      towards = 0.98 * towards + 2e-5 * vector();
      const Vec3 from = servo.state().bodies[0].current.position;
      hand += towards;
      if (glm::distance(hand, from) > 0.15 || glm::distance(hand, from) < 0.03) towards = -towards;
      const TelemetrySample sample = servo.step();
      const Body& body = servo.state().bodies[0];
      Vec3 expected(0);
      for (const Effect& effect : effects)
        expected += inMovingFrame(effect, body.previous, body.current, servo.state().estimate.hip,
                                  servo.state().estimate.velocity.velocity(), mass);
      if (sample.object != 0) continue;
      moved += body.moving ? 1 : 0;
      ASSERT_LE(glm::distance(sample.force.contact, expected), 1e-9) << "scene " << scenes << " tick " << i;
    }
  }
  EXPECT_GT(moved, 90'000);
}

TEST(EffectForces, GiveTheirBodyWhatTheyTakeFromTheHand) {
  const Effect spring{
      .kind = Kind::kSpringToPoint, .point_m = Vec3(0, 0.01, 0), .stiffness_N_per_m = 50, .damping_Ns_per_m = 0.2};
  const Effect inWorld{
      .kind = Kind::kConstant, .frame = Effect::Frame::kWorld, .direction = Vec3(0, 0, 1), .amplitude_N = 1};
  for (const auto& [start_m, step_m] : {std::pair(0.05, 1e-5), std::pair(0.0101, -1e-5)}) {  // beside it, and into it
    const auto along = [&](std::uint64_t tick) { return Vec3(start_m + step_m * static_cast<double>(tick), 0, 0); };
    VirtualServo servo(along, kWide, carrying(1, floatingBox(0.2, 0), {spring, inWorld}));
    Vec3 given(0);
    for (int i = 0; i < 80; ++i) given -= kPeriod_s * (servo.step().force.contact - Vec3(0, 0, 1));
    const RigidState& body = servo.state().moving[0].state;
    EXPECT_GT(glm::length(body.momentum_Ns), 0.01);
    EXPECT_LT(glm::distance(body.momentum_Ns, given), 1e-9);
    EXPECT_LT(body.angularMomentum_Nms.z, 0) << "pulled at the hand's place, beside its centre";
  }
}

Effect randomEffect(std::mt19937& engine) {
  std::uniform_real_distribution<double> number(-1, 1);
  const auto vector = [&] { return Vec3(number(engine), number(engine), number(engine)); };
  Effect effect{.kind = static_cast<Kind>(1 + engine() % 14)};
  if (effect.kind == Kind::kVibration) effect.kind = Kind::kTube;
  effect.frame = engine() % 2 == 0 ? Effect::Frame::kObject : Effect::Frame::kWorld;
  effect.point_m = 0.03 * vector();
  if (effect.frame == Effect::Frame::kObject) effect.point_m.z += 5;
  effect.direction = glm::normalize(vector());
  effect.stiffness_N_per_m = 500 + 400 * number(engine);
  effect.damping_Ns_per_m = 1 + number(engine);
  effect.amplitude_N = 1.5 + number(engine);
  effect.limit_N = engine() % 2 == 0 ? 2 : 0;
  for (int i = 0; i < 12; ++i) effect.path_m.push_back(effect.point_m + 0.03 * vector());
  if (engine() % 2 == 0) effect.reach_m = 0.03 + 0.02 * number(engine);
  if (effect.kind == Kind::kConstant || effect.kind == Kind::kViscosity) {
    effect.region = static_cast<Effect::Region>(1 + engine() % 3);
    effect.size_m = Vec3(0.05) + 0.04 * vector();
  }
  if (effect.kind == Kind::kTube) effect.size_m = Vec3(0.02 + 0.01 * number(engine), 0, 0);
  if (effect.kind == Kind::kInertia) effect.mass_kg = 0.3 + 0.2 * number(engine);
  if (EffectField(effect).isOfMesh()) {
    effect.frame = Effect::Frame::kObject;
    effect.reach_m = 0.05;
  }
  return effect;
}

TEST(EffectForces, EditsUnderTheHandComeAtTheRateOfThoseOfSurfaces) {
  constexpr int kEdits = 20'000, kTicks = 8;
  std::mt19937 engine(11);
  VirtualServo servo([](std::uint64_t) { return Vec3(0.002, 0.001, 0.003); }, kWide, carrying(1, away(), {}));
  Vec3 before = servo.run(50).force.written;
  double largest_N = 0, reached_N = 0;
  for (int edit = 0; edit < kEdits; ++edit) {
    std::vector<Effect> effects;
    for (unsigned i = engine() % 3; i > 0; --i) effects.push_back(randomEffect(engine));
    ServoObject object = away();
    object.pose.position.x += engine() % 3 == 0 ? 0.001 : 0;
    servo.adopt(carrying(2 + static_cast<std::uint64_t>(edit), object, effects));
    for (int i = 0; i < kTicks; ++i) {
      const Vec3 now = servo.step().force.written;
      largest_N = std::max(largest_N, glm::distance(now, before));
      reached_N = std::max(reached_N, glm::length(now));
      before = now;
    }
  }
  EXPECT_LE(largest_N, kRate_N * 1.001);
  EXPECT_GT(reached_N, 0.5);
  EXPECT_LT(glm::distance(servo.run(3000).force.written, servo.step().force.contact), 1e-9) << "and does come";
}

TEST(EffectForces, ASnapTakesHoldAndLetsGoWithoutAStep) {
  const Effect snap{.kind = Kind::kSpringToPoint,
                    .frame = Effect::Frame::kWorld,
                    .stiffness_N_per_m = 300,
                    .reach_m = 0.01,
                    .release_m = 0.02};
  constexpr double kSpeed = 0.05;
  VirtualServo servo(
      [](std::uint64_t tick) { return Vec3(-0.05 + kSpeed * kPeriod_s * static_cast<double>(tick), 0, 0); }, kWide,
      carrying(1, away(), {snap}));
  Vec3 before(0);
  double largest_N = 0, pulled_N = 0;
  for (int i = 0; i < 2500; ++i) {
    const Vec3 now = servo.step().force.written;
    largest_N = std::max(largest_N, glm::distance(now, before));
    pulled_N = std::min(pulled_N, now.x);
    before = now;
  }
  EXPECT_LE(largest_N, kRate_N + 2 * 300 * kSpeed * kPeriod_s);
  EXPECT_NEAR(pulled_N, -6, 0.1) << "it holds up to 20 mm";
  EXPECT_EQ(before, Vec3(0));
}

/// Felt of nothing else, and with no step where they come and go.
TEST(EffectForces, ATriggerLetsThemInWhileItIsOn) {
  for (const Effect::Trigger trigger : {Effect::Trigger::kTouch, Effect::Trigger::kButton}) {
    std::vector<Effect> effects{
        {.kind = Kind::kConstant, .direction = Vec3(1, 0, 0), .amplitude_N = 0.5, .trigger = trigger},
        {.kind = Kind::kSpringToPoint, .point_m = Vec3(0.01, 0, 0.05), .stiffness_N_per_m = 30, .trigger = trigger},
        {.kind = Kind::kVibration,
         .direction = Vec3(0, 1, 0),
         .amplitude_N = 0.2,
         .frequency_Hz = 20,
         .trigger = trigger}};
    VirtualServo servo({}, kWide, carrying(1, slab(), effects)), bare({}, kWide, carrying(1, slab(), {}));
    Vec3 before(0);
    double height_m = 1e-4;
    for (int part = 0; part < 6; ++part) {
      const bool isOn = part % 2 == 1;
      for (int i = 0; i < 200; ++i) {
        if (trigger == Effect::Trigger::kTouch) height_m += std::clamp((isOn ? -1e-4 : 1e-4) - height_m, -2e-6, 2e-6);
        DeviceReading reading{Vec3(0.003, 0.0123, height_m), DeviceState::kReady, {}};
        reading.status.buttons = trigger == Effect::Trigger::kButton && isOn ? 4 : 0;
        const Vec3 added = servo.stepWith(reading).force.written - bare.stepWith(reading).force.written;
        ASSERT_LE(glm::distance(added, before), kRate_N * 1.001 + 0.2 * 2 * std::numbers::pi * 20 * kPeriod_s + 0.01);
        before = added;
      }
      EXPECT_NEAR(before.x, isOn ? 0.5 + 30 * 0.007 : 0, 1e-9) << part;
      EXPECT_EQ(glm::length(before) < 1e-9, !isOn) << part;
    }
  }
}

ServoObject featured(int feature) {
  SurfaceProperties properties;
  DetailFields fields;
  switch (feature) {
    case 0:
      return with(slab(), shading(1));
    case 1:
      return with(slab(), friction(0.6, 0.4));
    case 2:
      return withGrating(slab(), 0.002, 1e-4);
    case 3:
      properties.stiffnessOver = SurfaceMap{.variation = 0.5, .over = FieldFamily{FourierFamily{}}};
      fields.stiffness.field = gratingField(0.004);
      return with(slab(), properties, fields);
    case 4:
      properties.scalars.adhesion_N = 1;
      return with(slab(), properties);
    case 5: {
      properties.scalars.tap_Ns_per_m = 5;
      properties.scalars.tap_Hz = 60;
      properties.scalars.tap_decay_per_s = 70;
      return with(slab(), properties);
    }
    case 6: {
      ServoObject soft = slab();
      soft.tissue = std::make_shared<const SoftTissue>(SoftTissue{Falloff(0.02, 2), 400, 0});
      return soft;
    }
    default:
      return slab();
  }
}

/// The sum of both, to the last bits, whatever the surface is like.
TEST(EffectForces, AddToWhatIsFeltOfEverySurfaceFeature) {
  std::mt19937 engine(21);
  for (int feature = 0; feature < 8; ++feature) {
    std::vector<Effect> effects;
    for (int i = 0; i < 6; ++i) {
      effects.push_back(randomEffect(engine));
      effects.back().frame = Effect::Frame::kWorld;
    }
    const auto stroke = strokeAlongX(0.001, 0.05);
    VirtualServo both(stroke, kWide, carrying(1, featured(feature), effects));
    VirtualServo surface(stroke, kWide, carrying(1, featured(feature), {}));
    VirtualServo alone(stroke, kWide, carrying(1, away(), effects));
    double felt_N = 0;
    for (int i = 0; i < 1200; ++i) {
      const Vec3 sum = surface.step().force.contact + alone.step().force.contact;
      felt_N = std::max(felt_N, glm::length(sum));
      ASSERT_LE(glm::distance(both.step().force.contact, sum), 1e-9) << "feature " << feature << " tick " << i;
    }
    EXPECT_GT(felt_N, 0.5);
  }
}

TEST(EffectForces, AVibrationIsNotTakenForAnEdit) {
  const Effect hum{.kind = Kind::kVibration,
                   .frame = Effect::Frame::kWorld,
                   .direction = Vec3(0, 1, 0),
                   .amplitude_N = 1,
                   .frequency_Hz = 97};
  VirtualServo servo([](std::uint64_t) { return Vec3(0); }, kWide, carrying(1, away(), {hum}));
  servo.run(300);
  double highest_N = 0;
  for (int i = 0; i < 200; ++i) highest_N = std::max(highest_N, servo.step().force.written.y);
  EXPECT_NEAR(highest_N, 1, 0.01);
}

/// As stiff as they are felt at most, in nobody's hand and in a light one: from half a millimetre beside, and from five with as much
/// damping as two ticks of the stiffness.
TEST(EffectForces, ComeToRestWithinTheLimitsOfEveryPreset) {
  struct Resting final : HandIntent {
    double beside_m = 0;
    HandTarget next(double, Vec3) noexcept override { return {Vec3(beside_m, 0.0123, 0)}; }
  };
  for (const DevicePreset& preset : devicePresets()) {
    Resting hand;
    const DeviceInfo info = SimulatedDevice({preset, findHandPreset("none").value(), kPeriod_s}, hand).info();
    const SurfaceLimits limits = surfaceLimits(info, 1 / kPeriod_s, false);
    DeviceLimits bounds;
    bounds.stiffest_N_per_m = limits.stiffness_N_per_m;
    bounds.maxDamping_Ns_per_m = limits.damping_Ns_per_m;
    for (const char* name : {"none", "light"}) {
      for (const double beside_m : {0.0005, 0.005}) {
        hand.beside_m = beside_m;
        for (const Kind kind : {Kind::kSpringToPoint, Kind::kGuide, Kind::kTube}) {
          const Effect asked{.kind = kind,
                             .frame = Effect::Frame::kWorld,
                             .point_m = Vec3(0, 0.0123, 0),
                             .path_m = {Vec3(0, -1, 0), Vec3(0, 1, 0)},
                             .stiffness_N_per_m = 1e5,
                             .damping_Ns_per_m = beside_m > 0.001 ? 2 * kPeriod_s * bounds.stiffest_N_per_m : 0,
                             .size_m = Vec3(1e-4, 0, 0)};
          SimulatedDevice device({preset, findHandPreset(name).value(), kPeriod_s}, hand);
          VirtualServo servo({}, {.period_s = kPeriod_s, .maxForce_N = preset.maxForce_N},
                             carrying(1, away(), stableEffects({asked}, std::nullopt, bounds)));
          double least = 1, most = -1;
          for (std::uint64_t tick = 0; tick < 2500; ++tick) {
            const Vec3 at = device.read(tick).position;
            device.write(servo.stepAt(at, DeviceState::kReady).force.written);
            if (tick < 1500) continue;
            least = std::min(least, at.x);
            most = std::max(most, at.x);
          }
          EXPECT_LE(most - least, std::max(2 * preset.resolution_m, 20e-6) * 1.001)
              << preset.name << ' ' << name << " kind " << static_cast<int>(kind) << " from " << beside_m;
        }
      }
    }
  }
}

TEST(EffectForces, TheirEnergyIsCountedForTheObjectThatCarriesThem) {
  const Effect push{
      .kind = Kind::kConstant, .frame = Effect::Frame::kWorld, .direction = Vec3(1, 0, 0), .amplitude_N = 2};
  ServoObject carrier = away();
  carrier.id = 9;
  VirtualServo servo([](std::uint64_t tick) { return Vec3(1e-5 * static_cast<double>(tick), 0, 0); }, kWide,
                     carrying(1, carrier, {push}));
  const double before_J = servo.run(500).energyGiven_J[0];
  const double after_J = servo.run(1000).energyGiven_J[0];
  EXPECT_NEAR(after_J - before_J, 2 * 0.01, 1e-6);
  EnergyState energy;
  servo.state().energy.copyTo(energy);
  ASSERT_GE(energy.objectCount, 1U);
  EXPECT_EQ(energy.object[0].object, 9U);
  EXPECT_NEAR(energy.object[0].given_J[0], after_J, 1e-9);
}

TEST(EffectForces, ACopyGoesOnAlikeAndAnImageToo) {
  std::mt19937 engine(3);
  std::vector<Effect> effects;
  for (int i = 0; i < 12; ++i) effects.push_back(randomEffect(engine));
  effects.push_back({.kind = Kind::kVibration, .direction = Vec3(0, 0, 1), .amplitude_N = 0.5, .frequency_Hz = 33});
  const auto hand = [](std::uint64_t tick) {
    const double t = 1e-3 * static_cast<double>(tick);
    return 0.03 * Vec3(std::sin(7 * t), std::sin(11 * t), std::cos(5 * t));
  };
  VirtualServo servo(hand, kWide, carrying(1, away(), effects));
  servo.run(700);
  VirtualServo copy = servo;
  for (int i = 0; i < 700; ++i) ASSERT_EQ(servo.step().force.written, copy.step().force.written);
  EXPECT_EQ(stateImage(servo.state()), stateImage(copy.state()));
  HapticState taken(kWide);
  static_cast<StateFields&>(taken) = servo.state();
  EXPECT_TRUE(taken.connect(*servo.state().scene));
  for (EffectMemory& memory : taken.effects.all()) memory.segment = 1000;
  EXPECT_FALSE(taken.connect(*servo.state().scene)) << "no path has so many segments";
}

TEST(EffectForces, AnObjectThatLeavesTakesItsEffectsAlong) {
  const Effect push{.kind = Kind::kConstant, .direction = Vec3(1, 0, 0), .amplitude_N = 1};
  VirtualServo servo([](std::uint64_t) { return Vec3(0); }, kWide, carrying(1, away(), {push}));
  Vec3 before = servo.run(300).force.written;
  EXPECT_NEAR(before.x, 1, 1e-9);
  servo.adopt(sceneOf(2, {}));
  EXPECT_EQ(servo.state().effects.count, 0U);
  for (int i = 0; i < 300; ++i) {
    const Vec3 now = servo.step().force.written;
    ASSERT_LE(glm::distance(now, before), kRate_N * 1.001);
    before = now;
  }
  EXPECT_EQ(before, Vec3(0));
}

}  // namespace
}  // namespace haptics::fixture::effect_forces_tests
