// Two hands in one scene: S29.

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "common/mesh/generators.h"
#include "haptic_server/engine/collision/collision_points.h"
#include "haptic_server/engine/surface/surface_detail.h"
#include "tests/eval/moving_world.h"
#include "tests/eval/scenes/scenes.h"
#include "tests/eval/stage.h"

namespace haptics::eval {
namespace {

const Vec3 kHeldBrick_m{0.06, 0.03, 0.02};
constexpr double kFriction = 0.6;
constexpr double kLift_m = 0.04;

void letCollide(ServoObject& object) {
  object.collision = std::make_shared<const CollisionPoints>(makeCollisionPoints(*object.surface));
}

std::uint64_t addBrick(MovingWorld& world, double mass_kg, double stiffness_N_per_m) {
  MovingSolid solid = solidFrom(makeBox(kHeldBrick_m, 1).value(), mass_kg);
  solid.body.gravity_m_per_s2 = {0, 0, -9.81};
  const std::uint64_t id = world.add(solid, {{1, 0, 0, 0}, {0, 0, kHeldBrick_m.z / 2}});
  SurfaceProperties properties;
  properties.friction.emplace();
  properties.friction->mu_static = kFriction;
  properties.friction->mu_dynamic = 0.5;
  ServoObject& brick = world.object(id);
  brick.detail = makeSurfaceDetail(*brick.surface, properties, {});
  brick.stiffness_N_per_m = stiffness_N_per_m;
  letCollide(brick);
  return id;
}

void addTable(MovingWorld& world) {
  const std::uint64_t id =
      world.add(solidFrom(makeBox({0.5, 0.5, 0.02}, 1).value()), {{1, 0, 0, 0}, {0, 0, -0.01}}, false);
  letCollide(world.object(id));
}

}  // namespace

/// Two points press a brick from both sides, lift it by friction, hold it for 60 s and sway meanwhile. The weight is within
/// the cone, 2 mu k depth > m g, so neither slips. One of them alone lifts nothing.
SceneResult pinchAndLift(Renderer& /*ours*/, Random& random) {
  constexpr int kPress = 500, kLift = 1'500, kHold = 60'000;
  constexpr double kStiffness_N_per_m = 800;
  const double mass_kg = random.between(0.05, 0.15), depth_m = random.between(0.003, 0.005);
  const double above_m = random.between(0.001, 0.004), aside_m = random.between(-0.002, 0.002);
  const double sway_m = random.between(0.002, 0.01), sway_Hz = random.between(0.2, 1);
  MovingWorld world;
  addTable(world);
  const std::uint64_t brick = addBrick(world, mass_kg, kStiffness_N_per_m);
  world.publish();
  int slips = 0, notFinite = 0, falls = 0;
  double slid_m = 0, lowest_m = 1;
  std::array<Vec3, 2> stuckAt{};  // brick's frame
  for (int i = 0; i < kPress + kLift + kHold; ++i) {
    const double closed = std::min(1.0, static_cast<double>(i) / kPress);
    const double raised = std::clamp(static_cast<double>(i - kPress) / kLift, 0.0, 1.0);
    const int held = std::max(0, i - kPress - kLift);
    const double sway = sway_m * std::sin(2 * std::numbers::pi * sway_Hz * kPeriod_s * held);
    const double half = kHeldBrick_m.x / 2 + 0.005 - closed * (0.005 + depth_m);
    const Vec3 middle(sway, aside_m, kHeldBrick_m.z / 2 + above_m + kLift_m * raised);
    const auto [first, second] = world.tick(middle - Vec3(half, 0, 0), middle + Vec3(half, 0, 0));
    notFinite += isFinite(first.force.written) && isFinite(second.force.written) ? 0 : 1;
    if (i < kPress) continue;
    falls += first.object != brick || second.object != brick ? 1 : 0;
    slips += first.frictionState != FrictionState::kSticking || second.frictionState != FrictionState::kSticking;
    if (i < kPress + kLift) continue;
    const Pose& pose = world.poseOf(brick);
    const std::array at{toLocal(pose, first.stickingPoint), toLocal(pose, second.stickingPoint)};
    if (held == 0) stuckAt = at;
    for (std::size_t hand = 0; hand < at.size(); ++hand)
      slid_m = std::max(slid_m, glm::distance(at[hand], stuckAt[hand]));
    lowest_m = std::min(lowest_m, pose.position.z - kHeldBrick_m.z / 2);
  }
  SceneResult result;
  result.measures = {{"lowest_mm", 1e3 * lowest_m},
                     {"slid_in_60_s_um", 1e6 * slid_m},
                     {"ticks_that_slip", slips},
                     {"ticks_without_hold", falls},
                     {"non_finite_ticks", notFinite}};
  result.pass = lowest_m > kLift_m - 0.005 && slid_m < 1e-6 && slips == 0 && falls == 0 && notFinite == 0;
  return result;
}

}  // namespace haptics::eval
