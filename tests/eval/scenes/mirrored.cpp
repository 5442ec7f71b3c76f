// Bodies that a lattice mirrors: S39, P4.

#include <algorithm>
#include <cmath>

#include "common/deform/free_form.h"
#include "haptic_server/scene/object_assets.h"
#include "tests/eval/scenes/scenes.h"
#include "tests/eval/stage.h"
#include "tests/eval/winding.h"

namespace haptics::eval {
namespace {

const Vec3 kLow(-0.05), kSize(0.1);
constexpr std::array<std::uint32_t, 3> kPoints{2, 2, 2};

/// Stretches by 0.6 to 1.5 along three random axes, one or three of which it mirrors, or, as a check, two or none.
glm::dmat3 someMap(Random& random) {
  const glm::dmat3 turn = glm::mat3_cast(random.rotation());
  glm::dmat3 stretch(0);
  for (int k = 0; k < 3; ++k) stretch[k][k] = random.between(0.6, 1.5) * (random.below(3) == 0 ? 1 : -1);
  return glm::mat3_cast(random.rotation()) * stretch * turn;
}

/// As the scene service makes it of the object, or as the lattice leaves its triangles.
std::shared_ptr<const CollisionMesh> surfaceOf(const shapes::Shape& shape, const glm::dmat3& map, bool turnsOver) {
  DeformationProperties properties;
  properties.lattice = Lattice{kLow, kSize, kPoints, FreeForm::atRest(kLow, kSize, kPoints)};
  for (Vec3f& point : properties.lattice->control_m) point = Vec3f(map * Vec3(point));
  AssetStore store;
  ObjectAssets assets;
  assets.mesh = store.intern(TriMesh{shape.vertices, shape.triangles});
  if (turnsOver) return assets.surfaceAtRest(properties);
  return refitCollisionMesh(*assets.mesh->surface, assets.shapeAtRest(properties));
}

struct Wrong {
  int ticks = 0;
  int inside = 0;       ///< IHIP in the body.
  int notFelt = 0;      ///< HIP in the body, and no contact, or one that is not on its surface.
  int heldOutside = 0;  ///< Touching when the hand has left.
};

void strokeMapped(Renderer& method, const shapes::Shape& shape, const glm::dmat3& map, Random& random, Wrong& wrong) {
  constexpr double kOff_m = 1e-6;
  constexpr double kStep_m = 0.0003;
  shapes::Shape exact = shape.mapped([&](Vec3 v) { return map * v; });
  if (glm::determinant(map) < 0) {
    for (auto& triangle : exact.triangles) std::swap(triangle[1], triangle[2]);
  }
  const WindingMesh mesh(exact.vertices, exact.triangles);

  Stage stage(method, random);
  const int body = stage.add(shape.build());
  const Vec3 far(0, 0, 0.12);
  stage.begin(far);
  for (int i = 0; i < 10; ++i) (void)stage.tick(far);
  stage.replace(body, surfaceOf(shape, map, method.turnsMirroredOver()));
  stage.edit(far);
  for (int i = 0; i < 600; ++i) (void)stage.tick(far);

  const auto check = [&](const Felt& felt, Vec3 hip) {
    ++wrong.ticks;
    const bool isIn = mesh.depthInside(hip) > kOff_m;
    const bool isOn = felt.touching && mesh.distanceTo(felt.ihip) < kOff_m;
    wrong.notFelt += isIn && !isOn ? 1 : 0;
    wrong.inside += mesh.depthInside(felt.ihip) > kOff_m ? 1 : 0;
  };
  for (int i = 0; i < 6; ++i) {
    const auto t = static_cast<std::size_t>(random.below(static_cast<int>(exact.triangles.size())));
    const Vec3 a = exact.corner(t, 0), b = exact.corner(t, 1), c = exact.corner(t, 2);
    const Vec3 normal = glm::normalize(glm::cross(b - a, c - a));
    const Vec3 middle = (a + b + c) / 3.0;
    const Vec3 out = middle + 0.015 * normal;
    if (mesh.depthInside(out) > 0) continue;
    stage.place(out);
    Vec3 at = middle - random.between(0.001, 0.003) * normal;
    stage.lead(out, at, kStep_m, check);
    const Vec3 aside = at + 0.004 * glm::normalize(b - a);
    stage.lead(at, aside, kStep_m, check);
    stage.lead(aside, out, kStep_m, check);
    wrong.heldOutside += stage.tick(out + 0.02 * normal).touching ? 1 : 0;
  }
}

SceneResult resultOf(const Wrong& wrong) {
  return {{{"ticks", wrong.ticks},
           {"inside_ticks", wrong.inside},
           {"unfelt_ticks", wrong.notFelt},
           {"held_after_leaving", wrong.heldOutside}},
          wrong.inside + wrong.notFelt + wrong.heldOutside == 0};
}

}  // namespace

/// The body is felt from outside, on its surface and nowhere else, as one that was always so.
SceneResult strokeMirroredBodies(Renderer& method, Random& random) {
  constexpr int kBodies = 10;
  Wrong wrong;
  for (int i = 0; i < kBodies; ++i) {
    const bool isBox = random.below(2) == 0;
    const shapes::Shape shape = isBox ? shapes::box({0.03, 0.04, 0.05}, 2) : shapes::bumpy(0.02, 5);
    strokeMapped(method, shape, someMap(random), random, wrong);
  }
  return resultOf(wrong);
}

SceneResult strokeMirroredBall(Renderer& method, Random& random) {
  Wrong wrong;
  for (const Vec3 axes : {Vec3(1), Vec3(-1, 1, 1), Vec3(-1), Vec3(-1, -1, 1)}) {
    const glm::dmat3 map(Vec3(axes.x, 0, 0), Vec3(0, axes.y, 0), Vec3(0, 0, axes.z));
    strokeMapped(method, shapes::sphere(0.03, 6), map, random, wrong);
  }
  return resultOf(wrong);
}

}  // namespace haptics::eval
