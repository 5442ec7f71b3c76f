#pragma once

#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <cstddef>
#include <memory>
#include <vector>

#include "graphics_client/surface/surface_request.h"
#include "graphics_client/viewer/patches.h"

namespace haptics {

/// How the objects of one mesh and one set of surface properties are drawn. Object frame, m. Never changed once made.
struct RenderMesh {
  struct Piece {
    vtkSmartPointer<vtkPolyData> drawn;  ///< Without colours. With normals, unless faceted.
    Patch patch;  ///< Its points are numbers of `heights` and `friction`; its triangles are `drawn`'s.
  };
  std::vector<Piece> pieces;
  vtkSmartPointer<vtkPolyData> shadow;  ///< The mesh, coarser where its triangles are many.
  vtkSmartPointer<vtkPolyData>
      coarse;  ///< Drawn while the camera moves; null where the triangles are no more than it has.
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
[[nodiscard]] RenderMesh buildRenderMesh(const SurfaceRequest& request);

}  // namespace haptics
