#include "common/surface/scalar_field.h"

namespace haptics {
namespace {

/// Fraction of the shortest wavelength: short enough for the third derivatives' share, long enough for rounding's.
constexpr double kDifferenceStep = 1e-4;

Vec3 anyTangent(Vec3 normal) noexcept {
  const Vec3 across = std::abs(normal.x) < 0.5 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
  return glm::normalize(glm::cross(normal, across));
}

}  // namespace

FieldShape shapeAround(const ScalarField& field, Vec3 point, Vec3 normal) noexcept {
  const Vec3 tangents[2] = {anyTangent(normal), glm::cross(normal, anyTangent(normal))};
  const auto along = [&tangents](Vec3 v) { return glm::dvec2(glm::dot(v, tangents[0]), glm::dot(v, tangents[1])); };
  const double step = kDifferenceStep * field.shortestWavelength_m();

  const FieldSample here = field.at(point);
  FieldShape shape{here.value, along(here.gradient), glm::dmat2(0)};
  for (int i = 0; i < 2; ++i) {
    const Vec3 change = field.at(point + step * tangents[i]).gradient - field.at(point - step * tangents[i]).gradient;
    shape.curvature[i] = along(change) / (2 * step);
  }
  shape.curvature = 0.5 * (shape.curvature + glm::transpose(shape.curvature));
  return shape;
}

}  // namespace haptics
