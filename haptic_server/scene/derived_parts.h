#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>

#include "common/error/error.h"

namespace haptics {

struct ObjectAssets;
struct ObjectRecord;
struct RigidBody;
class ShadingNormals;
class CollisionMesh;
struct CollisionPoints;
struct Tool;

/// An object that moves, collides or is held, as it is felt.
struct BodyParts {
  std::shared_ptr<const RigidBody> body;             ///< With its support points; null: it stays where it is.
  double apparentMass_kg = 0;                        ///< minApparentMass_kg(), of what moves.
  std::shared_ptr<const CollisionPoints> collision;  ///< Null: others pass through it.
  std::shared_ptr<const Tool> tool;                  ///< Null: the hand does not hold it.
};

/// Parts computed from an object's record and assets, in time that grows with its mesh. Each is null where the object has
/// none, or it has not been made yet.
struct DerivedParts {
  std::shared_ptr<const Result<BodyParts>> body;  ///< Refused: what no body or tool can be.
  std::shared_ptr<const CollisionMesh> shape;     ///< Of the mesh as lattice and residue have it.
  std::optional<std::size_t> flattened;           ///< Triangles that the lattice leaves without an area.
  std::shared_ptr<const ShadingNormals> normals;
};

/// An object with what is known of it.
struct KnownObject {
  const ObjectRecord* record;
  const ObjectAssets* assets;
  bool isLast = false;  ///< As it was before: what has not been made of it is left to others.
};

/// Called with the number of triangles before work on all of them; refuses what is to be done elsewhere.
using BeforeWork = std::function<Result<void>(std::size_t triangles)>;

/// Makes assets.derived. What one of the known objects has of the same is taken over, the first one's first. Refused: what
/// beforeWork refuses.
/// \param shapeIsNew  Mesh or lattice were given: their shape is made here. Else one that only its residue has changed
///                    is left to ServoSceneBuilder, which knows the last one.
[[nodiscard]] Result<void> derive(const ObjectRecord& record, ObjectAssets& assets, std::span<const KnownObject> known,
                                  bool shapeIsNew, const BeforeWork& beforeWork);

/// assets.derived.body, or made now; null: it does not move.
[[nodiscard]] std::shared_ptr<const Result<BodyParts>> bodyPartsOf(const ObjectRecord& record,
                                                                   const ObjectAssets& assets);

}  // namespace haptics
