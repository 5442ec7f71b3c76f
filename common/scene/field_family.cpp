#include <string>

#include "common/scene/surface_properties.h"

namespace haptics {

// Not within the class: clang 14 does not end where a variant is compared within one of its own alternatives.
FieldFamily::FieldFamily() noexcept = default;
FieldFamily::FieldFamily(const FieldFamily&) = default;
FieldFamily::FieldFamily(FieldFamily&&) noexcept = default;
FieldFamily& FieldFamily::operator=(const FieldFamily&) = default;
FieldFamily& FieldFamily::operator=(FieldFamily&&) noexcept = default;
FieldFamily::~FieldFamily() = default;
bool FieldFamily::operator==(const FieldFamily& other) const {
  return static_cast<const variant&>(*this) == static_cast<const variant&>(other);
}

FactorMap::FactorMap() noexcept = default;
FactorMap::FactorMap(const FactorMap&) = default;
FactorMap::FactorMap(FactorMap&&) noexcept = default;
FactorMap& FactorMap::operator=(const FactorMap&) = default;
FactorMap& FactorMap::operator=(FactorMap&&) noexcept = default;
FactorMap::~FactorMap() = default;
bool FactorMap::operator==(const FactorMap& other) const {
  return static_cast<const variant&>(*this) == static_cast<const variant&>(other);
}

bool FieldLayer::operator==(const FieldLayer&) const = default;
bool LayeredFamily::operator==(const LayeredFamily&) const = default;

std::string layerField(std::size_t layer) { return "layers.layer[" + std::to_string(layer) + "].field."; }

}  // namespace haptics
