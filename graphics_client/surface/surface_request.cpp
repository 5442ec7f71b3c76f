#include "graphics_client/surface/surface_request.h"

#include <utility>
#include <variant>

#include "common/surface/make_field.h"

namespace haptics {
namespace {

template <class Value>
std::shared_ptr<const Value> find(const std::map<ContentHash, std::shared_ptr<const Value>>& held,
                                  const ContentHash& hash) {
  const auto at = held.find(hash);
  return at == held.end() ? nullptr : at->second;
}

SurfaceFields fieldsOf(const SurfaceRequest& request) {
  const auto in = [](const auto& held) { return [&held](const ContentHash& hash) { return find(held, hash); }; };
  /// Null where a sampled or point field of the family is not here.
  const auto fieldOf = [&](const FieldFamily& family) -> std::shared_ptr<const ScalarField> {
    return makeField(family, in(request.fields), in(request.pointFields)).value_or(nullptr);
  };
  SurfaceFields fields;
  if (request.surface.texture) fields.texture = fieldOf(request.surface.texture->family);
  if (!request.surface.friction) return fields;
  const auto* family = std::get_if<FieldFamily>(&request.surface.friction->over);
  if (family) fields.friction = fieldOf(*family);
  const bool fits = request.frictionScale && request.frictionScale->size() == request.triangles->vertices.size();
  if (fits) fields.frictionScale = request.frictionScale;
  return fields;
}

}  // namespace

bool hasField(const SurfaceProperties& surface) {
  return surface.texture || (surface.friction && !std::holds_alternative<std::monostate>(surface.friction->over));
}

std::optional<SurfaceRequest> surfaceRequest(const ObjectRecord& object, const MirrorView& view,
                                             std::size_t maxTriangles) {
  SurfaceRequest request{.mesh = object.mesh,
                         .surface = object.material.surface,
                         .deformation = view.deformationOf(object),
                         .maxTriangles = hasField(object.material.surface) ? maxTriangles : 0,
                         .triangles = find(view.meshes, object.mesh)};
  bool complete = request.triangles != nullptr;
  if (auto& friction = request.surface.friction) {
    friction->dynamicOver = FactorMap{};  // is not drawn
    friction->dynamicVariation = 0;
  }
  request.surface.stiffnessOver.reset();  // likewise
  request.surface.softnessOver.reset();
  for (const auto& [kind, hash] : assetsOf(request.surface)) {
    if (kind == AssetKind::kScalarField) complete &= (request.fields[hash] = find(view.fields, hash)) != nullptr;
    if (kind == AssetKind::kPointField) {
      complete &= (request.pointFields[hash] = find(view.pointFields, hash)) != nullptr;
    }
    if (kind != AssetKind::kVertexValues) continue;
    request.frictionScale = find(view.vertexValues, hash);
    complete &= request.frictionScale != nullptr;
  }
  if (const auto& residue = request.deformation.residue) {
    request.residue = find(view.movedVertices, *residue);
    complete &= request.residue != nullptr;
  }
  if (!complete) return {};
  return request;
}

std::shared_ptr<const TriMesh> shapeAtRest(const SurfaceRequest& request) {
  if (!request.deformation.lattice && !request.residue) return request.triangles;
  auto points = shapeAtRest(request.deformation, request.triangles->vertices, request.residue.get());
  return std::make_shared<const TriMesh>(TriMesh{std::move(points), request.triangles->triangles});
}

DisplayedSurface displaySurface(const SurfaceRequest& request, const TriMesh& shape) {
  SurfaceFields fields = fieldsOf(request);
  if (&shape != request.triangles.get()) fields.material = request.triangles->vertices;
  return displaySurface(shape, request.surface, fields, request.maxTriangles);
}

}  // namespace haptics
