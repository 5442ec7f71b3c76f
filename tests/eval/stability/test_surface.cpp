#include "tests/eval/stability/test_surface.h"

#include <numbers>

#include "common/mesh/generators.h"
#include "haptic_server/servo/settling.h"
#include "tests/eval/or_throw.h"
#include "tests/eval/stability/support.h"

namespace haptics::eval {
namespace {

constexpr double kSide_m = 0.1;
/// From the edge; less than most springs give way.
constexpr double kBeside_m = 0.3e-3;
/// Radius of a dent.
constexpr double kDent_m = 0.02;

std::shared_ptr<const CollisionMesh> makeCube(std::uint32_t segments) {
  const TriMesh mesh = orThrow(makeBox(Vec3(kSide_m), segments));
  return buildCollisionMesh(mesh.vertices, mesh.triangles);
}

std::shared_ptr<const CollisionMesh> cube() {
  static const auto surface = makeCube(6);
  return surface;
}

/// Fine enough to be dented.
std::shared_ptr<const CollisionMesh> fineCube() {
  static const auto surface = makeCube(40);
  return surface;
}

/// Turned about x, and put with this place of it, in halves of its side, at the origin.
Pose turnedCube(double angle, Vec3 place) {
  const Quat turn = glm::angleAxis(angle, Vec3(1, 0, 0));
  return {turn, -(turn * (place * (kSide_m / 2)))};
}

}  // namespace

TestSurface makeWall() {
  const PressedWall& wall = pressedWall();
  return {"wall", "wall", {wall.surface}, {wall.pose}, wall.place};
}

TestSurface makeRoughWall() {
  TestSurface wall = makeWall();
  wall.name = "friction";
  wall.title = "wall with friction";
  wall.friction = true;
  return wall;
}

TestSurface makePushedBody() {
  TestSurface ground{
      "moving_body", "body of 0.1 kg on a spring", {cube()}, {turnedCube(0, {0, 0, 1})}, Vec3(3e-3, 4e-3, 0)};
  ground.motion = std::make_shared<RigidBody>(bodyOf(bodySupport(), {0, 0, 1}));
  return ground;
}

TestSurface makeElasticTissue() {
  TestSurface ground = makeWall();
  ground.name = "elastic_tissue";
  ground.title = "elastic tissue";
  ground.surfaces = {fineCube()};
  ground.tissue = std::make_shared<SoftTissue>(tissueOf(elasticSupport(), kDent_m));
  return ground;
}

TestSurface makeViscousTissue() {
  TestSurface ground = makeElasticTissue();
  ground.name = "viscous_tissue";
  ground.title = "viscous tissue";
  ground.tissue = std::make_shared<SoftTissue>(tissueOf(viscousSupport(), kDent_m));
  return ground;
}

TestSurface makeOuterEdge() {
  return {"cube_edge", "beside a cube's edge", {cube()}, {turnedCube(0, {0, 1, 1})}, Vec3(3e-3, -kBeside_m, 0)};
}

TestSurface makeGroove() {
  constexpr double kTurn = std::numbers::pi / 4;  // and the cubes overlap below the groove
  return {"groove",
          "90 degree groove",
          {cube(), cube()},
          {turnedCube(kTurn, {0, -0.5, 1}), turnedCube(kTurn, {0, 1, -0.5})},
          Vec3(3e-3, 0, 0)};
}

TestSurface makeBall() {
  constexpr double kRadius_m = 0.05;
  constexpr std::uint32_t kSegments = 40;
  const TriMesh mesh = orThrow(makeSphere(kRadius_m, kSegments));
  return {"sphere",
          "sphere, R 50 mm",
          {buildCollisionMesh(mesh.vertices, mesh.triangles)},
          {Pose{Quat(1, 0, 0, 0), Vec3(0, 0, -kRadius_m)}},
          Vec3(0)};
}

GroundContact::GroundContact(const TestSurface& ground) : surfaces_(ground.surfaces) {
  for (std::size_t i = 0; i < surfaces_.size(); ++i) {
    Body& body = bodies_.emplace_back();
    body.surface = surfaces_[i].get();
    body.previous = body.current = ground.poses[i];
    body.update();
  }
}

ServoScene sceneOf(const TestSurface& ground, double stiffness_N_per_m, double damping_Ns_per_m) {
  ServoScene scene;
  scene.revision = 1;
  for (std::size_t i = 0; i < ground.surfaces.size(); ++i) {
    ServoObject& object = scene.objects.emplace_back();
    object.id = i + 1;
    object.surface = ground.surfaces[i];
    object.pose = ground.poses[i];
    object.stiffness_N_per_m = stiffness_N_per_m;
    object.damping_Ns_per_m = damping_Ns_per_m;
    object.motion = ground.motion;
    object.tissue = ground.tissue;
    if (!ground.friction) continue;
    SurfaceProperties rough;
    rough.friction.emplace();
    rough.friction->mu_static = 0.6;
    rough.friction->mu_dynamic = 0.4;
    object.detail = makeSurfaceDetail(*ground.surfaces[i], rough, {});
  }
  return scene;
}

}  // namespace haptics::eval
