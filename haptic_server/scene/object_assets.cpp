#include "haptic_server/scene/object_assets.h"

#include <algorithm>
#include <string>
#include <utility>

#include "common/interruption/interruption.h"
#include "common/surface/make_field.h"

namespace haptics {
namespace {

template <class Kind>
Result<std::shared_ptr<const Kind>> get(const ContentHash& hash, const AssetLookup& lookUp) {
  auto asset = lookUp({Kind::kKind, hash});
  if (!asset) return tl::unexpected<Error>(std::move(asset).error());
  auto typed = as<Kind>(*std::move(asset));
  if (!typed) return refused("", "is an asset of another kind");
  return typed;
}

/// Each is to be a line of the mesh.
Result<void> checkCreases(const std::vector<Crease>& creases, const TriMesh& mesh) {
  if (creases.empty()) return {};
  std::vector<bool> found(creases.size());
  for (const TriangleIndices& t : mesh.triangles) {
    interruptionPoint();
    for (std::size_t k = 0; k < t.size(); ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % t.size()];
      const auto at = std::ranges::lower_bound(creases, Crease{std::min(a, b), std::max(a, b)});
      if (at != creases.end() && *at == Crease{std::min(a, b), std::max(a, b)}) {
        found[static_cast<std::size_t>(at - creases.begin())] = true;
      }
    }
  }
  const auto missing = std::ranges::find(found, false);
  if (missing == found.end()) return {};
  const auto i = static_cast<std::size_t>(missing - found.begin());
  return refused("shading.creases", "names (" + std::to_string(creases[i][0]) + ", " + std::to_string(creases[i][1]) +
                                        "), which is no line of the mesh; give two vertices of one triangle");
}

class Gatherer {
 public:
  Gatherer(const ObjectRecord& record, const AssetLookup& lookUp, bool creasesFit)
      : record_(record), lookUp_(lookUp), creasesFit_(creasesFit) {}

  Result<ObjectAssets> gather() {
    auto mesh = get<MeshAsset>(record_.mesh, lookUp_);
    if (!mesh) return tl::unexpected<Error>(std::move(mesh.error()).within("mesh"));
    assets_.mesh = *std::move(mesh);
    const SurfaceProperties& surface = record_.material.surface;
    Result<void> done;
    if (surface.shading && !creasesFit_) done = checkCreases(surface.shading->creases, *assets_.mesh->mesh);
    if (const auto& friction = surface.friction) {
      if (done) done = gather(friction->over, "friction.", assets_.frictionField, assets_.frictionScale);
      if (done) {
        done = gather(friction->dynamicOver, "friction.dynamic_", assets_.dynamicFrictionField,
                      assets_.dynamicFrictionScale);
      }
    }
    if (done && surface.texture) done = make(surface.texture->family, "texture.field.", assets_.textureField);
    if (const auto& map = surface.stiffnessOver; done && map) {
      done = gather(map->over, "stiffness_over.", assets_.stiffnessField, assets_.stiffnessScale);
    }
    if (const auto& map = surface.softnessOver; done && map) {
      done = gather(map->over, "softness_over.", assets_.softnessField, assets_.softnessScale);
    }
    if (done && record_.deformation.residue) done = gatherResidue(*record_.deformation.residue);
    if (!done) return tl::unexpected<Error>(std::move(done).error());
    return std::move(assets_);
  }

 private:
  const ObjectRecord& record_;
  const AssetLookup& lookUp_;
  const bool creasesFit_;
  ObjectAssets assets_;

  Result<void> gatherResidue(const ContentHash& hash) {
    auto residue = get<MovedVerticesAsset>(hash, lookUp_);
    if (!residue) return tl::unexpected<Error>(std::move(residue.error()).within("deformation.residue"));
    const std::size_t vertices = assets_.mesh->mesh->vertices.size();
    if (const std::uint32_t last = (*residue)->moved->vertex.back(); last >= vertices) {
      return refused("deformation.residue", "moves vertex " + std::to_string(last) + "; the mesh has " +
                                                std::to_string(vertices) + ", numbered from 0");
    }
    assets_.residue = *std::move(residue);
    assets_.others.push_back(assets_.residue);
    return {};
  }

  Result<void> gather(const FactorMap& map, const std::string& prefix, std::shared_ptr<const ScalarField>& field,
                      std::shared_ptr<const VertexValuesAsset>& scale) {
    if (const auto* family = std::get_if<FieldFamily>(&map)) return make(*family, prefix + "field.", field);
    const auto* named = std::get_if<PerVertexScale>(&map);
    if (named == nullptr) return {};
    const std::string where = prefix + "per_vertex";
    auto values = get<VertexValuesAsset>(named->values, lookUp_);
    if (!values) return tl::unexpected<Error>(std::move(values.error()).within(where));
    const std::size_t vertices = assets_.mesh->mesh->vertices.size();
    if ((*values)->values->size() != vertices) {
      return refused(where, "has " + std::to_string((*values)->values->size()) + " values; the mesh has " +
                                std::to_string(vertices) + " vertices, and each wants one");
    }
    scale = *std::move(values);
    assets_.others.push_back(scale);
    return {};
  }

  Result<void> make(const FieldFamily& family, const std::string& where, std::shared_ptr<const ScalarField>& to) {
    if (auto held = hold(family, where); !held) return held;
    const auto sampled = [this](const ContentHash& hash) {
      const auto asset = as<FieldAsset>(assets_.find(hash));
      return asset ? asset->field : nullptr;
    };
    const auto points = [this](const ContentHash& hash) {
      const auto asset = as<PointFieldAsset>(assets_.find(hash));
      return asset ? asset->field : nullptr;
    };
    auto made = makeField(family, sampled, points);
    if (!made) return tl::unexpected<Error>(std::move(made.error()).within(where));
    to = *std::move(made);
    return {};
  }

  /// The sampled and point fields that a family names.
  Result<void> hold(const FieldFamily& family, const std::string& where) {
    if (const auto* layered = std::get_if<LayeredFamily>(&family)) {
      for (std::size_t i = 0; i < layered->layers.size(); ++i) {
        if (auto held = hold(layered->layers[i].family, where + layerField(i)); !held) return held;
      }
    }
    if (const auto* mapped = std::get_if<MappedFamily>(&family))
      return hold<FieldAsset>(mapped->field, where + "mapped");
    if (const auto* grown = std::get_if<GrownFamily>(&family))
      return hold<PointFieldAsset>(grown->points, where + "grown");
    return {};
  }

  template <class Kind>
  Result<void> hold(const ContentHash& hash, const std::string& where) {
    auto asset = get<Kind>(hash, lookUp_);
    if (!asset) return tl::unexpected<Error>(std::move(asset.error()).within(where));
    assets_.others.push_back(*std::move(asset));
    return {};
  }
};

/// Six times the signed volume that the triangles enclose, m^3.
double volumeOf(std::span<const Vec3f> vertices, std::span<const TriangleIndices> triangles) {
  const Vec3 origin(vertices.front());
  double volume = 0;
  for (const auto [a, b, c] : triangles) {
    volume += glm::dot(Vec3(vertices[a]) - origin, glm::cross(Vec3(vertices[b]) - origin, Vec3(vertices[c]) - origin));
  }
  return volume;
}

}  // namespace

std::shared_ptr<const CollisionMesh> ObjectAssets::surfaceAtRest(const DeformationProperties& deformation,
                                                                 const CollisionMesh* last) const {
  const CollisionMesh& own = *mesh->surface;
  const std::vector<Vec3f> vertices = shapeAtRest(deformation);
  if (turnsOver(mesh->mesh->vertices, vertices)) {
    std::vector<TriangleIndices> turned = mesh->mesh->triangles;
    for (TriangleIndices& triangle : turned) std::swap(triangle[1], triangle[2]);
    return buildCollisionMesh(vertices, turned);
  }
  const bool goesOn = last != nullptr && std::ranges::equal(last->triangle(0).vertex, own.triangle(0).vertex);
  return refitCollisionMesh(goesOn ? *last : own, vertices);  // not from one that was turned over
}

bool ObjectAssets::turnsOver(std::span<const Vec3f> from, std::span<const Vec3f> to) const {
  const auto& triangles = mesh->mesh->triangles;
  return mesh->surface->closed() && volumeOf(from, triangles) * volumeOf(to, triangles) < 0;
}

std::shared_ptr<const Asset> ObjectAssets::find(const ContentHash& hash) const {
  if (mesh && mesh->name.hash == hash) return mesh;
  const auto at = std::ranges::find(others, hash, [](const auto& asset) { return asset->name.hash; });
  return at == others.end() ? nullptr : *at;
}

Result<ObjectAssets> gatherAssets(const ObjectRecord& record, const AssetLookup& lookUp, bool creasesFit) {
  return Gatherer(record, lookUp, creasesFit).gather();
}

}  // namespace haptics
