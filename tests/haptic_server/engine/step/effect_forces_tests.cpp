// Effects in the step: frames that move, what bodies are given, edits under the hand, energy, copies.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "common/mesh/generators.h"
#include "haptic_server/device/simulated_device.h"
#include "haptic_server/engine/motion/solid.h"
#include "haptic_server/engine/motion/support_points.h"
#include "haptic_server/recording/state_image.h"
#include "haptic_server/scene/effect_limits.h"
#include "haptic_server/servo/server_step_config.h"
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

/// What a judge remembers of an effect.
struct LawMemory {
  bool isHeld = false;
  Vec3 at{0}, velocity{0};  ///< Of a mass, in the body's frame.
  double along = 0;         ///< Of a guide: its segment and part.
  int ticks = 0;
};

/// By m du/dt = -F, F = k (y - x) + b (u - v) at the tick's end, solved for F; all in the body's frame.
Vec3 massLaw(const Effect& effect, LawMemory& mass, Vec3 hip, Vec3 v) {
  if (!mass.isHeld) mass.at = hip;
  mass.isHeld = true;
  const double k = effect.stiffness_N_per_m, b = effect.damping_Ns_per_m, m = effect.mass_kg, T = kPeriod_s;
  const Vec3 force = (k * (mass.at + T * mass.velocity - hip) + b * (mass.velocity - v)) * m / (m + T * (b + T * k));
  mass.velocity -= T / m * force;
  mass.at += T * mass.velocity;
  return force;
}

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

struct OnPath {
  Vec3 point{1e9};
  Vec3 tangent{0};
  double along = 0;
};

/// By every segment from a place on.
OnPath nearestOfPath(const std::vector<Vec3>& path, Vec3 x, double from) {
  const auto tangentAt = [&](std::size_t i) {
    Vec3 sum(0);
    if (i > 0) sum += glm::normalize(path[i] - path[i - 1]);
    if (i + 1 < path.size()) sum += glm::normalize(path[i + 1] - path[i]);
    return glm::normalize(sum);
  };
  OnPath best;
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    const Vec3 way = path[i + 1] - path[i];
    const auto first = static_cast<double>(i), least = std::max(0.0, from - first);
    if (least > 1) continue;
    const double part = std::clamp(glm::dot(x - path[i], way) / glm::dot(way, way), least, 1.0);
    const Vec3 point = path[i] + part * way;
    if (!(glm::distance(point, x) < glm::distance(best.point, x))) continue;
    best = {point, glm::normalize((1 - part) * tangentAt(i) + part * tangentAt(i + 1)), first + part};
  }
  return best;
}

Vec3 shortened(Vec3 force, double limit_N) {
  return limit_N > 0 && glm::length(force) > limit_N ? glm::normalize(force) * limit_N : force;
}

/// 3 t^2 - 2 t^3 on the way inside.
double weightAt(double inside_m, double fade_m) {
  if (inside_m <= 0) return 0;
  if (inside_m >= fade_m) return 1;
  return (3 - 2 * inside_m / fade_m) * std::pow(inside_m / fade_m, 2);
}

/// Of what pulls from so far away.
double heldWeight(const Effect& effect, LawMemory& memory, double far_m) {
  if (effect.reach_m == 0) {
    memory.isHeld = true;
    return 1;
  }
  const double release_m = std::max(effect.reach_m, effect.release_m);
  memory.isHeld = far_m < (memory.isHeld ? release_m : effect.reach_m);
  return memory.isHeld ? weightAt(release_m - far_m, effect.fade_m) : 0;
}

/// By the poses of this tick and the last, in the world: the field's points and directions are taken there.
Vec3 inMovingFrame(const Effect& effect, const Pose& before, const Pose& now, Vec3 hip, Vec3 v, LawMemory& memory) {
  const auto toWorld = [&](Vec3 x) { return now.position + now.rotation * x; };
  const Vec3 point = toWorld(effect.point_m), n = now.rotation * effect.direction;
  const Vec3 at = glm::inverse(now.rotation) * (hip - now.position);
  const Vec3 relative = v - (hip - (before.position + before.rotation * at)) / kPeriod_s;
  const Vec3 from = hip - point;
  const double k = effect.stiffness_N_per_m, b = effect.damping_Ns_per_m;
  const auto spring = [&](Vec3 way, Vec3 damped) {
    return heldWeight(effect, memory, glm::length(way)) * shortened(k * way - b * damped, effect.limit_N);
  };
  const auto wall = [&](double depth, Vec3 outward) {
    if (depth <= 0) return Vec3(0);
    return shortened((k * depth + std::clamp(-b * glm::dot(relative, outward), -k * depth, k * depth)) * outward,
                     effect.limit_N);
  };
  const auto region = [&] {
    if (effect.region == Effect::Region::kSphere)
      return weightAt(effect.size_m.x / 2 - glm::length(from), effect.fade_m);
    if (effect.region == Effect::Region::kEverywhere) return 1.0;
    double inside_m = 1;
    for (int axis = 0; axis < 3; ++axis) {
      Vec3 along(0);
      along[axis] = 1;
      inside_m = std::min(inside_m, effect.size_m[axis] / 2 - std::abs(glm::dot(from, now.rotation * along)));
    }
    return weightAt(inside_m, effect.fade_m);
  };
  const double tick = memory.ticks++;
  switch (effect.kind) {
    case Kind::kConstant:
      return region() * effect.amplitude_N * n;
    case Kind::kSpringToPoint:
      return spring(-from, relative);
    case Kind::kSpringToLine:
      return spring(glm::dot(from, n) * n - from, relative - glm::dot(relative, n) * n);
    case Kind::kSpringToPlane:
      return spring(-glm::dot(from, n) * n, glm::dot(relative, n) * n);
    case Kind::kForbiddenSide:
      return wall(-glm::dot(from, n), n);
    case Kind::kSpringToPath:
    case Kind::kGuide:
    case Kind::kTube: {
      std::vector<Vec3> path;
      for (const Vec3& x : effect.path_m) path.push_back(toWorld(x));
      const OnPath on = nearestOfPath(path, hip, memory.isHeld ? memory.along : 0);
      if (effect.kind == Kind::kGuide) memory.along = on.along;
      const Vec3 way = on.point - hip;
      if (effect.kind == Kind::kTube) return wall(glm::length(way) - effect.size_m.x / 2, glm::normalize(way));
      return spring(way, relative - glm::dot(relative, on.tangent) * on.tangent);
    }
    case Kind::kViscosity:
      return region() * shortened(-b * relative, effect.limit_N);
    case Kind::kVibration:
      return region() * effect.amplitude_N * n *
             std::sin(2 * std::numbers::pi * effect.frequency_Hz * kPeriod_s * tick + effect.phase_rad);
    case Kind::kSamples: {  // one in two ticks
      const auto i = static_cast<std::size_t>(tick / 2) % effect.samples.size();
      const double first = static_cast<double>(effect.samples[i]);
      const double second = static_cast<double>(effect.samples[(i + 1) % effect.samples.size()]);
      return region() * effect.amplitude_N * n * (first + (second - first) * std::fmod(tick / 2, 1.0));
    }
    case Kind::kMagnet: {
      const Vec3 way = nearestOfBox(effect.kind, at) - at;
      return heldWeight(effect, memory, glm::length(way)) * wall(glm::length(way), now.rotation * glm::normalize(way));
    }
    case Kind::kSpringToVertex:
      return spring(now.rotation * (nearestOfBox(effect.kind, at) - at), relative);
    case Kind::kSpringToEdge:
      return spring(now.rotation * (nearestOfBox(effect.kind, at) - at), Vec3(0));
    case Kind::kInertia:
      return now.rotation * massLaw(effect, memory, at, glm::inverse(now.rotation) * relative);
    case Kind::kRecordedTexture:
      break;  // by its spectrum: recorded_texture_test.cpp
  }
  return Vec3(0);
}

/// Of a kind, with whatever of its options: gentle enough for a body of half a kilogram.
Effect drawn(Kind kind, const std::function<double(double, double)>& number) {
  const auto vector = [&](double size) { return Vec3(number(-size, size), number(-size, size), number(-size, size)); };
  const auto chance = [&] { return number(0, 1) < 0.5; };
  Effect effect{.kind = kind, .point_m = vector(0.02), .direction = glm::normalize(vector(1))};
  const bool isForce = kind == Kind::kConstant || kind == Kind::kVibration || kind == Kind::kSamples;
  const bool isInRegion = isForce || kind == Kind::kViscosity;
  if (isForce) effect.amplitude_N = 0.02;  // less than its budget lasts for
  if (!isInRegion) effect.stiffness_N_per_m = number(1, 3);
  if (!isForce && kind != Kind::kSpringToEdge) effect.damping_Ns_per_m = number(0, 0.1);
  if (!isForce && kind != Kind::kInertia && chance()) effect.limit_N = number(0.01, 0.1);
  if (isInRegion && chance()) {
    effect.region = static_cast<Effect::Region>(2 + (chance() ? 1 : 0));
    effect.size_m = Vec3(number(0.1, 0.3), number(0.1, 0.3), number(0.1, 0.3));
    effect.fade_m = chance() ? number(0.001, 0.05) : 0;
  }
  if (kind == Kind::kVibration) effect.frequency_Hz = number(1, 300);
  if (kind == Kind::kVibration) effect.phase_rad = number(-3, 3);
  if (kind == Kind::kSamples) effect.sample_rate_Hz = 500;
  for (int i = 0; kind == Kind::kSamples && i < 77; ++i) effect.samples.push_back(static_cast<float>(number(-1, 1)));
  if (kind == Kind::kInertia) effect.mass_kg = 0.05;
  if (kind == Kind::kTube) effect.size_m.x = number(0.01, 0.1);
  const bool isOnPath = kind == Kind::kSpringToPath || kind == Kind::kTube || kind == Kind::kGuide;
  const bool bends =
      isOnPath && kind != Kind::kGuide;  // of a guide, the nearest place from here on is on the segments ahead
  for (int i = 0; isOnPath && i < 8; ++i)
    effect.path_m.push_back(bends ? vector(0.06) : Vec3(0.02 * i - 0.08, 0.002 * std::sin(1.0 * i), 0.05));
  const bool isOfMesh = kind == Kind::kMagnet || kind == Kind::kSpringToVertex || kind == Kind::kSpringToEdge;
  const bool reaches = !isInRegion && kind != Kind::kInertia && kind != Kind::kTube && kind != Kind::kForbiddenSide;
  if (reaches && (isOfMesh || chance())) {
    effect.reach_m = number(0.05, 0.15);
    if (chance()) effect.release_m = effect.reach_m * number(1, 2);
    if (chance()) effect.fade_m = effect.reach_m * number(0.01, 1);
  }
  return effect;
}

/// Each kind by itself, as the servo computes it: 10^5 states of each.
TEST(EffectForces, FollowTheirClosedFormsInAFrameThatMovesAndTurns) {
  std::mt19937 engine(7);
  const auto number = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine);
  };
  const auto vector = [&] { return Vec3(number(-1, 1), number(-1, 1), number(-1, 1)); };
  std::array<int, 16> felt{};  // by kind, the first is 1
  int moved = 0;
  double worst_N = 0;
  for (int scenes = 0; scenes < 110; ++scenes) {
    std::vector<Effect> effects;
    for (int kind = 1; kind < static_cast<int>(Kind::kRecordedTexture); ++kind)
      effects.push_back(drawn(static_cast<Kind>(kind), number));
    Vec3 hand(0.06, 0, 0), towards(0);
    std::vector<LawMemory> memory(effects.size());
    VirtualServo servo([&](std::uint64_t) { return hand; }, kWide, carrying(1, floatingBox(0.5, 20), effects));
    for (int i = 0; i < 1000; ++i) {
      towards = 0.98 * towards + 2e-5 * vector();
      const Vec3 way = hand + towards - servo.state().bodies[0].current.position;
      if (glm::length(way) > 0.15 || glm::length(way) < 0.03) towards = -towards;
      hand += towards;
      static_cast<void>(servo.step());
      const Body& body = servo.state().bodies[0];
      moved += body.moving ? 1 : 0;
      for (std::size_t k = 0; k < effects.size(); ++k) {
        const Vec3 expected = inMovingFrame(effects[k], body.previous, body.current, servo.state().estimate.hip,
                                            servo.state().estimate.velocity.velocity(), memory[k]);
        const Vec3 is = servo.state().effects[k].force_N;
        if (is != Vec3(0)) ++felt[static_cast<std::size_t>(effects[k].kind) - 1];
        worst_N = std::max(worst_N, glm::distance(is, expected));
        ASSERT_LE(glm::distance(is, expected), 1e-9)
            << "kind " << static_cast<int>(effects[k].kind) << " scene " << scenes << " tick " << i;
      }
    }
  }
  RecordProperty("worst_nN", std::to_string(1e9 * worst_N));
  EXPECT_GT(moved, 100'000);
  for (std::size_t kind = 0; kind < 15; ++kind) EXPECT_GT(felt[kind], 20'000) << "kind " << kind + 1;
}

/// Of the forces that are written, round random loops in a second each: nothing by the means of both ends of each way, and as they are
/// held over a tick no more than the spring's own K |dx|^2 / 2, which any sampled spring gives.
TEST(EffectForces, ConservativeOnesGiveNothingRoundALoopButWhatHoldingGives) {
  constexpr int kLoops = 10'000, kLoopsOfEach = 100, kTicks = 1000;
  std::mt19937 engine(41);
  std::uniform_real_distribution<double> number(-1, 1);
  const auto vector = [&] { return Vec3(number(engine), number(engine), number(engine)); };
  constexpr std::array kKinds{Kind::kSpringToPoint, Kind::kSpringToLine, Kind::kSpringToPlane, Kind::kForbiddenSide};
  Vec3 hand(0);
  double worst_J = 0;
  for (int i = 0; i < kLoops / kLoopsOfEach; ++i) {
    Effect effect{.kind = kKinds[static_cast<std::size_t>(i) % kKinds.size()]};
    if (i % 2 == 0) effect.frame = Effect::Frame::kWorld;
    effect.direction = glm::normalize(vector());
    effect.point_m = 0.005 * vector() + (i % 2 == 0 ? Vec3(0) : Vec3(0, 0, 5));
    effect.stiffness_N_per_m = 160 + 150 * number(engine);
    VirtualServo servo([&](std::uint64_t) { return hand; }, kWide, carrying(1, away(), {effect}));
    static_cast<void>(servo.run(1000));
    for (int loop = 0; loop < kLoopsOfEach; ++loop) {
      std::array<Vec3, 5> parts;
      for (Vec3& part : parts) part = 0.005 * vector();
      double mean_J = 0, held_J = 0, holding_J = 0;
      Vec3 force(0);
      for (int tick = 0; tick <= kTicks; ++tick) {
        const double turn = 2 * std::numbers::pi * tick / kTicks;
        const Vec3 to = parts[0] + parts[1] * std::cos(turn) + parts[2] * std::sin(turn) +
                        parts[3] * std::cos(2 * turn) + parts[4] * std::sin(2 * turn);
        const Vec3 way = to - hand, before = force;
        hand = to;
        force = servo.step().force.written;
        if (tick == 0) continue;
        mean_J += glm::dot((before + force) / 2.0, way);
        held_J += glm::dot(before, way);
        holding_J += effect.stiffness_N_per_m * glm::dot(way, way) / 2;
      }
      worst_J = std::max(worst_J, std::abs(mean_J));
      ASSERT_LE(std::abs(mean_J), 10e-6) << "kind " << static_cast<int>(effect.kind) << " loop " << loop;
      ASSERT_LE(held_J, holding_J + 10e-6) << "kind " << static_cast<int>(effect.kind) << " loop " << loop;
    }
  }
  RecordProperty("worst_uJ", std::to_string(1e6 * worst_J));
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
    for (int i = 0; i < 80; ++i) given -= kPeriod_s * servo.step().force.written;
    given.z = 0;
    const RigidState& body = servo.state().moving[0].state;
    EXPECT_GT(glm::length(body.momentum_Ns), 0.005);
    EXPECT_LT(glm::distance(body.momentum_Ns, given), 1e-9);
    EXPECT_LT(body.angularMomentum_Nms.z, 0) << "pulled at the hand's place, beside its centre";
  }
}

/// What is slewed as it takes hold and lets go, and what passes the device's limit, reaches neither hand nor body.
TEST(EffectForces, GiveTheirBodyNoMoreThanTheHandFeels) {
  StepConfig weak = kWide;
  weak.maxForce_N = 1.5;
  weak.rise_s = 0.1;
  const Effect snap{.kind = Kind::kSpringToPoint, .stiffness_N_per_m = 100, .reach_m = 0.03, .release_m = 0.04};
  const Effect aside{.kind = Kind::kConstant, .direction = Vec3(0, 1, 0), .amplitude_N = 1};
  const Effect inWorld{
      .kind = Kind::kConstant, .frame = Effect::Frame::kWorld, .direction = Vec3(0, 0, 1), .amplitude_N = 1};
  for (const bool isPulledByTheWorld : {false, true}) {
    std::vector<Effect> effects{snap, aside};
    if (isPulledByTheWorld) effects.push_back(inWorld);
    const ServoObject box = floatingBox(5000, 0);  // it stays where it is
    const auto there = [](std::uint64_t tick) {
      return Vec3(0.03 + 0.015 * std::sin(3e-3 * static_cast<double>(tick)), 0, 0);
    };
    DeviceReading reading;
    VirtualServo servo({}, weak, carrying(1, box, effects));
    Vec3 given(0);
    int held = 0, limited = 0;
    for (int i = 0; i < 4000; ++i) {
      if (i == 1000 || i == 1700) {
        effects[1].amplitude_N = i == 1000 ? 0.1 : 0.7;
        servo.adopt(carrying(static_cast<std::uint64_t>(i), box, effects));
      }
      reading.position = there(servo.tick());
      reading.state = DeviceState::kReady;
      reading.status.set(HandAction::kClutch, i > 2600 && i < 2900);
      const TelemetrySample sample = servo.stepWith(reading);
      ASSERT_EQ(sample.object, 0U);
      given -= kPeriod_s * sample.force.written;
      held += servo.state().effects[0].holds ? 1 : 0;
      limited += glm::length(sample.force.written) > 1.4999 ? 1 : 0;
      const Vec3 has = servo.state().moving[0].state.momentum_Ns;
      ASSERT_LT(glm::length(has), 10);
      if (isPulledByTheWorld) {
        ASSERT_NEAR(has.x, given.x, 1e-9) << i;
        ASSERT_NEAR(has.y, given.y, 1e-9) << i;
        ASSERT_NEAR(has.z, 0, 1e-12) << i;
      } else {
        ASSERT_LT(glm::distance(has, given), 1e-9) << i;
      }
    }
    EXPECT_GT(held, 500);
    EXPECT_LT(held, 3500);
    EXPECT_GT(limited, 100);
  }
}

/// What an edit takes away, or takes out of the body's frame, the body is given as long as the hand feels it.
TEST(EffectForces, WhatAnEditTakesAwayFadesFromHandAndBodyAlike) {
  const Effect spring{.kind = Kind::kSpringToPoint, .stiffness_N_per_m = 20};
  const Effect push{.kind = Kind::kConstant, .direction = Vec3(0, 1, 0), .amplitude_N = 0.8};
  Effect inWorld = push;
  inWorld.frame = Effect::Frame::kWorld;
  const std::vector<std::vector<Effect>> edits{{spring, push}, {spring}, {}, {spring, push}, {}, {push, spring}};
  for (const bool isQuick : {false, true}) {       // what has not faded yet goes on
    const ServoObject box = floatingBox(5000, 0);  // it stays where it is
    VirtualServo servo(
        [](std::uint64_t tick) { return Vec3(0.04 + 0.005 * std::sin(3e-3 * static_cast<double>(tick)), 0, 0); }, kWide,
        carrying(1, box, {spring, push}));
    Vec3 before = servo.run(100).force.written, given = -servo.state().moving[0].state.momentum_Ns;
    std::uint64_t revision = 1;
    for (const std::vector<Effect>& effects : edits) {
      servo.adopt(carrying(++revision, box, effects));
      for (int i = 0; i < (isQuick ? 13 : 300); ++i) {
        const TelemetrySample sample = servo.step();
        ASSERT_EQ(sample.object, 0U);
        given += kPeriod_s * sample.force.written;
        ASSERT_LE(glm::distance(sample.force.written, before), kRate_N * 1.001 + 20 * 2 * 1.5e-5)
            << revision << ' ' << i;
        ASSERT_LT(glm::distance(servo.state().moving[0].state.momentum_Ns, -given), 1e-12) << revision << ' ' << i;
        before = sample.force.written;
      }
      if (effects.empty() && !isQuick) {
        EXPECT_EQ(before, Vec3(0));
      }
    }
    // Into the world's frame: the hand feels nearly the same, and the body soon nothing any more.
    servo.adopt(carrying(++revision, box, {push}));
    before = servo.run(400).force.written;
    const double pushed_Ns = servo.state().moving[0].state.momentum_Ns.y;
    servo.adopt(carrying(++revision, box, {inWorld}));
    for (int i = 0; i < 100; ++i) {
      const Vec3 now = servo.step().force.written;
      ASSERT_LE(glm::distance(now, before), kRate_N * 1.001);
      before = now;
    }
    EXPECT_NEAR(servo.state().moving[0].state.momentum_Ns.y, pushed_Ns, 0.01) << "0.8 N would have given 0.08 N s";
  }
}

Effect randomEffect(std::mt19937& engine) {
  std::uniform_real_distribution<double> number(-1, 1);
  const auto vector = [&] { return Vec3(number(engine), number(engine), number(engine)); };
  Effect effect{.kind = static_cast<Kind>(1 + engine() % 15)};
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
  if (effect.kind == Kind::kVibration) effect.frequency_Hz = 10 + 9 * number(engine);
  if (effect.kind == Kind::kSamples) {
    effect.sample_rate_Hz = 10 + 9 * number(engine);
    for (int i = 0; i < 20; ++i) effect.samples.push_back(static_cast<float>(number(engine)));
  }
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
  double beyond_N = 0, reached_N = 0;
  for (int edit = 0; edit < kEdits; ++edit) {
    std::vector<Effect> effects;
    for (unsigned i = engine() % 3; i > 0; --i) effects.push_back(randomEffect(engine));
    double byTime_N = 0;  // what vibrations and samples change by themselves in a tick
    for (const Effect& effect : effects) {
      const double turns = effect.frequency_Hz * kPeriod_s, passed = effect.sample_rate_Hz * kPeriod_s;
      byTime_N += effect.amplitude_N * (2 * std::numbers::pi * turns + 2 * passed);
    }
    ServoObject object = away();
    object.pose.position.x += engine() % 3 == 0 ? 0.001 : 0;
    servo.adopt(carrying(2 + static_cast<std::uint64_t>(edit), object, effects));
    for (int i = 0; i < kTicks; ++i) {
      const Vec3 now = servo.step().force.written;
      beyond_N = std::max(beyond_N, glm::distance(now, before) - (i == 0 ? 0 : byTime_N));
      reached_N = std::max(reached_N, glm::length(now));
      before = now;
    }
  }
  RecordProperty("most_N_per_s", std::to_string(beyond_N / kPeriod_s));
  EXPECT_LE(beyond_N, kRate_N * 1.001);
  EXPECT_GT(reached_N, 0.5);
  servo.adopt(carrying(kEdits + 2, away(), {{.kind = Kind::kConstant, .direction = Vec3(1, 0, 0), .amplitude_N = 1}}));
  EXPECT_LT(glm::distance(servo.run(3000).force.written, servo.step().force.contact), 1e-9) << "and does come";
}

/// It gets heavier while it moves, and is braked so; its spring gets stiffer while it is stretched.
TEST(EffectForces, AMassThatIsEditedGivesNoMoreThanItWasGiven) {
  const Effect light{.kind = Kind::kInertia,
                     .frame = Effect::Frame::kWorld,
                     .stiffness_N_per_m = 50,
                     .damping_Ns_per_m = 0.5,
                     .mass_kg = 0.1};
  Effect heavy = light, stiff = light;
  heavy.mass_kg = 2;
  stiff.stiffness_N_per_m = 1000;
  for (const Effect& edited : {heavy, stiff}) {
    Vec3 hand(0);
    VirtualServo servo([&](std::uint64_t) { return hand; }, kWide, carrying(1, away(), {light}));
    double given_J = 0, speed_m_per_s = 0;
    for (int i = 0; i < 1000; ++i) {
      const Vec3 way(kPeriod_s * speed_m_per_s, 0, 0);
      given_J += glm::dot(servo.state().effects[0].force_N, way);
      ASSERT_LE(given_J, 0) << i;
      hand += way;
      speed_m_per_s += i < 500 ? 4e-4 : -4e-4;
      static_cast<void>(servo.step());
      if (i == 499) servo.adopt(carrying(2, away(), {edited}));
    }
    EXPECT_LT(given_J, 0);
  }
}

/// What the mass remembers of its place is of the frame that it was carried in.
TEST(EffectForces, AMassWhoseFrameIsEditedStaysAtTheHand) {
  Effect inertia{.kind = Kind::kInertia, .frame = Effect::Frame::kObject, .stiffness_N_per_m = 500, .mass_kg = 0.2};
  VirtualServo servo([](std::uint64_t) { return Vec3(0.002, 0.001, 0.003); }, kWide, carrying(1, away(), {inertia}));
  servo.run(50);
  inertia.frame = Effect::Frame::kWorld;
  servo.adopt(carrying(2, away(), {inertia}));
  for (int i = 0; i < 500; ++i) ASSERT_LT(glm::length(servo.step().force.written), kRate_N) << i;
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

/// What a pressed button is bound to takes its place.
TEST(EffectForces, AButtonThatIsBoundTriggersNothing) {
  const Effect push{
      .kind = Kind::kConstant, .direction = Vec3(1, 0, 0), .amplitude_N = 0.5, .trigger = Effect::Trigger::kButton};
  VirtualServo servo({}, kWide, carrying(1, away(), {push}));
  const auto felt_N = [&](std::uint32_t buttons, std::initializer_list<HandAction> actions) {
    DeviceReading reading{Vec3(0), DeviceState::kReady, {}};
    reading.status.buttons = buttons;
    for (const HandAction action : actions) reading.status.set(action, true);
    TelemetrySample sample;
    for (int i = 0; i < 100; ++i) sample = servo.stepWith(reading);
    return sample.force.written.x;
  };
  EXPECT_EQ(felt_N(0b10, {}), 0.5);
  EXPECT_EQ(felt_N(0b01, {HandAction::kMark, HandAction::kNoOther}), 0) << "the one for marks";
  EXPECT_EQ(felt_N(0b11, {HandAction::kMark}), 0.5);
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

/// White noise of a model, felt as strongly as asked for from the lowest speed on.
Effect texture(double amplitude_N, double lowest_m_per_s = 1e-3) {
  Effect effect{.kind = Kind::kRecordedTexture, .amplitude_N = amplitude_N, .sample_rate_Hz = 1000};
  effect.speeds_m_per_s = {lowest_m_per_s, 0.2};
  effect.forces_N = {0.1, 2};
  effect.models = {1, 0, 0.5, 0.3, 1, -0.2, 0.8, -0.5};
  return effect;
}

/// An effect of each kind that holds or drags, which has its rest at x = 0, y = 0.0123, z = 0, and what else has to be there.
struct Held {
  const char* name;
  Effect effect;
  ServoObject object = away();
  bool drags = false;  ///< It has no rest of its own.
  int pairs = 0;       ///< So many like it pull from each side, at its own place where `apart_m` is 0.
  double apart_m = 0;
};

std::vector<Held> eachKind() {
  const Vec3 rest(0, 0.0123, 0), x(1, 0, 0);
  const std::vector<Vec3> path{Vec3(0, -1, 0), Vec3(0, 1, 0)};
  const auto world = Effect::Frame::kWorld;
  Effect tube{.kind = Kind::kTube, .frame = world, .path_m = path, .size_m = Vec3(1e-4, 0, 0)};
  // Of a block whose upper side is at x = 0, whose corner is the rest, and whose edge goes through it.
  const auto block = [](Vec3 centre, double stiffness_N_per_m = 100) {
    static const auto surface = surfaceOf(makeBox(Vec3(0.1), 8).value());
    ServoObject object = objectOf(1, surface, centre, stiffness_N_per_m);
    object.damping_Ns_per_m = 0;
    return object;
  };
  const auto ofMesh = [](Kind kind) { return Effect{.kind = kind, .reach_m = 0.02}; };
  return {
      {"point", {.kind = Kind::kSpringToPoint, .frame = world, .point_m = rest}},
      {"eight points", {.kind = Kind::kSpringToPoint, .frame = world, .point_m = rest}, away(), false, 4, 0.005},
      {"eight snaps",
       {.kind = Kind::kSpringToPoint, .frame = world, .point_m = rest, .reach_m = 0.03},
       away(),
       false,
       4,
       0.005},
      {"two points on a surface",
       {.kind = Kind::kSpringToPoint, .frame = world, .point_m = rest},
       block(Vec3(-0.035, 0, 0), 1e9),
       false,
       1,
       0.005},
      {"line", {.kind = Kind::kSpringToLine, .frame = world, .point_m = rest, .direction = Vec3(0, 1, 0)}},
      {"plane", {.kind = Kind::kSpringToPlane, .frame = world, .point_m = rest, .direction = x}},
      {"path", {.kind = Kind::kSpringToPath, .frame = world, .path_m = path}},
      {"guide", {.kind = Kind::kGuide, .frame = world, .path_m = path}},
      {"tube", tube},
      {"magnet", ofMesh(Kind::kMagnet), block(Vec3(-0.05, 0, 0))},
      {"eight magnets", ofMesh(Kind::kMagnet), block(Vec3(-0.05, 0, 0)), false, 4},
      {"vertex", ofMesh(Kind::kSpringToVertex), block(rest - Vec3(0.05))},
      {"edge", ofMesh(Kind::kSpringToEdge), block(Vec3(-0.05, 0, -0.05))},
      {"forbidden side", {.kind = Kind::kForbiddenSide, .frame = world, .direction = x}},
      {"eight forbidden sides", {.kind = Kind::kForbiddenSide, .frame = world, .direction = x}, away(), false, 4},
      {"viscosity", {.kind = Kind::kViscosity, .frame = world}, away(), true},
      {"eight viscous balls",
       {.kind = Kind::kViscosity, .frame = world, .region = Effect::Region::kSphere, .size_m = Vec3(0.2, 0, 0)},
       away(),
       true,
       4},
      {"light inertia", {.kind = Kind::kInertia, .frame = world, .mass_kg = 1e-3}, away(), true},
      {"heavy inertia", {.kind = Kind::kInertia, .frame = world, .mass_kg = 1}, away(), true},
  };
}

struct Resting final : HandIntent {
  double beside_m = 0;
  HandTarget next(double, Vec3) noexcept override { return {Vec3(beside_m, 0.0123, 0)}; }
};

/// The server's step on a device, and what it lets through at most.
struct Bounded {
  StepConfig config;
  DeviceLimits bounds;

  Bounded(const DevicePreset& preset, bool observed) {
    Resting hand;
    const DeviceInfo info = SimulatedDevice({preset, findHandPreset("none").value(), kPeriod_s}, hand).info();
    const SurfaceLimits limits = surfaceLimits(info, 1 / kPeriod_s, observed);
    config = serverStepConfig(info, 1 / kPeriod_s, observed);
    bounds.stiffest_N_per_m = limits.stiffness_N_per_m;
    bounds.maxDamping_Ns_per_m = limits.damping_Ns_per_m;
    bounds.observed = observed;
  }
};

/// As the server lets through of what an object asks for.
std::vector<Effect> felt(std::vector<Effect> effects, const DeviceLimits& bounds) {
  ObjectRecord record;
  record.effects = std::move(effects);
  EffectZones zones;
  zones.add(record);
  return stableEffects(record, zones, std::nullopt, bounds);
}

/// How far the device goes yet along x in the last of so many seconds, m.
double unrest_m(const DevicePreset& preset, const char* handName, HandIntent& hand, const StepConfig& config,
                std::unique_ptr<ServoScene> scene, std::uint64_t seconds = 4) {
  SimulatedDevice device({preset, findHandPreset(handName).value(), kPeriod_s}, hand);
  VirtualServo servo({}, config, std::move(scene));
  double least = 1, most = -1;
  for (std::uint64_t tick = 0; tick < 1000 * seconds; ++tick) {
    const Vec3 at = device.read(tick).position;
    device.write(servo.stepAt(at, DeviceState::kReady).force.written);
    if (tick < 1000 * (seconds - 1)) continue;
    least = std::min(least, at.x);
    most = std::max(most, at.x);
  }
  return most - least;
}

/// As stiff and as damped as they are felt at most, from 15 mm beside; what has no rest of its own, with a soft and damped spring, on which
/// a kilogram takes some 6 s:
/// asked for without damping, with so much that all of the stiffness is felt, and with as much as there is.
TEST(EffectForces, ComeToRestWithinTheLimitsOfEveryPreset) {
  double most = 0;  // of two encoder steps, or 20 um where that is more
  int runs = 0;
  for (const DevicePreset& preset : devicePresets()) {
    for (const bool observed : {false, true}) {
      const auto [config, bounds] = Bounded(preset, observed);
      for (const double dampedTicks : {0.0, 1.0, 1e6}) {
        for (const Held& held : eachKind()) {
          Resting hand;
          hand.beside_m = 0.015;
          Effect asked = held.effect;
          if (asked.kind != Kind::kViscosity) asked.stiffness_N_per_m = 1e5;
          asked.damping_Ns_per_m = dampedTicks * kPeriod_s * bounds.stiffest_N_per_m;
          if (asked.kind == Kind::kForbiddenSide) asked.point_m.x = hand.beside_m + 0.0005;
          std::vector<Effect> effects{asked};
          if (held.pairs > 0) effects.assign(2 * static_cast<std::size_t>(held.pairs), asked);
          for (std::size_t i = 0; i < effects.size(); ++i) effects[i].point_m.x += (i % 2 == 0 ? -1 : 1) * held.apart_m;
          ServoObject object = held.object;
          object.stiffness_N_per_m = std::min(object.stiffness_N_per_m, bounds.stiffest_N_per_m);
          if (held.drags) {
            effects.push_back({.kind = Kind::kSpringToPoint,
                               .frame = Effect::Frame::kWorld,
                               .point_m = Vec3(0, 0.0123, 0),
                               .stiffness_N_per_m = 0.1 * bounds.stiffest_N_per_m,
                               .damping_Ns_per_m = 0.1 * bounds.maxDamping_Ns_per_m});
          }
          effects = felt(effects, bounds);
          for (const char* name : {"none", "light"}) {
            const double unrest =
                unrest_m(preset, name, hand, config, carrying(1, object, effects), held.effect.mass_kg >= 1 ? 8 : 4) /
                std::max(2 * preset.resolution_m, 20e-6);
            EXPECT_LE(unrest, 1.001) << preset.name << ' ' << name << ' ' << held.name << ' ' << dampedTicks
                                     << " observed " << observed;
            most = std::max(most, unrest);
            ++runs;
          }
        }
      }
    }
  }
  RecordProperty("most_unrest_of_limit", std::to_string(most));
  RecordProperty("runs", runs);
}

/// At rest it is silent: what it adds to the hand's speed does not keep itself up.
TEST(EffectForces, ARecordedTextureLeavesEveryPresetAtRest) {
  struct Stroking final : HandIntent {
    double time_s = 0;
    HandTarget next(double dt_s, Vec3) noexcept override {
      time_s += dt_s;
      return {Vec3(0.05 * std::min(time_s, 1.0), 0.0123, 0.002 - 0.1 * std::min(time_s, 0.2))};
    }
  };
  for (const DevicePreset& preset : devicePresets()) {
    for (const bool observed : {false, true}) {
      const auto [config, bounds] = Bounded(preset, observed);
      ServoObject object = slab();
      object.stiffness_N_per_m = std::min(bounds.stiffest_N_per_m, 1000.0);
      const std::vector<Effect> effects = felt({texture(100)}, bounds);
      Stroking hand, again;
      EXPECT_LE(unrest_m(preset, "light", hand, config, carrying(1, object, effects)),
                std::max(3 * preset.resolution_m, 30e-6))
          << preset.name << " observed " << observed;
      SimulatedDevice device({preset, findHandPreset("light").value(), kPeriod_s}, again);
      VirtualServo servo({}, config, carrying(1, object, effects));
      double felt_N = 0;
      for (std::uint64_t tick = 0; tick < 1000; ++tick) {
        device.write(servo.stepAt(device.read(tick).position, DeviceState::kReady).force.written);
        felt_N = std::max(felt_N, glm::length(servo.state().effects[0].force_N));
      }
      EXPECT_GT(felt_N, 0.01) << preset.name << " observed " << observed;
    }
  }
}

/// On every kind of surface, across the stroke, and nowhere else.
TEST(EffectForces, ARecordedTextureAddsToWhatIsFeltOfEverySurfaceFeature) {
  for (int feature = 0; feature < 8; ++feature) {
    const auto stroke = strokeAlongX(0.001, 0.05);
    VirtualServo both(stroke, kWide, carrying(1, featured(feature), {texture(0.2)}));
    VirtualServo surface(stroke, kWide, carrying(1, featured(feature), {}));
    double square_N2 = 0;
    for (int i = 0; i < 1200; ++i) {
      const TelemetrySample sample = surface.step();
      const Vec3 added_N = both.step().force.contact - sample.force.contact;
      ASSERT_LE(glm::length(added_N), 2) << "feature " << feature << " tick " << i;
      if (sample.object == 0) {
        ASSERT_EQ(added_N, Vec3(0)) << "feature " << feature << " tick " << i;
      }
      if (i < 400) continue;
      ASSERT_NEAR(added_N.x, 0, 0.01) << "feature " << feature << " tick " << i;
      square_N2 += added_N.y * added_N.y / 800;
    }
    EXPECT_NEAR(std::sqrt(square_N2), 0.2, 0.1) << "feature " << feature;
    VirtualServo copy = both;
    for (int i = 0; i < 100; ++i) ASSERT_EQ(both.step().force.written, copy.step().force.written);
    EXPECT_EQ(stateImage(both.state()), stateImage(copy.state()));
  }
}

/// A slow hand presses as much as before, so that nothing but the texture changes the force.
TEST(EffectForces, EditsOfARecordedTextureComeAtTheRateOfThoseOfSurfaces) {
  constexpr int kEdits = 20'000, kTicks = 8;
  constexpr double kSpeed = 1e-3;
  std::mt19937 engine(31);
  std::uniform_real_distribution<double> number(0, 1);
  const auto hand = [](std::uint64_t tick) {
    const double s = kSpeed * kPeriod_s * static_cast<double>(tick), half = std::fmod(s, 0.08);
    return Vec3(half < 0.04 ? half - 0.02 : 0.06 - half, 0.0123, std::max(-0.001, 0.003 - s * 0.1));
  };
  struct Felt {
    double amplitude_N;
    std::shared_ptr<const EffectField> field;
  };
  std::vector<Felt> textures;
  for (int i = 0; i < 100; ++i) {
    Effect effect = texture(3 * number(engine), 1e-3 * (1 + number(engine)));
    effect.models[1] = 2 * number(engine) - 1;
    textures.push_back({effect.amplitude_N, std::make_shared<const EffectField>(effect)});
  }
  VirtualServo servo(hand, kWide, carrying(1, slab(), {}));
  Vec3 before = servo.run(60'000).force.written;
  double beyond_N = 0, reached_N = 0;
  const Felt* felt = nullptr;
  for (int edit = 0; edit < kEdits; ++edit) {
    auto scene = sceneOf(2 + static_cast<std::uint64_t>(edit), {slab()});
    const Felt* const last = felt;
    felt = number(engine) < 0.8 ? &textures[engine() % textures.size()] : nullptr;
    if (felt != nullptr) scene->effects.push_back({0, 0, felt->field});
    servo.adopt(std::move(scene));
    for (int i = 0; i < kTicks; ++i) {
      const Vec3 now = servo.step().force.written;
      const TextureMemory& its = servo.state().texture;
      const bool goesOn = felt != nullptr && (i > 0 || felt == last);
      const double byTime_N = goesOn ? felt->amplitude_N * std::abs(its.next - its.last) : 0;
      beyond_N = std::max(beyond_N, glm::distance(now, before) - byTime_N);
      reached_N = std::max(reached_N, std::abs(now.y));
      before = now;
    }
  }
  EXPECT_LE(beyond_N, kRate_N + 2 * kStiffness * kSpeed * kPeriod_s + 1e-3);
  EXPECT_GT(reached_N, 0.5);
}

/// Of a hand that goes where it is pushed, and strokes the surface of what carries it.
TEST(EffectForces, ActiveOnesGiveNoMoreThanTheirBudget) {
  const Vec3 along(0, 1, 0);
  const Effect hum{.kind = Kind::kVibration, .direction = along, .amplitude_N = 2, .frequency_Hz = 25};
  const Effect clicks{.kind = Kind::kSamples,
                      .direction = along,
                      .amplitude_N = 2,
                      .samples = {1, -1, 0.5, 0.5, -1},
                      .sample_rate_Hz = 200};
  for (const Effect& active : {texture(3), hum, clicks}) {
    Vec3 at(-0.04, 0.0123, 0.003);
    Vec3 pushed(0);
    VirtualServo servo({}, kWide, carrying(1, slab(), {active}));
    double given_J = 0;
    for (int i = 0; i < 4000; ++i) {
      const Vec3 before = at;
      at.z = std::max(-0.001, at.z - 5e-5);
      at.x = -0.04 + 0.00002 * (i % 4000);
      at.y = std::clamp(at.y + 2e-4 * pushed.y, -0.04, 0.04);
      given_J += glm::dot(pushed, at - before);
      static_cast<void>(servo.stepAt(at, DeviceState::kReady));
      pushed = servo.state().effects[0].force_N;
      ASSERT_LE(given_J, 5e-3 * (1 + kPeriod_s * i) + 1e-3) << static_cast<int>(active.kind) << ' ' << i;
    }
    EXPECT_GT(given_J, 0.01) << "and it is used " << static_cast<int>(active.kind);
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
