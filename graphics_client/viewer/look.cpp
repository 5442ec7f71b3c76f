#include "graphics_client/viewer/look.h"

#include <algorithm>
#include <optional>
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

}  // namespace

Look makeLook(const LookOrder& order) {
  const TriMesh& mesh = *order.triangles;
  DisplayedSurface surface = displaySurface(mesh, order.surface, fieldsOf(order), order.mostTriangles);
  Look look{.drawn = trianglesOf(surface.points, surface.triangles, surface.normals),
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
  look.shadow = surface.triangles == mesh.triangles ? look.drawn : trianglesOf(mesh.vertices, mesh.triangles);
  if (!surface.rims.empty()) look.rims = segmentsOf(look.drawn, surface.rims);
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
