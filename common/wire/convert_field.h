#pragma once

#include <vector>

#include "common/error/error.h"
#include "common/scene/surface_edits.h"
#include "haptics/v1/scene.pb.h"

// Scalar fields between the wire and the program. Everything is checked, and every number kept bit for bit.
namespace haptics {

/// A family, and where the field of each mapped or grown one in it comes from (whose hash is in place when that is an
/// asset).
struct FieldEdit {
  FieldFamily family;
  std::vector<FamilySource> sources;
};

/// Errors name the field below ScalarField ("noise.wavelength_m").
[[nodiscard]] Result<FieldEdit> fieldFrom(const v1::ScalarField& message);
/// Directions and rotations to unit length.
void normalise(FieldFamily& family);
void toWire(const FieldFamily& family, v1::ScalarField& message);

}  // namespace haptics
