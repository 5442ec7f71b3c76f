#include "tests/bench/step_replay.h"

#include <numbers>
#include <optional>
#include <utility>

#include "common/mesh/generators.h"
#include "common/surface/fourier_field.h"
#include "common/surface/noise_field.h"
#include "haptic_server/engine/geometry/spaced_points.h"
#include "haptic_server/engine/motion/solid.h"

namespace haptics::bench {
namespace {

std::shared_ptr<const SurfaceDetail> detailOf(const CollisionMesh& surface, const SurfaceCase& features) {
  SurfaceProperties properties;
  DetailFields fields;
  if (features.shading) properties.shading.emplace().crease_rad = std::numbers::pi / 3;
  if (features.friction) {
    properties.friction.emplace();
    properties.friction->mu_static = 0.6;
    properties.friction->mu_dynamic = 0.4;
  }
  if (features.texture != SurfaceCase::Texture::kNone) properties.texture.emplace().amplitude_m = 1e-4;
  if (features.texture == SurfaceCase::Texture::kGrating) {
    fields.texture = std::make_shared<FourierField>(FourierFamily{{{1, Vec3(1, 0, 0), 3e-3, 0}}});
  } else if (features.texture == SurfaceCase::Texture::kNoise) {
    fields.texture = std::make_shared<NoiseField>(NoiseFamily{2e-3, 1, 0.5, 1});
  }
  return makeSurfaceDetail(surface, properties, fields);
}

StepConfig configOf(const SurfaceCase& features) {
  StepConfig config;
  if (features.stabilised) {
    config.observer = ObserverSettings{.mass_kg = 0.05,
                                       .delay_s = config.period_s,
                                       .hardBandwidth_Hz = 217,
                                       .softUpTo_N_per_m = 700,
                                       .hardFrom_N_per_m = 1600};
  }
  return config;
}

ServoScene sceneOf(std::vector<ServoObject> objects) {
  ServoScene scene;
  scene.revision = 1;
  scene.objects = std::move(objects);
  return scene;
}

ServoScene sceneOf(const Body& body, std::uint32_t segments, const SurfaceCase& features) {
  ServoObject object{.id = 1,
                     .surface = sphere(segments),
                     .pose = body.current,
                     .stiffness_N_per_m = 1000,
                     .damping_Ns_per_m = 0.5,
                     .detail = detailOf(*sphere(segments), features)};
  if (features.soft) object.tissue = std::make_shared<const SoftTissue>(SoftTissue{Falloff(0.005, 2), 500, 0.1});
  return sceneOf({std::move(object)});
}

ServoObject boxAt(std::uint64_t id, Vec3 size_m, int segments, Vec3 position) {
  const TriMesh mesh = makeBox(size_m, segments).value();
  return {.id = id,
          .surface = buildCollisionMesh(mesh.vertices, mesh.triangles),
          .pose = {{1, 0, 0, 0}, position},
          .stiffness_N_per_m = 1000,
          .damping_Ns_per_m = 0.5};
}

RigidBody rigidBox(Vec3 size_m, double mass_kg) {
  const TriMesh mesh = makeBox(size_m, 1).value();
  const Solid solid = solidOf(mesh.vertices, mesh.triangles);
  RigidBody body;
  static_cast<void>(spreadMass(mass_kg, solid.centre, mass_kg / solid.volume_m3 * solid.inertia, body.mass));
  return body;
}

void collide(ServoObject& object, RigidBody body) {
  CollisionPoints points = makeCollisionPoints(*object.surface);
  points.friction = 0.3;
  object.collision = std::make_shared<const CollisionPoints>(std::move(points));
  object.motion = std::make_shared<const RigidBody>(std::move(body));
}

StepReplay withEffect(std::optional<Effect::Kind> chosen) {
  constexpr int kPoints = 1000, kTurns = 3;
  constexpr double kBeside_m = 0.002, kCircle_m = 0.01;
  const Effect::Kind kind = chosen.value_or(Effect::Kind::kSpringToPoint);
  Effect effect{.kind = kind, .stiffness_N_per_m = 300, .damping_Ns_per_m = 0.5, .limit_N = 3, .reach_m = 0.1};
  for (int i = 0; i < kPoints && kind != Effect::Kind::kSpringToPoint; ++i) {
    const double angle = 2 * std::numbers::pi * kTurns * i / (kPoints - 1);
    effect.path_m.push_back(kCircle_m * Vec3(std::cos(angle), std::sin(angle), 0.01 * angle));
  }
  ServoScene scene = sceneOf({boxAt(1, Vec3(0.1), 1, {0, 0, -1})});
  for (Vec3& point : effect.path_m) point.z += 1;
  effect.point_m.z = 1;
  if (chosen) scene.effects.push_back({0, 0, std::make_shared<const EffectField>(effect)});
  std::vector<Vec3> path = circle({0, 0, kBeside_m}, {0, 0, 1}, kCircle_m);
  return {std::move(scene), {}, wayTo(path.front(), {0, 0, 0.05}), std::move(path)};
}

}  // namespace

StepReplay::StepReplay(ServoScene scene, const StepConfig& config, const std::vector<Vec3>& approach,
                       std::vector<Vec3> path)
    : scene_(std::move(scene)),
      path_(std::move(path)),
      config_(config),
      state_(std::make_unique<HapticState>(config_)) {
  static_cast<void>(adoptScene(scene_, *state_, 0));  // nothing is in contact
  for (const Vec3 hip : approach) static_cast<void>(hapticStep(scene_, *state_, config_, inputAt(hip)));
  for (std::size_t i = 0; i < path_.size(); ++i) static_cast<void>(tick());
}

StepReplay::StepReplay(const Scene& scene, std::uint32_t segments, const SurfaceCase& surface)
    : StepReplay(sceneOf(scene.bodies.front(), segments, surface), configOf(surface), scene.approach, scene.path) {}

StepReplay heldTool() {
  constexpr double kSpacing_m = 0.004, kCircle_m = 0.01, kPressed_m = 0.003;
  const Vec3 size(0.04, 0.02, 0.01);
  ServoObject table = boxAt(1, {0.4, 0.4, 0.1}, 30, {0, 0, -0.05});
  table.sharp = std::make_shared<const std::vector<Vec3>>(sharpPoints(*table.surface, kSpacing_m, kMaxToolPoints));
  ServoObject bar = boxAt(2, size, 2, {});
  bar.tool = std::make_shared<const Tool>(Tool{bar.surface, makeToolShell(*bar.surface, kSpacing_m).value()});
  bar.torsion_Nm_per_rad = 1;
  std::vector<Vec3> path = circle({0, 0, size.z / 2 - kPressed_m}, {0, 0, 1}, kCircle_m);
  return {sceneOf({std::move(table), std::move(bar)}), {}, wayTo(path.front(), {0, 0, 0.02}), std::move(path)};
}

StepReplay inTheOpen() { return withEffect(std::nullopt); }
StepReplay springToPoint() { return withEffect(Effect::Kind::kSpringToPoint); }
StepReplay springToPath() { return withEffect(Effect::Kind::kSpringToPath); }
StepReplay guide() { return withEffect(Effect::Kind::kGuide); }

StepReplay slidingBodies() {
  const Vec3 board_m(0.2, 0.2, 0.02), brick_m(0.06, 0.04, 0.03);
  constexpr double kBoard_kg = 500, kBrick_kg = 0.15;
  constexpr double kSwing_m = 0.005, kSwing_per_s = 30;  // so fast that friction does not hold the bricks
  RigidBody board = rigidBox(board_m, kBoard_kg);
  board.spring = {.stiffness_N_per_m = kBoard_kg * kSwing_per_s * kSwing_per_s, .stiffness_Nm_per_rad = 1e6};
  board.gravity_m_per_s2 = Vec3(kSwing_m * kSwing_per_s * kSwing_per_s, 0, 0);  // at rest it is so far away
  std::vector<ServoObject> objects{boxAt(1, board_m, 1, {0, 0, -board_m.z / 2}),
                                   boxAt(2, brick_m, 1, {0, 0, brick_m.z / 2}),
                                   boxAt(3, brick_m, 1, {0.004, 0.003, 1.5 * brick_m.z})};
  collide(objects[0], std::move(board));
  for (const std::size_t i : {1U, 2U}) collide(objects[i], rigidBox(brick_m, kBrick_kg));
  std::vector<Vec3> path = circle({0, 0, 0.2}, {0, 0, 1}, kRubbingRadius_m);
  return {sceneOf(std::move(objects)), {}, wayTo(path.front(), {0, 0, 0.25}), std::move(path)};
}

}  // namespace haptics::bench
