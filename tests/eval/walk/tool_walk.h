#pragma once

#include <filesystem>

#include "tests/eval/walk/walk.h"

namespace haptics::eval {

/// Tools of 1,000 to 2,000 points, an ellipsoid and a bar, that wander over the closed shapes and models at up to 1 m/s and
/// 10 rad/s, through the whole step, with the allowance of a tick at 1 kHz. Judged by code that shares nothing with the
/// contact core: is a point of the tool inside a body, or a sharp point of a body inside the tool (rays over triangles
/// without connectivity; all of them in every kToolJudgedEvery-th tick). In every tick: is anything not finite, does the
/// tick spend more than its allowance, do spring and torsion together hold more energy than the hand's motion can have
/// given them, and is a step of the torque one that the same tick in many parts makes too. Its finish() writes
/// DIR/walk.json, and says whether every walk passed. Of `options`, `method` is not used. Throws as makeWalkSweep() does.
[[nodiscard]] std::unique_ptr<Sweep> makeToolWalkSweep(const WalkOptions& options, const std::filesystem::path& out);

inline constexpr int kToolJudgedEvery = 23;

}  // namespace haptics::eval
