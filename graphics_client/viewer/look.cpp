#include "graphics_client/viewer/look.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <variant>

#include "common/surface/make_field.h"
#include "graphics_client/viewer/displayed_surface.h"
#include "graphics_client/viewer/poly_data.h"

namespace haptics {
namespace {

/// At most about this many vertices of an object decide on the camera and the floor, besides the extreme ones.
constexpr std::size_t kOutlinePoints = 4096;

std::vector<Vec3> outlineOf(const TriMesh& mesh) {
  std::vector<Vec3> points;
  const std::size_t step = mesh.vertices.size() / kOutlinePoints + 1;
  for (std::size_t i = 0; i < mesh.vertices.size(); i += step) points.emplace_back(mesh.vertices[i]);
  for (int axis = 0; axis < 3; ++axis) {
    const auto [low, high] = std::ranges::minmax_element(mesh.vertices, {}, [&](Vec3f v) { return v[axis]; });
    points.emplace_back(*low);
    points.emplace_back(*high);
  }
  return points;
}

/// Null where the family's sampled field is not here.
std::shared_ptr<const ScalarField> fieldOf(const FieldFamily& family,
                                           const std::shared_ptr<const SampledField>& sampled) {
  return makeField(family, [&](const ContentHash&) { return sampled; }).value_or(nullptr);
}

SurfaceFields fieldsOf(const LookOrder& order) {
  SurfaceFields fields;
  if (order.surface.texture) fields.texture = fieldOf(order.surface.texture->family, order.textureField);
  if (!order.surface.friction) return fields;
  const auto* family = std::get_if<FieldFamily>(&order.surface.friction->over);
  if (family) fields.friction = fieldOf(*family, order.frictionField);
  const bool fits = order.frictionScale && order.frictionScale->size() == order.triangles->vertices.size();
  if (fits) fields.frictionScale = order.frictionScale;
  return fields;
}

std::vector<Look::Side> sidesOf(const DisplayedSurface& surface) {
  const vtkSmartPointer<vtkPolyData> all = trianglesOf(surface.points, {}, surface.normals);
  std::vector<Look::Side> sides;
  for (const SurfaceSide& side : surface.sides) {
    const auto drawn = vtkSmartPointer<vtkPolyData>::New();
    drawn->ShallowCopy(all);
    drawn->SetPolys(cellsOf(std::span(surface.triangles).subspan(side.first, side.count)));
    sides.push_back({drawn, side.axis, side.spread_rad});
  }
  return sides;
}

}  // namespace

bool facesAway(const Look& look, const Look::Side& side, Vec3 eye) {
  /// Bumps rise a little over a side's horizon (radians).
  constexpr double kMargin_rad = 0.1;
  if (!look.closed) return false;
  const Vec3 centre = (look.low + look.high) / 2.0, towards = centre - eye;
  const double distance = glm::length(towards), radius = glm::length(look.high - look.low) / 2;
  if (!(distance > radius)) return false;
  const double angle = std::acos(std::clamp(glm::dot(side.axis, towards) / distance, -1.0, 1.0));
  return angle + std::asin(radius / distance) + side.spread_rad + kMargin_rad < std::numbers::pi / 2;
}

Look makeLook(const LookOrder& order) {
  TriMesh shaped;
  const bool isShaped = order.deformation.lattice || order.residue;
  if (isShaped) {
    shaped = {shapeAtRest(order.deformation, order.triangles->vertices, order.residue.get()),
              order.triangles->triangles};
  }
  const TriMesh& mesh = isShaped ? shaped : *order.triangles;
  DisplayedSurface surface = displaySurface(mesh, order.surface, fieldsOf(order), order.mostTriangles);
  Look look{.sides = sidesOf(surface),
            .shadow = {},
            .rims = {},
            .heights = std::move(surface.heights),
            .friction = std::move(surface.friction),
            .faceted = surface.normals.empty(),
            .closed = surface.closed,
            .finestDetail_m = surface.finestDetail_m,
            .longestEdge_m = surface.longestEdge_m,
            .filtered = surface.filtered,
            .outline = outlineOf(mesh)};
  const vtkSmartPointer<vtkPolyData>& first = look.sides.front().drawn;
  look.shadow = surface.triangles == mesh.triangles ? first : trianglesOf(mesh.vertices, mesh.triangles);
  if (!surface.rims.empty()) look.rims = segmentsOf(first, surface.rims);
  look.low = look.high = look.outline.front();
  for (const Vec3& p : look.outline) {
    look.low = glm::min(look.low, p);
    look.high = glm::max(look.high, p);
  }
  if (!look.friction.empty()) {
    const auto [least, most] = std::ranges::minmax(look.friction);
    look.leastFriction = least;
    look.mostFriction = most;
  }
  return look;
}

}  // namespace haptics
