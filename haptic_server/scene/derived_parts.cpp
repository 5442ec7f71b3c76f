#include "haptic_server/scene/derived_parts.h"

#include <algorithm>
#include <string>
#include <utility>

#include "haptic_server/engine/collision/collision_points.h"
#include "haptic_server/engine/motion/coupling.h"
#include "haptic_server/engine/motion/support_points.h"
#include "haptic_server/engine/surface/shading_normals.h"
#include "haptic_server/engine/tool/tool_shell.h"
#include "haptic_server/scene/fit_to_mesh.h"
#include "haptic_server/scene/make_rigid_body.h"
#include "haptic_server/scene/object_assets.h"

namespace haptics {
namespace {

std::shared_ptr<const CollisionMesh> surfaceOf(const MeshAsset& asset) {
  return asset.surface ? asset.surface : buildCollisionMesh(asset.mesh->vertices, asset.mesh->triangles);
}

constexpr double kMaxToolReach_m = 1;  // longer ones are meshes in the wrong unit

Result<BodyParts> makeTool(const ToolProperties& properties, const MeshAsset& asset) {
  double reach_m = 0;
  for (const Vec3f vertex : asset.mesh->vertices) reach_m = std::max(reach_m, glm::length(Vec3(vertex)));
  if (reach_m > kMaxToolReach_m) {
    return refused("tool", "reaches " + std::to_string(reach_m) +
                               " m from its origin, at which the hand holds it; a tool reaches at most " +
                               std::to_string(kMaxToolReach_m) + " m: give a smaller mesh, or its unit_m");
  }
  BodyParts parts;
  if (properties.jaws) {
    const JawHinge hinge{properties.jaws->hinge_m, properties.jaws->axis, properties.jaws->reach};
    auto tool = makeJaws(asset.mesh->vertices, asset.mesh->triangles, hinge, properties.spacing_m);
    if (!tool) return tl::unexpected(Error(tool.error()).within("tool."));
    parts.tool = std::make_shared<const Tool>(*std::move(tool));
    return parts;
  }
  const auto surface = surfaceOf(asset);
  auto shell = makeToolShell(*surface, properties.spacing_m);
  if (!shell) return tl::unexpected(Error(shell.error()).within("tool."));
  parts.tool = std::make_shared<const Tool>(Tool{surface, *std::move(shell)});
  return parts;
}

std::shared_ptr<const Result<BodyParts>> makeBody(const MotionProperties& motion, const MeshAsset& asset) {
  if (motion.tool) return std::make_shared<const Result<BodyParts>>(makeTool(*motion.tool, asset));
  const TriMesh& mesh = *asset.mesh;
  BodyParts parts;
  if (motion.collision) {
    CollisionPoints points = makeCollisionPoints(*surfaceOf(asset));
    points.friction = motion.collision->friction;
    points.rolling_m = motion.collision->rolling_m;
    parts.collision = std::make_shared<const CollisionPoints>(std::move(points));
  }
  if (motion.fixed) return std::make_shared<const Result<BodyParts>>(std::move(parts));
  const bool closed = asset.surface && asset.surface->closed();
  auto body = rigidBodyFrom(motion, mesh, closed);
  if (!body) return std::make_shared<const Result<BodyParts>>(tl::unexpected<Error>(std::move(body.error())));
  if (motion.collision && !closed) {
    return std::make_shared<const Result<BodyParts>>(
        refused("collision",
                "is given, and the mesh is open: what moves would fall through others where it has no "
                "inside; close the mesh, or leave collision out"));
  }
  if (body->planeCount > 0) body->setSupport(supportPoints(mesh.vertices));
  parts.apparentMass_kg = minApparentMass_kg(*body, mesh.vertices);
  parts.body = std::make_shared<const RigidBody>(*std::move(body));
  return std::make_shared<const Result<BodyParts>>(std::move(parts));
}

/// On which shading normals stand; null: it has not been made.
const CollisionMesh* surfaceOf(const ObjectRecord& record, const ObjectAssets& assets) {
  if (assets.derived.shape) return assets.derived.shape.get();
  const bool asMesh = !record.deformation.lattice && !record.deformation.residue;
  return asMesh ? assets.mesh->surface.get() : nullptr;
}

class Deriver {
 public:
  Deriver(const ObjectRecord& record, ObjectAssets& assets, std::span<const KnownObject> known,
          const BeforeWork& beforeWork)
      : record_(record), assets_(assets), known_(known), beforeWork_(beforeWork) {}

  void addBody() {
    if (!record_.motion) return;
    const bool taken = takeOver(&DerivedParts::body, [this](const KnownObject& known) {
      return known.assets->mesh == assets_.mesh && known.record->motion == record_.motion;
    });
    if (taken || !mayWork()) return;
    assets_.derived.body = makeBody(*record_.motion, *assets_.mesh);
  }

  void addShape(bool isNew) {
    const DeformationProperties& own = record_.deformation;
    if (!own.lattice && !own.residue) return;
    const auto same = [&](const KnownObject& known) {
      const DeformationProperties& its = known.record->deformation;
      return known.assets->mesh == assets_.mesh && its.lattice == own.lattice && its.residue == own.residue;
    };
    const bool taken = takeOver(&DerivedParts::shape, same);
    const bool counted = takeOver(&DerivedParts::flattened, same);
    if (taken || !isNew || !mayWork()) return;
    assets_.derived.shape = assets_.surfaceAtRest(record_.deformation);
    if (own.lattice && !counted) assets_.derived.flattened = flattenedBy(*own.lattice, *assets_.mesh->mesh);
  }

  void addNormals() {
    const auto& shading = record_.material.surface.shading;
    const CollisionMesh* surface = surfaceOf(record_, assets_);
    if (!shading || surface == nullptr) return;
    const bool taken = takeOver(&DerivedParts::normals, [&](const KnownObject& known) {
      return surfaceOf(*known.record, *known.assets) == surface && known.record->material.surface.shading == shading;
    });
    if (taken || !mayWork()) return;
    assets_.derived.normals = std::make_shared<const ShadingNormals>(*surface, shading->crease_rad, shading->creases);
  }

  [[nodiscard]] const Result<void>& done() const noexcept { return done_; }

 private:
  const ObjectRecord& record_;
  ObjectAssets& assets_;
  const std::span<const KnownObject> known_;
  const BeforeWork& beforeWork_;
  Result<void> done_;

  bool mayWork() {
    if (done_) done_ = beforeWork_(assets_.mesh->mesh->triangles.size());
    return done_.has_value();
  }

  /// Whether there is nothing to be made.
  template <class Part, class Same>
  bool takeOver(Part DerivedParts::*part, const Same& same) {
    for (const KnownObject& known : known_) {
      if (!same(known)) continue;
      assets_.derived.*part = known.assets->derived.*part;
      if (assets_.derived.*part || known.isLast) return true;
    }
    return false;
  }
};

}  // namespace

Result<void> derive(const ObjectRecord& record, ObjectAssets& assets, std::span<const KnownObject> known,
                    bool shapeIsNew, const BeforeWork& beforeWork) {
  Deriver deriver(record, assets, known, beforeWork);
  deriver.addBody();
  deriver.addShape(shapeIsNew);
  deriver.addNormals();
  return deriver.done();
}

std::shared_ptr<const Result<BodyParts>> bodyPartsOf(const ObjectRecord& record, const ObjectAssets& assets) {
  if (!record.motion) return nullptr;
  return assets.derived.body ? assets.derived.body : makeBody(*record.motion, *assets.mesh);
}

}  // namespace haptics
