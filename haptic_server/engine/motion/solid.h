#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "common/maths/vec.h"

namespace haptics {

enum class SolidDefect : std::uint8_t {
  kNone,
  kOpen,       ///< Triangles' sides do not cancel: what is inside is not defined.
  kInsideOut,  ///< Closed, with a negative volume: the triangles are wound clockwise seen from outside.
  kFlat,       ///< Closed, with no volume beyond rounding.
};

/// What a closed mesh encloses, filled with density 1 kg/m^3. Object frame, SI units; meaningless with a defect.
struct Solid {
  SolidDefect defect = SolidDefect::kNone;
  std::uint64_t openSides = 0;  ///< Of triangles, that no other triangle's side cancels.
  double volume_m3 = 0;
  Vec3 centre{0};         ///< Of mass.
  glm::dmat3 inertia{0};  ///< About the centre.
};

/// Volume integrals by signed tetrahedra (Tonon 2004), one for each triangle, all with one common corner. They do not
/// depend on that corner exactly when the triangles' directed sides cancel, which is what is tested: meshes of several
/// parts and lines of four triangles are closed too. Where parts overlap, what is inside counts once for each.
/// Off the servo's thread: sorts and allocates.
/// \param sidesCancel  That is known, and not looked for.
[[nodiscard]] Solid solidOf(std::span<const Vec3f> vertices, std::span<const std::array<std::uint32_t, 3>> triangles,
                            bool sidesCancel = false);

}  // namespace haptics
