#include "haptic_server/scene/dent_baking.h"

#include <algorithm>
#include <set>
#include <utility>

namespace haptics {
namespace {

/// The vertices that a dent displaces, and where to.
MovedVertices displaced(const std::vector<Vec3f>& shape, const Dent& dent, const Falloff& falloff) {
  MovedVertices moved;
  for (std::size_t i = 0; i < shape.size(); ++i) {
    const Vec3f now = dented(shape[i], {&dent, 1}, falloff) + Vec3f(0);
    if (now == shape[i]) continue;
    moved.vertex.push_back(static_cast<std::uint32_t>(i));
    moved.place.push_back(now);
  }
  return moved;
}

/// Along every edge of the triangles of moved vertices.
bool isTooSteep(const TriMesh& mesh, const std::vector<Vec3f>& before, const std::vector<Vec3f>& now,
                const MovedVertices& moved) {
  const auto isMoved = [&](std::uint32_t vertex) { return std::ranges::binary_search(moved.vertex, vertex); };
  return std::ranges::any_of(mesh.triangles, [&](const TriangleIndices& t) {
    if (!std::ranges::any_of(t, isMoved)) return false;
    for (std::size_t k = 0; k < t.size(); ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % t.size()];
      const Vec3 edge = Vec3(before[a]) - Vec3(before[b]);
      const Vec3 way = Vec3(now[a]) - Vec3(before[a]) - (Vec3(now[b]) - Vec3(before[b]));
      // A hundredth for the rounding of a dent that is as deep as it may be.
      if (glm::length(way) > 1.01 * kMaxDentGradient * glm::length(edge)) return true;
    }
    return false;
  });
}

}  // namespace

std::map<std::uint64_t, std::vector<PermanentDent>> permanentDents(const MotionState& motion,
                                                                   const DentWatermarks& handled) {
  std::map<std::uint64_t, std::vector<PermanentDent>> staying;
  std::set<std::uint64_t> mayChange;
  for (std::size_t i = 0; i < motion.dentCount; ++i) {
    const auto& [object, dent] = motion.dent[i];
    const std::uint64_t number = motion.staying[i];
    const auto known = handled.find(object);
    const DentWatermark until = known == handled.end() ? DentWatermark{} : known->second;
    if (number != 0 && number <= until.upTo) continue;
    if (number <= until.releasedUpTo) mayChange.insert(object);  // 0, of one that may change, among them
    if (!mayChange.contains(object)) staying[object].push_back({number, dent});
  }
  return staying;
}

BakeResult bake(const DeformationProperties& properties, const ObjectAssets& assets,
                std::span<const PermanentDent> dents) {
  BakeResult taken;
  if (!properties.softness) return taken;
  const TriMesh& mesh = *assets.mesh->mesh;
  const Falloff falloff = tissueOf(*properties.softness).falloff;
  DeformationProperties without = properties;
  without.residue.reset();
  const std::vector<Vec3f> before = shapeAtRest(without, mesh.vertices, nullptr);
  std::vector<Vec3f> now = assets.shapeAtRest(properties);
  for (const auto& [number, dent] : dents) {
    std::vector<Vec3f> next = now;
    const MovedVertices moved = displaced(now, dent, falloff);
    moved.moveIn(next);
    if (isTooSteep(mesh, before, next, moved) || !checkMovedVertices(moved)) {
      taken.releasedUpTo = number;
      break;
    }
    now = std::move(next);
    taken.upTo = number;
  }
  if (taken.upTo == 0) return taken;
  taken.residue = movedBetween(before, now);
  return taken;
}

}  // namespace haptics
