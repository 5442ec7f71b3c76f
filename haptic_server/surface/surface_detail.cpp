#include "haptic_server/surface/surface_detail.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace haptics {
namespace {

/// Places at which the height is sampled. More find a steeper one on a large surface.
constexpr std::uint32_t kSamples = 4096;

/// Spread evenly over the polygons and over each (the R2 sequence of M. Roberts, 2018).
[[nodiscard]] Vec3 samplePlace(const TriangleRecord& r, std::uint32_t i) {
  double u = std::fmod(0.5 + 0.7548776662466927 * i, 1.0);
  double v = std::fmod(0.5 + 0.5698402909980532 * i, 1.0);
  if (u + v > 1) {
    u = 1 - u;
    v = 1 - v;
  }
  const Vec3 a = r.corner(0);
  return a + (r.corner(1) - a) * u + (r.corner(2) - a) * v;
}

/// Of a symmetric matrix of two.
[[nodiscard]] double largestEigenvalue(const glm::dmat2& m) {
  const double mean = (m[0][0] + m[1][1]) / 2;
  return mean + std::hypot((m[0][0] - m[1][1]) / 2, m[0][1]);
}

}  // namespace

TextureDetail::TextureDetail(const Surface& surface, const Texture& texture, std::shared_ptr<const ScalarField> field)
    : field_(std::move(field)),
      law_(texture.law),
      amplitude_m_(texture.amplitude_m),
      zero_(texture.literal ? 0 : field_->lowest()),
      gain_(texture.gain_K),
      highest_m_(amplitude_m_ * (field_->highest() - zero_)) {
  const std::uint32_t count = surface.triangleCount();
  for (std::uint32_t i = 0; i < kSamples; ++i) {
    const auto t = static_cast<std::uint32_t>(std::uint64_t{count} * i / kSamples);
    const FieldShape shape = shapeAround(*field_, samplePlace(surface.triangle(t), i), surface.faceNormal(t));
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

FrictionDetail::FrictionDetail(const Friction& friction, std::shared_ptr<const ScalarField> field,
                               std::shared_ptr<const std::vector<float>> scale)
    : mean_{friction.mu_static, friction.mu_dynamic},
      variation_(friction.variation),
      field_(std::move(field)),
      scale_(std::move(scale)) {
  double most = 1;
  if (scale_) {
    most = scale_->empty() ? 0 : *std::ranges::max_element(*scale_);
  } else if (field_) {
    most = std::max(1 + variation_ * field_->lowest(), 1 + variation_ * field_->highest());
  }
  most_ = mean_.stick * std::max(most, 0.0);
}

double FrictionDetail::factorAt(const Surface& surface, std::uint32_t t, Vec3 place) const noexcept {
  if (field_) return std::max(0.0, 1 + variation_ * field_->at(place).value);
  if (!scale_) return 1;
  const TriangleRecord& r = surface.triangle(t);
  const Vec3 a = r.corner(0);
  const Vec3 normal = r.areaNormal();
  const double whole = squaredLength(normal);
  const auto scaleOf = [&](int k) { return static_cast<double>((*scale_)[r.vertexAt(k)]); };
  if (!(whole > 0)) return scaleOf(0);
  const double u = std::clamp(glm::dot(glm::cross(place - a, r.corner(2) - a), normal) / whole, 0.0, 1.0);
  const double v = std::clamp(glm::dot(glm::cross(r.corner(1) - a, place - a), normal) / whole, 0.0, 1.0 - u);
  return (1 - u - v) * scaleOf(0) + u * scaleOf(1) + v * scaleOf(2);
}

FrictionCoefficients FrictionDetail::at(const Surface& surface, std::uint32_t t, Vec3 place) const noexcept {
  const double factor = factorAt(surface, t, place);
  return {mean_.stick * factor, mean_.slide * factor};
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
  if (properties.friction) detail.friction.emplace(*properties.friction, fields.friction, fields.frictionScale);
  if (properties.texture) detail.texture.emplace(surface, *properties.texture, fields.texture);
  return std::make_shared<const SurfaceDetail>(std::move(detail));
}

}  // namespace haptics
