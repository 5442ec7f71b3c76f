#include "common/surface/layered_field.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace haptics {
namespace {

using Combination = LayeredFamily::Combination;

FieldBounds times(double weight, FieldBounds bounds) {
  bounds.lowest *= weight;
  bounds.highest *= weight;
  if (weight < 0) std::swap(bounds.lowest, bounds.highest);
  bounds.slope_per_m *= std::abs(weight);
  bounds.curvature_per_m2 *= std::abs(weight);
  return bounds;
}

FieldBounds sum(const FieldBounds& a, const FieldBounds& b) {
  return {a.lowest + b.lowest, a.highest + b.highest, a.slope_per_m + b.slope_per_m,
          a.curvature_per_m2 + b.curvature_per_m2};
}

FieldBounds product(const FieldBounds& a, const FieldBounds& b) {
  const auto [lowest, highest] =
      std::minmax({a.lowest * b.lowest, a.lowest * b.highest, a.highest * b.lowest, a.highest * b.highest});
  const double mostA = std::max(-a.lowest, a.highest), mostB = std::max(-b.lowest, b.highest);
  return {lowest, highest, a.slope_per_m * mostB + mostA * b.slope_per_m,
          a.curvature_per_m2 * mostB + 2 * a.slope_per_m * b.slope_per_m + mostA * b.curvature_per_m2};
}

FieldBounds boundsOf(Combination combination, const std::vector<LayeredField::Layer>& layers) {
  const bool isSum = combination == Combination::kSum;
  FieldBounds bounds = isSum ? FieldBounds{} : FieldBounds{1, 1, 0, 0};
  for (const auto& [weight, field] : layers) {
    const FieldBounds weighted = times(weight, field->bounds());
    bounds = isSum ? sum(bounds, weighted) : product(bounds, weighted);
  }
  return bounds;
}

double shortestWavelengthOf(Combination combination, const std::vector<LayeredField::Layer>& layers) {
  double perMetre = 0;
  for (const auto& [weight, field] : layers) {
    const double own = 1 / field->shortestWavelength_m();
    perMetre = combination == Combination::kSum ? std::max(perMetre, own) : perMetre + own;
  }
  return 1 / perMetre;
}

}  // namespace

LayeredField::LayeredField(Combination combination, std::vector<Layer> layers)
    : ScalarField(boundsOf(combination, layers), shortestWavelengthOf(combination, layers)),
      combination_(combination),
      layers_(std::move(layers)) {}

FieldSample LayeredField::at(Vec3 point) const noexcept {
  if (combination_ == Combination::kSum) {
    FieldSample sum;
    for (const auto& [weight, field] : layers_) {
      const FieldSample layer = field->at(point);
      sum.value += weight * layer.value;
      sum.gradient += weight * layer.gradient;
    }
    return sum;
  }
  FieldSample product{1, Vec3(0)};
  for (const auto& [weight, field] : layers_) {
    const FieldSample layer = field->at(point);
    product.gradient = weight * (layer.value * product.gradient + product.value * layer.gradient);
    product.value *= weight * layer.value;
  }
  return product;
}

}  // namespace haptics
