#include "tests/eval/combinations/bodies.h"

#include <cmath>
#include <map>

#include "common/mesh/generators.h"
#include "common/scene/motion_properties.h"
#include "haptic_server/scene/make_rigid_body.h"
#include "tests/eval/or_throw.h"

namespace haptics::eval {

const TriMesh& coarsePad() {
  static const TriMesh mesh = orThrow(makeBox(Vec3(kPadSide_m), 8));
  return mesh;
}

const TriMesh& finePad() {
  static const TriMesh mesh = orThrow(makeBox(Vec3(kPadSide_m), 50));
  return mesh;
}

const TriMesh& clayPad() {
  static const TriMesh mesh = orThrow(makeBox(Vec3(kPadSide_m), 80));
  return mesh;
}

const TriMesh& ball() {
  static const TriMesh mesh = orThrow(makeSphere(kBallRadius_m, 12));
  return mesh;
}

const TriMesh& fineBall() {
  static const TriMesh mesh = orThrow(makeSphere(kBallRadius_m, 48));
  return mesh;
}

std::shared_ptr<const CollisionMesh> atRest(const TriMesh& mesh) {
  static std::map<const TriMesh*, std::shared_ptr<const CollisionMesh>> known;
  std::shared_ptr<const CollisionMesh>& surface = known[&mesh];
  if (!surface) surface = buildCollisionMesh(mesh.vertices, mesh.triangles);
  return surface;
}

Lattice randomLattice(double side_m, Random& random) {
  constexpr double kRoom_m = 5e-3, kMoved_m = 3e-3;
  Lattice lattice{
      .low_m = Vec3(-side_m / 2 - kRoom_m), .size_m = Vec3(side_m + 2 * kRoom_m), .points = {3, 3, 3}, .control_m = {}};
  for (int z = 0; z < 3; ++z) {
    for (int y = 0; y < 3; ++y) {
      for (int x = 0; x < 3; ++x) {
        const Vec3 moved{random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)};
        lattice.control_m.emplace_back(lattice.low_m + lattice.size_m * Vec3(x, y, z) * 0.5 + moved * kMoved_m);
      }
    }
  }
  return lattice;
}

Skin randomSkin(Feature a, Feature b, Random& random) {
  const auto has = [&](Feature feature) { return a == feature || b == feature; };
  Skin drawn;
  drawn.shaded = true;
  drawn.textureHeight_m = random.between(0.1e-3, 0.25e-3);
  drawn.relief = randomWaves(random, 1, 7e-3, 14e-3);
  // Partly into the material: where that yields, the same place in space is another one of the wave.
  Vec3& direction = drawn.relief.terms[0].direction;
  direction = glm::normalize(Vec3(direction.x, direction.y, direction.z < 0 ? direction.z - 0.5 : direction.z + 0.5));
  drawn.muDynamic = random.between(0.25, 0.4);
  drawn.muStatic = drawn.muDynamic + random.between(0.05, 0.2);
  drawn.variation = random.between(0.4, 0.7);
  drawn.map = randomWaves(random, 4, 8e-3, 20e-3);
  if (!has(Feature::kShading)) drawn.shaded = false;
  if (!has(Feature::kTexture)) drawn.textureHeight_m = 0;
  if (!has(Feature::kFriction)) drawn.muStatic = drawn.muDynamic = 0;
  return drawn;
}

std::vector<Effect> Pulls::effects() const {
  return {{.kind = Effect::Kind::kSpringToPoint, .point_m = point_m, .stiffness_N_per_m = toPoint_N_per_m},
          {.kind = Effect::Kind::kSpringToLine,
           .point_m = line_m,
           .direction = along,
           .stiffness_N_per_m = toLine_N_per_m}};
}

Vec3 Pulls::force_N(Vec3 hip) const {
  const Vec3 toLine = line_m - hip;
  return toPoint_N_per_m * (point_m - hip) + toLine_N_per_m * (toLine - glm::dot(toLine, along) * along);
}

Pulls randomPulls(Random& random) {
  constexpr double kFar_m = 0.03;
  return {random.direction() * kFar_m, random.direction() * kFar_m, random.direction(), random.between(10, 30),
          random.between(10, 30)};
}

Slider randomSlider(Random& random) {
  Slider slider;
  const double tilt = random.between(0, 0.6), turn = random.between(0, 6.28);
  slider.axis = {std::sin(tilt) * std::cos(turn), std::sin(tilt) * std::sin(turn), std::cos(tilt)};
  slider.mass_kg = random.between(0.2, 0.5);
  slider.spring_N_per_m = random.between(1500, 3000);
  slider.damping_Ns_per_m = random.between(20, 40);
  return slider;
}

std::shared_ptr<const RigidBody> Slider::body(const TriMesh& mesh) const {
  constexpr double kFar_m = 0.05;
  MotionProperties properties;
  properties.mass_kg = mass_kg;
  properties.gravity_m_per_s2 = Vec3(0);
  properties.spring.stiffness_N_per_m = spring_N_per_m;
  properties.spring.damping_Ns_per_m = damping_Ns_per_m;
  properties.joint = JointProperties{JointProperties::Kind::kSlider, Vec3(0), axis, -kFar_m, kFar_m};
  return std::make_shared<const RigidBody>(orThrow(rigidBodyFrom(properties, mesh)));
}

void SliderReference::follow(const Pose& pose, Vec3 onHand_N, bool isJudged) {
  constexpr int kParts = 20;
  const bool begins = !begun_;
  if (begins) start_ = pose;
  begun_ = true;
  const Vec3 axis = start_.rotation * slider_.axis;
  const double push_N = -glm::dot(onHand_N, axis);
  for (int i = 0; i < kParts && !begins; ++i) {
    const double pushed_N = std::lerp(push_N_, push_N, (i + 0.5) / kParts);
    const double force_N = pushed_N - slider_.spring_N_per_m * place_m_ - slider_.damping_Ns_per_m * speed_m_per_s_;
    speed_m_per_s_ += force_N / slider_.mass_kg * kTick_s / kParts;
    place_m_ += speed_m_per_s_ * kTick_s / kParts;
  }
  push_N_ = push_N;
  if (!isJudged) return;
  const double measured_m = glm::dot(pose.position - start_.position, axis);
  farthest_m_ = std::max(farthest_m_, std::abs(measured_m - place_m_));
  longest_m_ = std::max(longest_m_, std::abs(place_m_));
}

}  // namespace haptics::eval
