#pragma once

#include <cstdint>
#include <vector>

#include "common/error/error.h"
#include "common/scene/surface_properties.h"
#include "common/surface/make_field.h"
#include "haptics/v1/scene.pb.h"

namespace haptics {

/// A square patch of a texture as a height map that is lit from the upper left: shades of grey, row by row from the top.
/// Evaluated as server and viewer do; a mapped field's tile on a plane, a grown pattern on a plate. Any thread: takes up
/// to some tenths of a second.
/// @param field  As an edit asks for it; no image below the server's asset folders.
[[nodiscard]] Result<std::vector<std::uint8_t>> texturePreview(const v1::ScalarField& field, int side_px);
/// Of a record; a mapped field as the image that it is. Refused: sampled fields that the lookup does not know, and a grown pattern, whose mesh it lies on.
[[nodiscard]] Result<std::vector<std::uint8_t>> texturePreview(const FieldFamily& family, const FieldLookup& lookup,
                                                               int side_px);

}  // namespace haptics
