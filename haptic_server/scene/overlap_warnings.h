#pragma once

#include <span>
#include <string>
#include <vector>

#include "common/scene/scene.h"
#include "haptic_server/scene/object_assets.h"

namespace haptics {

/// An object of a scene, as an edit leaves it.
struct PlacedObject {
  const ObjectRecord* record = nullptr;
  const ObjectAssets* assets = nullptr;
  bool isPut = false;  ///< By this edit, to where its record has it; else only what does not move is known to be there.
};

/// A line for each two objects that meet, one of which is put into the other by more than 0.1 mm: "NAME: warning: ...". At
/// most kMaxOverlapWarnings of them. The search looks at some points of each pair, and ends after a bounded number of
/// triangles: of what it has not come to by then there is no line.
[[nodiscard]] std::vector<std::string> overlapWarnings(std::span<const PlacedObject> objects);

inline constexpr std::size_t kMaxOverlapWarnings = 8;

}  // namespace haptics
