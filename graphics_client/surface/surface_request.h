#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "common/hash/content_hash.h"
#include "common/mesh/tri_mesh.h"
#include "common/scene/scene.h"
#include "common/surface/point_field.h"
#include "common/surface/sampled_field.h"
#include "graphics_client/mirror/mirror_view.h"
#include "graphics_client/surface/displayed_surface.h"

namespace haptics {

/// All that decides how an object's surface is drawn, but for its colour and pose.
struct SurfaceRequest {
  ContentHash mesh;
  SurfaceProperties surface;
  DeformationProperties deformation = {};  ///< Softness aside.
  std::size_t maxTriangles = 0;

  // What the hashes above stand for.
  std::shared_ptr<const TriMesh> triangles = nullptr;
  std::map<ContentHash, std::shared_ptr<const SampledField>> fields = {};     ///< Of texture and static friction.
  std::map<ContentHash, std::shared_ptr<const PointField>> pointFields = {};  ///< Of texture and static friction.
  std::shared_ptr<const std::vector<float>> frictionScale = nullptr;          ///< Null where none is named.
  std::shared_ptr<const MovedVertices> residue = nullptr;                     ///< Null where none is named.

  [[nodiscard]] bool sameAs(const SurfaceRequest& other) const {
    return mesh == other.mesh && maxTriangles == other.maxTriangles && surface == other.surface &&
           deformation.lattice == other.deformation.lattice && deformation.residue == other.deformation.residue;
  }
};

/// Texture or friction varies over the surface: its triangles are cut finer.
[[nodiscard]] bool hasField(const SurfaceProperties& surface);

/// Nothing while the mesh or a field is still on its way.
[[nodiscard]] std::optional<SurfaceRequest> surfaceRequest(const ObjectRecord& object, const MirrorView& view,
                                                           std::size_t maxTriangles);

/// The mesh as lattice and residue have it, without dents.
[[nodiscard]] std::shared_ptr<const TriMesh> shapeAtRest(const SurfaceRequest& request);

/// displaySurface() of the shape at rest. Takes from milliseconds to about a second.
[[nodiscard]] DisplayedSurface displaySurface(const SurfaceRequest& request, const TriMesh& shape);

}  // namespace haptics
