#include "haptic_server/scene/scene_limits.h"

#include <variant>

namespace haptics {

std::size_t wireSizeOf(const SurfaceProperties& surface) {
  constexpr std::size_t kTerm_bytes = 64, kCrease_bytes = 16;
  const auto ofField = [](const FieldFamily& family) {
    const auto* fourier = std::get_if<FourierFamily>(&family);
    return fourier ? kTerm_bytes * fourier->terms.size() : 0;
  };
  std::size_t bytes = 0;
  if (surface.shading) bytes += kCrease_bytes * surface.shading->creases.size();
  if (surface.texture) bytes += ofField(surface.texture->family);
  if (!surface.friction) return bytes;
  const auto* field = std::get_if<FieldFamily>(&surface.friction->over);
  return field ? bytes + ofField(*field) : bytes;
}

}  // namespace haptics
