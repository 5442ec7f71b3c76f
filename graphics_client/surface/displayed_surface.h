#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/mesh/tri_mesh.h"
#include "common/scene/surface_properties.h"
#include "common/surface/scalar_field.h"

namespace haptics {

/// The fields that an object's properties name, null where they name none.
struct SurfaceFields {
  std::shared_ptr<const ScalarField> texture = nullptr;
  std::shared_ptr<const ScalarField> friction = nullptr;
  std::shared_ptr<const std::vector<float>> frictionScale = nullptr;  ///< For each vertex, canonical numbering.
  std::span<const Vec3f> material = {};  ///< The mesh's vertices before it was deformed; none where it is not.
};

/// A surface as it is drawn, which is as it is felt: faceted or shaded, raised by its texture. Object frame, m.
struct DisplayedSurface {
  std::vector<Vec3f> points = {};
  std::vector<Vec3f> normals = {};  ///< Unit; none where the surface is faceted and plain.
  std::vector<Vec3f> rises = {};    ///< Of each point, from the geometric surface; none without texture.
  std::vector<TriangleIndices> triangles = {};
  /// Of each point, 0 at the texture's lowest to 1 at its highest; none without texture.
  std::vector<float> heights = {};
  std::vector<float> friction = {};  ///< mu_static at each point; none where it is the same everywhere.
  /// The mesh's edges where `triangles` are finer than the mesh's: unconnected segments between points.
  std::vector<std::array<std::uint32_t, 2>> rims = {};
  bool closed = false;              ///< No back side is ever seen.
  double finestDetail_m = 0;        ///< Wavelength of what is felt; 0 without a field.
  double longestEdge_m = 0;         ///< Of the triangles that carry it; 0 without a field.
  bool filtered = false;            ///< The triangles are too coarse for the finest detail: its local mean is drawn.
  bool pitsAreFeltAsBumps = false;  ///< Of the texture.
};

/// A surface whose triangles are too coarse for what is felt on it.
struct CoarseDetail {
  std::string object;
  double detail_m = 0;  ///< Shortest wavelength felt.
  double edge_m = 0;    ///< Of the triangles.
};

/// The surface, cut fine enough to carry its fields: four edges to the shortest wavelength, as far as `maxTriangles`
/// allow. Fields are evaluated where they are felt, on the material of the geometric surface; points then rise by h along
/// N_s, and normals turn to M of Eq. (2) of the paper. At a crease, where N_s is several, a point goes where the raised
/// sides meet.
[[nodiscard]] DisplayedSurface displaySurface(const TriMesh& mesh, const SurfaceProperties& properties,
                                              const SurfaceFields& fields, std::size_t maxTriangles);

}  // namespace haptics
