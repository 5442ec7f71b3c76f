#pragma once

#include <functional>
#include <memory>

#include "common/scene/surface_properties.h"
#include "common/surface/sampled_field.h"

namespace haptics::eval {

/// Value of a field at a point (object frame, m).
using Reference = std::function<double(Vec3)>;

/// The same field as makeField() makes, evaluated another way: from its definition, in no hurry, with nothing of the
/// production code but the random numbers and the samples that the field is made of.
///
/// - Fourier: real parts of complex exponentials.
/// - Noise, grain: one sum over the corners of a cell, each with the product of its three weights.
/// - Cellular: all points of the 125 cells around, not of 27.
/// - Mapped on a plane: a spline whose coefficients come from a division of spectra, evaluated by the recursion of
///   Cox and de Boor. Other intermediate surfaces are not offered: std::invalid_argument.
[[nodiscard]] Reference referenceOf(const FieldFamily& family, std::shared_ptr<const SampledField> sampled);

}  // namespace haptics::eval
