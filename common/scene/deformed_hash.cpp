#include "common/scene/deformed_hash.h"

namespace haptics {

std::optional<ContentHash> deformedHash(const SceneVersion& scene, const HeldShapes& held,
                                        std::span<const ObjectDent> dents) {
  Hasher hasher;
  for (const SceneVersion::Object& object : scene.objects()) {
    const DeformationProperties& deformation = object->deformation;
    if (deformation.empty()) continue;
    const std::vector<Vec3f>* mesh = held.vertices(object->mesh);
    const MovedVertices* residue = deformation.residue ? held.residue(*deformation.residue) : nullptr;
    if (mesh == nullptr || (deformation.residue && residue == nullptr)) return std::nullopt;
    std::vector<Dent> own;
    for (const ObjectDent& dent : dents) {
      if (deformation.softness && dent.object == object->id) own.push_back(dent.dent);
    }
    hasher.add(object->id);
    for (const Vec3f vertex : shapeAtRest(deformation, *mesh, residue)) {
      const Vec3f now = own.empty() ? vertex : dented(vertex, own, tissueOf(*deformation.softness).falloff);
      hasher.add(now.x).add(now.y).add(now.z);
    }
  }
  return hasher.finish();
}

}  // namespace haptics
