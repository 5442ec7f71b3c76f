#pragma once

#include <vector>

#include "tests/eval/stability/tables.h"

namespace haptics::eval {

/// A plate that is held by every device that senses how it is turned, pressed and tapped on a wall with one corner first, at
/// 1 kHz as the server feels it: K_crit of its spring, with the maker's torsion, and of its torsion, with the maker's spring. Without the stabiliser too,
/// unless the scope is short.
[[nodiscard]] std::vector<Record> measureHeldTool(Scope scope, const CaseChoice& isChosen);

}  // namespace haptics::eval
