#pragma once

#include "tests/eval/combinations/pair.h"
#include "tests/eval/methods.h"
#include "tests/eval/random.h"

namespace haptics::eval {

/// Two features of one body: a stroke, and a closed loop where one is asked for.
/// @param guest  In place of the production step; null: that. Friction then does not vary over the surface.
[[nodiscard]] PairResult runSolo(Feature a, Feature b, Ablation ablation, Random random, const Method* guest);

/// A feature of bodies that hold the IHIP in their groove; a guest's bodies are alike.
[[nodiscard]] PairResult runGroove(Feature feature, Ablation ablation, Random random, const Method* guest);

}  // namespace haptics::eval
