#pragma once

#include <optional>
#include <vector>

#include "common/error/error.h"
#include "common/scene/scene.h"
#include "haptics/v1/telemetry.pb.h"

namespace haptics {

/// The lattice that puts an object's vertices where they are; none: they are as the scene has them.
struct ShapeState {
  ObjectId object = 0;
  std::optional<Lattice> lattice;
};

/// The driven shapes that a sample tells of; what is none is left out.
[[nodiscard]] std::vector<ShapeState> shapesFromWire(const v1::Telemetry& message);
/// None: an empty one.
[[nodiscard]] Result<std::optional<Lattice>> announcedLatticeFrom(const v1::Lattice& message);
void toWire(const Lattice& lattice, v1::Lattice& message);

}  // namespace haptics
