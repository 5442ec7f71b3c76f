#include "haptic_server/engine/surface/surface_detail.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/interruption/interruption.h"
#include "common/maths/barycentric.h"
#include "common/maths/elementary.h"

namespace haptics {
namespace {

/// Spread evenly over the polygons and over each (the R2 sequence of M. Roberts, 2018).
[[nodiscard]] Vec3 samplePlace(const TriangleMap::Corners& corners, std::uint32_t i) {
  double u = std::fmod(0.5 + 0.7548776662466927 * i, 1.0);
  double v = std::fmod(0.5 + 0.5698402909980532 * i, 1.0);
  if (u + v > 1) {
    u = 1 - u;
    v = 1 - v;
  }
  return corners[0] + (corners[1] - corners[0]) * u + (corners[2] - corners[0]) * v;
}

/// Largest eigenvalue of a symmetric 2 x 2 matrix.
[[nodiscard]] double largestEigenvalue(const glm::dmat2& m) {
  const double mean = (m[0][0] + m[1][1]) / 2;
  return mean + elementary::hypot((m[0][0] - m[1][1]) / 2, m[0][1]);
}

/// Interpolates values at the vertices linearly at a point of a triangle.
[[nodiscard]] double interpolated(const std::vector<float>& values, const TriangleRecord& triangle,
                                  const Vec3& place) noexcept {
  const Vec3 share = glm::max(barycentric(triangle.corner(0), triangle.corner(1), triangle.corner(2), place), Vec3(0));
  double sum = 0;
  for (int k = 0; k < 3; ++k) sum += share[k] * static_cast<double>(values[triangle.vertexAt(k)]);
  return sum / (share.x + share.y + share.z);
}

/// Sides of a nanometre: a deformation may leave next to nothing of a triangle.
constexpr double kMinArea2_m4 = 1e-36;

[[nodiscard]] Vec3 gradientOf(const std::vector<float>& values, const TriangleRecord& triangle) noexcept {
  const Vec3 normal = triangle.areaNormal();
  const double area2 = squaredLength(normal);
  if (!(area2 > kMinArea2_m4)) return Vec3(0);
  const double first = values[triangle.vertexAt(0)];
  const double along1 = values[triangle.vertexAt(1)] - first, along2 = values[triangle.vertexAt(2)] - first;
  const Vec3 edge1 = triangle.corner(1) - triangle.corner(0), edge2 = triangle.corner(2) - triangle.corner(0);
  return (glm::cross(edge2, normal) * along1 + glm::cross(normal, edge1) * along2) / area2;
}

}  // namespace

TriangleMap::Corners cornersOf(const TriangleRecord& triangle, const std::vector<Vec3f>* material) noexcept {
  TriangleMap::Corners corners;
  for (int k = 0; k < 3; ++k) {
    corners[static_cast<std::size_t>(k)] =
        material == nullptr ? triangle.corner(k) : Vec3((*material)[triangle.vertexAt(k)]);
  }
  return corners;
}

TextureDetail::TextureDetail(const CollisionMesh& surface, const Texture& texture,
                             std::shared_ptr<const ScalarField> field, const std::vector<Vec3f>* material)
    : field_(std::move(field)),
      law_(texture.law),
      amplitude_m_(texture.amplitude_m),
      zero_(texture.literal ? 0 : field_->lowest()),
      gain_(texture.gain_K),
      highest_m_(amplitude_m_ * (field_->highest() - zero_)) {
  const std::uint32_t count = surface.triangleCount();
  for (std::uint32_t i = 0; i < kSamples; ++i) {
    interruptionPoint();
    const auto t = static_cast<std::uint32_t>(std::uint64_t{count} * i / kSamples);
    const TriangleMap::Corners corners = cornersOf(surface.triangle(t), material);
    const Vec3 normal = unitOrZero(glm::cross(corners[1] - corners[0], corners[2] - corners[0]));
    const FieldShape shape = shapeAround(*field_, samplePlace(corners, i), normal);
    const glm::dmat2 sideways = glm::outerProduct(shape.slope, shape.slope) + shape.curvature * (shape.value - zero_);
    const double squared = amplitude_m_ * amplitude_m_;
    steepness_ = std::max(steepness_, squared * largestEigenvalue(sideways));
    squaredSlope_ = std::max(squaredSlope_, squared * glm::dot(shape.slope, shape.slope));
    curvature_per_m_ = std::max(curvature_per_m_, amplitude_m_ * largestEigenvalue(shape.curvature));
  }
}

HeightSample TextureDetail::at(Vec3 place) const noexcept {
  const FieldSample f = field_->at(place);
  return {amplitude_m_ * (f.value - zero_), amplitude_m_ * f.gradient};
}

double TextureDetail::gainFor(double stiffness_N_per_m, double most_N_per_m) const noexcept {
  const double lateral = stiffness_N_per_m * steepness_;
  return gain_ * lateral > most_N_per_m ? most_N_per_m / lateral : gain_;
}

SurfaceFactor::SurfaceFactor(double variation, FactorSource source, double least)
    : variation_(variation), source_(std::move(source)), least_(least) {
  if (!source_.field) return;
  slope_per_m_ = std::abs(variation) * source_.field->bounds().slope_per_m;
  curvature_per_m2_ = std::abs(variation) * source_.field->bounds().curvature_per_m2;
}

double SurfaceFactor::highest() const noexcept {
  const auto& [field, scale] = source_;
  if (scale) return std::max<double>(least_, scale->empty() ? 0 : *std::ranges::max_element(*scale));
  if (!field) return 1;
  return std::max({least_, 1 + variation_ * field->lowest(), 1 + variation_ * field->highest()});
}

double SurfaceFactor::at(const TriangleRecord& triangle, const Vec3& place, const Vec3& onMaterial) const noexcept {
  const auto& [field, scale] = source_;
  if (field) return std::max(least_, 1 + variation_ * field->at(onMaterial).value);
  return scale ? std::max(least_, interpolated(*scale, triangle, place)) : 1;
}

FactorSample SurfaceFactor::sample(const TriangleRecord& triangle, const Vec3& place,
                                   const std::vector<Vec3f>* material, double most) const noexcept {
  FactorSample sample;
  if (source_.field) {
    FieldSample f;
    if (material == nullptr) {
      f = source_.field->at(place);
    } else {
      const TriangleMap map(cornersOf(triangle), cornersOf(triangle, material));
      f = source_.field->at(map.place(place));
      f.gradient = map.gradient(f.gradient);
    }
    sample = {1 + variation_ * f.value, variation_ * f.gradient};
  } else if (source_.scale) {
    sample = {interpolated(*source_.scale, triangle, place), gradientOf(*source_.scale, triangle)};
  }
  if (sample.value > least_ && sample.value < most) return sample;
  return {std::clamp(sample.value, std::min(least_, most), most), Vec3(0)};
}

FrictionDetail::FrictionDetail(const Friction& friction, SurfaceFactor both, SurfaceFactor own)
    : mean_{friction.mu_static, friction.mu_dynamic},
      factor_(std::move(both)),
      dynamicFactor_(std::move(own)),
      most_(mean_.stick * factor_.highest()),
      varies_(factor_.varies() || dynamicFactor_.varies()) {}

FrictionCoefficients FrictionDetail::at(const TriangleRecord& triangle, const Vec3& place,
                                        const Vec3& onMaterial) const noexcept {
  const double factor = factor_.at(triangle, place, onMaterial);
  const double stick = mean_.stick * factor;
  if (!dynamicFactor_.varies()) return {stick, mean_.slide * factor};
  return {stick, std::min(stick, mean_.slide * dynamicFactor_.at(triangle, place, onMaterial))};
}

std::shared_ptr<const SurfaceDetail> makeSurfaceDetail(const CollisionMesh& surface,
                                                       const SurfaceProperties& properties, const DetailFields& fields,
                                                       std::shared_ptr<const ShadingNormals> normals) {
  if (properties == SurfaceProperties{}) return nullptr;
  SurfaceDetail detail;
  if (const auto& shading = properties.shading) {
    detail.shading = normals ? std::move(normals)
                             : std::make_shared<const ShadingNormals>(surface, shading->crease_rad, shading->creases);
  }
  if (const auto& friction = properties.friction) {
    detail.friction.emplace(
        *friction, SurfaceFactor(friction->variation, {fields.friction, fields.frictionScale}),
        SurfaceFactor(friction->dynamicVariation, {fields.dynamicFriction, fields.dynamicFrictionScale}));
  }
  if (properties.texture) {
    detail.texture.emplace(surface, *properties.texture, fields.texture, fields.material.get());
  }
  if (const auto& map = properties.stiffnessOver) {
    detail.stiffness.emplace(map->variation, fields.stiffness, kMinStiffnessFactor);
  }
  if (const auto& map = properties.softnessOver) {
    detail.softness.emplace(map->variation, fields.softness, kMinStiffnessFactor);
  }
  const bool anyField =
      fields.texture || fields.friction || fields.dynamicFriction || fields.stiffness.field || fields.softness.field;
  if (anyField) detail.material = fields.material;
  detail.scalars = properties.scalars;
  detail.reach_m = std::max(detail.highest_m(), properties.scalars.adhesion_N > 0 ? kAdhesionReach_m : 0);
  return std::make_shared<const SurfaceDetail>(std::move(detail));
}

}  // namespace haptics
