#pragma once

#include <span>
#include <vector>

#include "tests/eval/advise/loaded_scene.h"

namespace haptics::eval {

/// What a hand would do with an object: places of the HIP (world, m), one to each millisecond at 0.1 m/s.
struct HandStroke {
  std::vector<Vec3> down;    ///< From above the surface to where the stroke begins.
  std::vector<Vec3> stroke;  ///< As deep as 1 N presses into a surface that faces up.
  std::vector<Vec3> up;

  [[nodiscard]] std::vector<Vec3> places() const;  ///< All, in turn.
};

/// Along the object's upper side, as the simulated hand of the server would choose it if the object stood alone, in
/// three directions. Empty when it cannot be reached from above.
[[nodiscard]] std::vector<HandStroke> strokesOver(const LoadedObject& object);
/// The same in other directions.
/// @param turns_rad  About the vertical.
/// @param press_N  Decides the depth.
[[nodiscard]] std::vector<HandStroke> strokesOver(const LoadedObject& object, std::span<const double> turns_rad,
                                                  double press_N);

}  // namespace haptics::eval
