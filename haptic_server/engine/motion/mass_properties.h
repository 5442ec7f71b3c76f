#pragma once

#include <cstdint>

#include "common/maths/vec.h"

namespace haptics {

/// Mass, and how it is spread. The axes in which the inertia is diagonal are the frame in which motion is computed.
struct MassProperties {
  double mass_kg = 1;
  Vec3 centre{0};              ///< Of mass; object frame, m.
  Quat principal{1, 0, 0, 0};  ///< Principal axes to object frame.
  Vec3 moments{1};             ///< About the centre, along the principal axes, kg m^2.
};

enum class MassDefect : std::uint8_t {
  kNone,
  kMass,     ///< Not finite and > 0.
  kCentre,   ///< Not finite.
  kInertia,  ///< Not finite, not symmetric, or a principal moment not > 0.
  kBeyond,   ///< A principal moment is more than the other two together: no distribution of mass has that inertia.
};

/// Diagonalises an inertia (object's axes, about the centre, kg m^2).
/// @param[out] properties  Written when there is no defect.
[[nodiscard]] MassDefect spreadMass(double mass_kg, Vec3 centre, const glm::dmat3& inertia, MassProperties& properties);

}  // namespace haptics
