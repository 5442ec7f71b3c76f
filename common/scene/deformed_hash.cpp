#include "common/scene/deformed_hash.h"

namespace haptics {

std::optional<ContentHash> deformedHash(const SceneVersion& scene, const VerticesOf& verticesOf,
                                        std::span<const ObjectDent> dents) {
  Hasher hasher;
  for (const SceneVersion::Object& object : scene.objects()) {
    const auto& [softness, lattice] = object->deformation;
    if (!softness && !lattice) continue;
    const std::vector<Vec3f>* rest = verticesOf(object->mesh);
    if (rest == nullptr) return std::nullopt;
    std::vector<Vec3f> vertices = lattice ? shapedBy(*lattice, *rest) : *rest;
    std::vector<Dent> own;
    for (const ObjectDent& dent : dents) {
      if (softness && dent.object == object->id) own.push_back(dent.dent);
    }
    hasher.add(object->id);
    for (const Vec3f vertex : vertices) {
      const Vec3f now = own.empty() ? vertex : dented(vertex, own, tissueOf(*softness).falloff);
      hasher.add(now.x).add(now.y).add(now.z);
    }
  }
  return hasher.finish();
}

}  // namespace haptics
