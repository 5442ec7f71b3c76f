#pragma once

#include "common/error/error.h"
#include "common/scene/surface_edits.h"
#include "haptics/v1/scene.pb.h"

// Surface properties between the wire and the program. Everything is checked; how many vertices and lines the mesh has
// is for the server to compare.
namespace haptics {

/// As an edit asks for them: directions and rotations come out normalised, creases in order. Errors name the field below
/// Material ("texture.amplitude_m").
[[nodiscard]] Result<SurfaceEdit> surfaceFrom(const v1::Material& message);
/// As announced: every source is an asset, and every number is kept bit for bit. Errors name the field below ObjectState.
[[nodiscard]] Result<SurfaceProperties> surfaceFrom(const v1::ObjectState& message);
void toWire(const SurfaceProperties& properties, v1::ObjectState& message);

}  // namespace haptics
