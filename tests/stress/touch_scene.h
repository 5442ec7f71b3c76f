#pragma once

#include <string>

#include "haptics/v1/scene.pb.h"

// What the viewers of a touched scene see: a soft ball of which a dent takes some 5,000 vertices, bodies on springs that the
// hand pushes and that come back, a soft bar that a lattice bends in the end.
namespace haptics::stress {

[[nodiscard]] std::string touchedSceneText();

/// Nothing below it can be reached from above: the simulated hand lets go of all, and the scene comes to rest.
[[nodiscard]] v1::Transaction roof();

/// The bar's top is moved by so much along x and y (m), and its sides with it.
[[nodiscard]] v1::Transaction bend(double x_m, double y_m);

}  // namespace haptics::stress
