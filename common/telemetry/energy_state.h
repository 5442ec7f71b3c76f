#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <type_traits>

#include "common/maths/fields.h"

namespace haptics {

/// Sources and sinks of the hand's energy. Values are one less than those of the wire's enum (telemetry.proto).
enum class EnergyFeature : std::uint8_t {
  kContact = 0,  ///< Spring and damper, as sampled and held: what is left when the others are taken off.
  kShading = 1,
  kFriction = 2,
  kTexture = 3,
  kMotion = 4,  ///< Work of a moving body's surface on the hand that touches it.
  kEdit = 5,    ///< Of an adopted edit under the stylus: what it put into the spring, or did by moving the surface.
  kWrench = 6,  ///< What a client added (AddedWrench): of no object.
};
inline constexpr std::size_t kEnergyFeatures = 7;

/// Joules given to the hand since the servo started, by feature: together the work of the force as written.
using EnergyByFeature = std::array<double, kEnergyFeatures>;

/// Energy that one object gave.
struct ObjectEnergy {
  std::uint64_t object = 0;
  EnergyByFeature given_J{};
  HAPTICS_FIELDS(self.object, self.given_J);

  [[nodiscard]] double& of(EnergyFeature feature) noexcept { return given_J[static_cast<std::size_t>(feature)]; }
  [[nodiscard]] double of(EnergyFeature feature) const noexcept { return given_J[static_cast<std::size_t>(feature)]; }
  /// Energy of the largest source; negative when no source gave any.
  [[nodiscard]] double largest_J() const noexcept { return *std::ranges::max_element(given_J); }
};

/// Energies of at most kMax touched objects: the last one, and those of the others that gave most.
struct EnergyState {
  static constexpr std::size_t kMax = 8;

  std::size_t objectCount = 0;
  std::array<ObjectEnergy, kMax> object{};

  [[nodiscard]] std::span<const ObjectEnergy> objects() const noexcept { return std::span(object).first(objectCount); }
};
static_assert(std::is_trivially_copyable_v<EnergyState>, "crosses threads by copy");

/// The object and feature that give the hand most energy.
struct EnergySource {
  std::uint64_t object = 0;
  EnergyFeature feature = EnergyFeature::kContact;
  double given_J = 0;

  bool operator==(const EnergySource&) const = default;
};

/// The feature, of an object, that gave most; nothing where none gave any.
[[nodiscard]] inline std::optional<EnergySource> largestSource(const EnergyState& state) noexcept {
  std::optional<EnergySource> largest;
  for (const ObjectEnergy& object : state.objects()) {
    for (std::size_t i = 0; i < kEnergyFeatures; ++i) {
      if (object.given_J[i] <= (largest ? largest->given_J : 0)) continue;
      largest = EnergySource{object.object, static_cast<EnergyFeature>(i), object.given_J[i]};
    }
  }
  return largest;
}

[[nodiscard]] constexpr const char* nameOf(EnergyFeature feature) noexcept {
  constexpr std::array kNames{"contact", "shading", "friction", "texture", "motion", "edit", "wrench"};
  static_assert(kNames.size() == kEnergyFeatures);
  return kNames[static_cast<std::size_t>(feature)];
}

}  // namespace haptics
