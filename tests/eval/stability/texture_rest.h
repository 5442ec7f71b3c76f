#pragma once

#include <vector>

#include "tests/eval/stability/tables.h"

namespace haptics::eval {

/// Every texture family under every device in the light hand, at 1 kHz as the server feels it: does it rest on the steepest
/// place, struck as by a slow stroke that stops?
[[nodiscard]] std::vector<Record> measureTextureRest(Scope scope, const CaseChoice& isChosen);

}  // namespace haptics::eval
