#pragma once

#include <vector>

#include "tests/eval/stability/tables.h"

namespace haptics::eval {

/// Presses with the light hand at the maker's stiffness, strokes along the surface, lifts: how far the force is from that
/// of the spring at the true place, by method, and whether it pulls when the hand leaves.
[[nodiscard]] std::vector<Record> measureFidelity(Scope scope, const CaseChoice& isChosen);

/// The same strokes, and a push in nobody's hand: the least that the virtual environment and the device's own damper have
/// taken from the hand, E_VE + sum of b v^2 T, on wall, edge, sphere, and with friction. A held wall alone always gives
/// some back, half of K step^2 each time.
[[nodiscard]] std::vector<Record> measureEnergy(Scope scope, const CaseChoice& isChosen);

}  // namespace haptics::eval
