#include "graphics_client/mirror/contact_error.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace haptics {
namespace {

using Corners = std::array<Vec3, 3>;

/// Squared, to the closest point of a segment.
double squaredDistance(Vec3 p, Vec3 a, Vec3 b) {
  const Vec3 along = b - a;
  const double length2 = squaredLength(along);
  const double s = length2 > 0 ? std::clamp(glm::dot(p - a, along) / length2, 0.0, 1.0) : 0;
  return squaredLength(p - (a + s * along));
}

/// Squared, to the closest point of a triangle: of its face where p is above or below that, else of its edges.
double squaredDistance(Vec3 p, const Corners& t) {
  const Vec3 normal = glm::cross(t[1] - t[0], t[2] - t[0]);
  bool above = squaredLength(normal) > 0;
  double nearest2 = squaredDistance(p, t[2], t[0]);
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 from = t[k];
    const Vec3 to = t[(k + 1) % 3];
    above = above && glm::dot(glm::cross(to - from, p - from), normal) >= 0;
    nearest2 = std::min(nearest2, squaredDistance(p, from, to));
  }
  if (!above) return nearest2;
  const double height = glm::dot(p - t[0], normal);
  return height * height / squaredLength(normal);
}

/// In the box around the triangle, widened by `reach`.
bool isNear(Vec3f p, Vec3f a, Vec3f b, Vec3f c, float reach) {
  const Vec3f low = glm::min(a, glm::min(b, c)) - reach;
  const Vec3f high = glm::max(a, glm::max(b, c)) + reach;
  return glm::all(glm::greaterThanEqual(p, low)) && glm::all(glm::lessThanEqual(p, high));
}

}  // namespace

const std::vector<Vec3f>& ContactError::atRest(const SceneVersion::Object& object, const TriMesh& mesh,
                                               const DeformationProperties& deformation, const MovedVertices* residue) {
  if (!deformation.lattice && residue == nullptr) return mesh.vertices;
  if (object_ != object || !(deformation_ == deformation)) shaped_ = shapeAtRest(deformation, mesh.vertices, residue);
  object_ = object;
  deformation_ = deformation;
  return shaped_;
}

std::optional<double> ContactError::of_m(const MirrorView& view, const TelemetrySample& sample) {
  const SceneVersion::Object object = view.scene->find(sample.object);
  if (!object ||
      !(view.bodies.contains(object->id) || view.shapes.contains(object->id) || object->deformation.softness))
    return std::nullopt;
  const auto mesh = view.meshes.find(object->mesh);
  if (mesh == view.meshes.end()) return std::nullopt;
  const std::vector<TriangleIndices>& triangles = mesh->second->triangles;
  if (sample.primitive.polygon >= triangles.size()) return std::nullopt;

  const MovedVertices* residue = nullptr;
  const DeformationProperties deformation = view.deformationOf(*object);
  if (deformation.residue) {
    const auto held = view.movedVertices.find(*deformation.residue);
    if (held == view.movedVertices.end()) return std::nullopt;
    residue = held->second.get();
  }
  const std::vector<Vec3f>& rest = atRest(object, *mesh->second, deformation, residue);
  const std::vector<Dent> dents = view.dentsIn(*object);
  const Falloff falloff = tissueOf(object->deformation.softness.value_or(Softness{.radius_m = 1})).falloff;
  const Vec3 place = toLocal(view.poseOf(*object), sample.ihip);
  const auto distance2To = [&](const TriangleIndices& t) {
    Corners corners;
    for (std::size_t k = 0; k < 3; ++k) corners[k] = Vec3(dented(rest[t[k]], dents, falloff));
    return squaredDistance(place, corners);
  };
  // The touched triangle bounds how far the nearest can be; at rest it was farther by the dents' depth at most.
  double nearest2 = distance2To(triangles[sample.primitive.polygon]);
  double reach = std::sqrt(nearest2);
  for (const Dent& dent : dents) reach += glm::length(Vec3(dent.displacement));
  if (!std::isfinite(reach)) return std::nullopt;
  constexpr double kRounding = 1e-5;  // of single precision, against what is reached for
  reach += kRounding * glm::length(place) + kRounding * reach;
  for (const TriangleIndices& t : triangles) {
    if (!isNear(Vec3f(place), rest[t[0]], rest[t[1]], rest[t[2]], static_cast<float>(reach))) continue;
    nearest2 = std::min(nearest2, distance2To(t));
  }
  return std::abs(std::sqrt(nearest2) - std::abs(sample.height_m));
}

}  // namespace haptics
