#pragma once

#include "haptic_server/engine/contact/fast_path/triangle_cache.h"

namespace haptics {

/// What the ticks of one contact need not compute again; its caller owns it. Follows from the meshes alone: to drop it
/// at any time costs time, but changes no bit of any result. It has to be cleared before a mesh ends, as another one
/// may come to be in its place.
struct ContactCache {
  CachedTriangle polygon;                ///< Of the last tick that ended on one, unless `ahead` held that.
  const TriangleCache* ahead = nullptr;  ///< Polygons computed ahead of the tick; may be null.
};

}  // namespace haptics
