#include "haptic_server/surface/surface_detail.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/maths/barycentric.h"

namespace haptics {
namespace {

/// Places at which the height is sampled. More find a steeper one on a large surface.
constexpr std::uint32_t kSamples = 4096;

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

/// Of a symmetric matrix of two.
[[nodiscard]] double largestEigenvalue(const glm::dmat2& m) {
  const double mean = (m[0][0] + m[1][1]) / 2;
  return mean + std::hypot((m[0][0] - m[1][1]) / 2, m[0][1]);
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

TextureDetail::TextureDetail(const Surface& surface, const Texture& texture, std::shared_ptr<const ScalarField> field,
                             const std::vector<Vec3f>* material)
    : field_(std::move(field)),
      law_(texture.law),
      amplitude_m_(texture.amplitude_m),
      zero_(texture.literal ? 0 : field_->lowest()),
      gain_(texture.gain_K),
      highest_m_(amplitude_m_ * (field_->highest() - zero_)) {
  const std::uint32_t count = surface.triangleCount();
  for (std::uint32_t i = 0; i < kSamples; ++i) {
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

Relief TextureDetail::at(Vec3 place) const noexcept {
  const FieldSample f = field_->at(place);
  return {amplitude_m_ * (f.value - zero_), amplitude_m_ * f.gradient};
}

double TextureDetail::gainFor(double stiffness_N_per_m, double most_N_per_m) const noexcept {
  const double lateral = stiffness_N_per_m * steepness_;
  return gain_ * lateral > most_N_per_m ? most_N_per_m / lateral : gain_;
}

FrictionFactor::FrictionFactor(double variation, std::shared_ptr<const ScalarField> field,
                               std::shared_ptr<const std::vector<float>> scale)
    : variation_(variation), field_(std::move(field)), scale_(std::move(scale)) {}

double FrictionFactor::highest() const noexcept {
  if (scale_) return scale_->empty() ? 0 : *std::ranges::max_element(*scale_);
  if (!field_) return 1;
  return std::max({0.0, 1 + variation_ * field_->lowest(), 1 + variation_ * field_->highest()});
}

double FrictionFactor::at(const TriangleRecord& triangle, const Vec3& place, const Vec3& onMaterial) const noexcept {
  if (field_) return std::max(0.0, 1 + variation_ * field_->at(onMaterial).value);
  if (!scale_) return 1;
  const Vec3 share = glm::max(barycentric(triangle.corner(0), triangle.corner(1), triangle.corner(2), place), Vec3(0));
  double sum = 0;
  for (int k = 0; k < 3; ++k) sum += share[k] * static_cast<double>((*scale_)[triangle.vertexAt(k)]);
  return sum / (share.x + share.y + share.z);
}

FrictionDetail::FrictionDetail(const Friction& friction, FrictionFactor both, FrictionFactor own)
    : mean_{friction.mu_static, friction.mu_dynamic},
      factor_(std::move(both)),
      dynamicFactor_(std::move(own)),
      most_(mean_.stick * factor_.highest()) {}

FrictionCoefficients FrictionDetail::at(const TriangleRecord& triangle, const Vec3& place,
                                        const Vec3& onMaterial) const noexcept {
  const double factor = factor_.at(triangle, place, onMaterial);
  const double stick = mean_.stick * factor;
  if (!dynamicFactor_.varies()) return {stick, mean_.slide * factor};
  return {stick, std::min(stick, mean_.slide * dynamicFactor_.at(triangle, place, onMaterial))};
}

std::shared_ptr<const SurfaceDetail> makeSurfaceDetail(const Surface& surface, const SurfaceProperties& properties,
                                                       const DetailFields& fields,
                                                       std::shared_ptr<const ShadingNormals> normals) {
  if (properties == SurfaceProperties{}) return nullptr;
  SurfaceDetail detail;
  if (const auto& shading = properties.shading) {
    detail.shading = normals ? std::move(normals)
                             : std::make_shared<const ShadingNormals>(surface, shading->crease_rad, shading->creases);
  }
  if (const auto& friction = properties.friction) {
    detail.friction.emplace(
        *friction, FrictionFactor(friction->variation, fields.friction, fields.frictionScale),
        FrictionFactor(friction->dynamicVariation, fields.dynamicFriction, fields.dynamicFrictionScale));
  }
  if (properties.texture) {
    detail.texture.emplace(surface, *properties.texture, fields.texture, fields.material.get());
  }
  if (fields.texture || fields.friction || fields.dynamicFriction) detail.material = fields.material;
  return std::make_shared<const SurfaceDetail>(std::move(detail));
}

}  // namespace haptics
