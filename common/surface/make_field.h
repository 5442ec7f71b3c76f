#pragma once

#include <functional>
#include <memory>

#include "common/error/error.h"
#include "common/scene/surface_properties.h"
#include "common/surface/point_field.h"
#include "common/surface/sampled_field.h"
#include "common/surface/scalar_field.h"

namespace haptics {

/// The sampled field of that content, or null.
using FieldLookup = std::function<std::shared_ptr<const SampledField>(const ContentHash&)>;
/// The same for point fields.
using PointFieldLookup = std::function<std::shared_ptr<const PointField>(const ContentHash&)>;

/// The field that a record describes, as server and viewer evaluate it. The record's numbers have been checked
/// (common/wire). Takes up to a tenth of a second. Refused: a sampled field or a point field that the lookups do not
/// know; without the second lookup, every point field.
[[nodiscard]] Result<std::shared_ptr<const ScalarField>> makeField(const FieldFamily& family, const FieldLookup& lookup,
                                                                   const PointFieldLookup& pointLookup = {});

}  // namespace haptics
