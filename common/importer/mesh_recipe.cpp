#include "common/importer/mesh_recipe.h"

#include <utility>

#include "common/mesh/generators.h"

namespace haptics {
namespace {

Result<TriMesh> within(const char* prefix, Result<TriMesh> mesh) {
  if (!mesh) return tl::unexpected(std::move(mesh).error().within(prefix));
  return mesh;
}

struct Generate {
  Result<TriMesh> operator()(const BoxSource& s) const { return within("box.", makeBox(s.size_m, s.segments)); }
  Result<TriMesh> operator()(const SphereSource& s) const {
    return within("sphere.", makeSphere(s.radius_m, s.segments));
  }
  Result<TriMesh> operator()(const CylinderSource& s) const {
    return within("cylinder.", makeCylinder(s.radius_m, s.height_m, s.segments));
  }
  Result<TriMesh> operator()(const TorusSource& s) const {
    return within("torus.", makeTorus(s.majorRadius_m, s.minorRadius_m, s.majorSegments, s.minorSegments));
  }
};

struct Count {
  double operator()(const BoxSource& s) const noexcept { return 12.0 * s.segments * s.segments; }
  double operator()(const SphereSource& s) const noexcept { return 12.0 * s.segments * s.segments; }
  double operator()(const CylinderSource& s) const noexcept { return 4.0 * s.segments; }
  double operator()(const TorusSource& s) const noexcept { return 2.0 * s.majorSegments * s.minorSegments; }
};

}  // namespace

Result<TriMesh> generate(const MeshRecipe& recipe) { return std::visit(Generate{}, recipe); }

double trianglesOf(const MeshRecipe& recipe) noexcept { return std::visit(Count{}, recipe); }

}  // namespace haptics
