#pragma once

#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "common/hash/content_hash.h"
#include "common/mesh/tri_mesh.h"
#include "common/scene/deformation_properties.h"
#include "common/scene/surface_properties.h"
#include "common/surface/sampled_field.h"

namespace haptics {

/// What a look is made from: all that decides on how an object is drawn, but for its colour and place.
struct LookOrder {
  ContentHash mesh;
  SurfaceProperties surface;
  DeformationProperties deformation = {};  ///< Softness aside.
  std::size_t mostTriangles = 0;

  // What the hashes above stand for.
  std::shared_ptr<const TriMesh> triangles = nullptr;
  std::shared_ptr<const SampledField> textureField = nullptr, frictionField = nullptr;  ///< Null where none is named.
  std::shared_ptr<const std::vector<float>> frictionScale = nullptr;                    ///< Null where none is named.
  std::shared_ptr<const MovedVertices> residue = nullptr;                               ///< Null where none is named.

  [[nodiscard]] bool sameAs(const LookOrder& other) const {
    return mesh == other.mesh && mostTriangles == other.mostTriangles && surface == other.surface &&
           deformation.lattice == other.deformation.lattice && deformation.residue == other.deformation.residue;
  }
};

/// How the objects of one mesh and one set of surface properties are drawn. Object frame, m. Never changed once made.
struct Look {
  struct Side {
    vtkSmartPointer<vtkPolyData>
        drawn;  ///< Without colours. With normals, unless faceted. All sides share their points.
    Vec3 axis;  ///< As in SurfaceSide.
    double spread_rad;
  };
  std::vector<Side> sides;
  vtkSmartPointer<vtkPolyData> shadow;   ///< The mesh.
  vtkSmartPointer<vtkPolyData> rims;     ///< The polygons' edges; null where they are those of the sides.
  std::vector<float> heights, friction;  ///< As in DisplayedSurface.
  float leastFriction = 0, mostFriction = 0;
  bool faceted = false, closed = false;
  double finestDetail_m = 0, longestEdge_m = 0;
  bool filtered = false;
  std::vector<Vec3> outline;  ///< Some of the mesh's vertices, the extreme ones among them.
  Vec3 low{0}, high{0};       ///< Of the box around the mesh.
};

/// Whether nothing of the side is seen from the eye (object frame), in front of it or at a slant.
[[nodiscard]] bool facesAway(const Look& look, const Look::Side& side, Vec3 eye);

/// Takes from milliseconds to about a second.
[[nodiscard]] Look makeLook(const LookOrder& order);

}  // namespace haptics
