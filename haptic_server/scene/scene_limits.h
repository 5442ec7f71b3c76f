#pragma once

#include <cstddef>

#include "common/scene/surface_properties.h"

namespace haptics {

/// Canonical bytes of all assets of a scene together: 28 million triangles, of which the server makes some 4 GB. Whoever may
/// edit cannot fill the memory.
inline constexpr std::size_t kMaxSceneAssets_bytes = 512U << 20;

/// Of the Fourier terms and named creases of a scene, on the wire: a snapshot and a commit of all objects then fit what a
/// connection takes at once.
inline constexpr std::size_t kMaxSceneSurfaces_bytes = 512U << 10;

/// What of an object's surface grows, about as it is on the wire: its Fourier terms and creases.
[[nodiscard]] std::size_t wireSizeOf(const SurfaceProperties& surface);

}  // namespace haptics
