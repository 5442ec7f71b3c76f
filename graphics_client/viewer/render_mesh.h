#pragma once

#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <cstddef>
#include <map>
#include <memory>
#include <vector>

#include "common/hash/content_hash.h"
#include "common/mesh/tri_mesh.h"
#include "common/scene/deformation_properties.h"
#include "common/scene/surface_properties.h"
#include "common/surface/point_field.h"
#include "common/surface/sampled_field.h"
#include "graphics_client/viewer/patches.h"

namespace haptics {

/// What a render mesh is built from: all that decides how an object is drawn, but for its colour and pose.
struct RenderMeshRequest {
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

  [[nodiscard]] bool sameAs(const RenderMeshRequest& other) const {
    return mesh == other.mesh && maxTriangles == other.maxTriangles && surface == other.surface &&
           deformation.lattice == other.deformation.lattice && deformation.residue == other.deformation.residue;
  }
};

/// How the objects of one mesh and one set of surface properties are drawn. Object frame, m. Never changed once made.
struct RenderMesh {
  struct Piece {
    vtkSmartPointer<vtkPolyData> drawn;  ///< Without colours. With normals, unless faceted.
    Patch patch;  ///< Its points are numbers of `heights` and `friction`; its triangles are `drawn`'s.
  };
  std::vector<Piece> pieces;
  vtkSmartPointer<vtkPolyData> shadow;   ///< The mesh, coarser where its triangles are many.
  vtkSmartPointer<vtkPolyData> rims;     ///< The polygons' edges; null where they are those of the pieces.
  std::vector<float> heights, friction;  ///< As in DisplayedSurface.
  float minFriction = 0, maxFriction = 0;
  bool faceted = false, closed = false;
  std::size_t triangles = 0;  ///< Of all pieces.
  double finestDetail_m = 0, longestEdge_m = 0;
  bool filtered = false, pitsAreFeltAsBumps = false;
  std::vector<Vec3> outline;  ///< Some of the mesh's vertices, the extreme ones among them.
  Vec3 low{0}, high{0};       ///< Of the box around the mesh.
};

/// Whether nothing of the piece is seen from the eye (object frame), in front of it or at a slant.
[[nodiscard]] bool facesAway(const RenderMesh& renderMesh, const RenderMesh::Piece& piece, Vec3 eye);

/// Takes from milliseconds to about a second.
[[nodiscard]] RenderMesh buildRenderMesh(const RenderMeshRequest& request);

}  // namespace haptics
