#pragma once

#include "tests/eval/combinations/pair.h"
#include "tests/eval/random.h"

namespace haptics::eval {

/// Two features of one body: a stroke, and a closed loop where one is asked for.
[[nodiscard]] PairResult runSolo(Feature a, Feature b, Ablation ablation, Random random);

/// A feature of bodies that hold the IHIP in their groove.
[[nodiscard]] PairResult runGroove(Feature feature, Ablation ablation, Random random);

}  // namespace haptics::eval
