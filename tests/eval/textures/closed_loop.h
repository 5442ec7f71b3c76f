#pragma once

#include <algorithm>
#include <functional>

#include "haptic_server/device/presets.h"
#include "tests/eval/textures/texture_sample.h"

namespace haptics::eval {

/// A device, held by a hand or not, that is pushed by just what a surface gives at some place, so that it could rest there.
/// On a texture it presses 1 N on the steepest place.
struct RestCase {
  const DevicePreset* device = nullptr;
  const HandPreset* hand = nullptr;
  double rate_Hz = 1000;
  bool clamped = true;  ///< K, to what the device can bear.
  /// What disturbs it besides a fall from 0.5 mm above: it is struck sideways to this speed.
  double strike_m_per_s = 0.01;
};

struct Rest {
  double stiffness_N_per_m = 0;  ///< Of the texture there, sideways, were K not clamped.
  double cycle_um = 0;           ///< Peak to peak of the worst axis in the last 0.3 s of 2 s, beneath the encoder.
  double allowed_um = 0;         ///< max(2 encoder steps, 20 um).
  bool steady = false;
  double away_mm = 0;  ///< From where it could have rested, in the end.
};

/// A limit cycle, peak to peak, that counts as rest.
[[nodiscard]] inline double allowedCycle_um(const DevicePreset& device) noexcept {
  return std::max(2e6 * device.resolution_m, 20.0);
}

/// Stiffness of the surface in these cases: one at which every preset rests steadily on it without texture.
inline constexpr double kRestStiffness_N_per_m = 400;

/// What feels the texture: the force (N) at a place (m) of its frame, tick by tick; and attaches it anew at one.
struct Feeler {
  std::function<Vec3(Vec3)> tick;
  std::function<void(Vec3)> place;
};
/// What it feels (N) at a place (m) below z = 0, where free space ends, once it was led down to it.
[[nodiscard]] Vec3 forceAt(const Feeler& feeler, Vec3 rest);

/// From there on: under a push (N) with which it could rest at that place.
[[nodiscard]] Rest restOn(const Feeler& feeler, Vec3 rest, Vec3 push_N, const RestCase& of);
[[nodiscard]] Rest restOn(const Feeler& feeler, const TextureCase& textureCase, const std::optional<Texture>& texture,
                          const RestCase& of);

/// By the production step with the server's stabiliser. @param texture  None: the plain surface.
[[nodiscard]] Rest restOn(const TextureCase& textureCase, const std::optional<Texture>& texture, const RestCase& of);

}  // namespace haptics::eval
