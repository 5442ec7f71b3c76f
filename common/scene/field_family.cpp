#include <string>

#include "common/scene/surface_properties.h"

namespace haptics {

// Not within the class: clang 14 does not end where a variant is compared within one of its own alternatives.
bool FieldLayer::operator==(const FieldLayer&) const = default;
bool LayeredFamily::operator==(const LayeredFamily&) const = default;

std::string layerField(std::size_t layer) { return "layers.layer[" + std::to_string(layer) + "].field."; }

}  // namespace haptics
