#pragma once

#include <functional>
#include <vector>

#include "tests/eval/report.h"
#include "tests/eval/stability/critical.h"

namespace haptics::eval {

/// How much is measured.
enum class Scope { kShort, kCoarse, kFull };

/// Which cases of a table to measure; gets each one's number, and how many there are.
using CaseChoice = std::function<bool(std::size_t at, std::size_t of)>;

/// What ours must bear at 1 kHz with no hand and the light hand, up to one period of delay.
inline constexpr double kRequired_N_per_m = 10e3;
/// As a multiple of the maker's stiffness, also where the device is not as the data sheet says and its delay not as told.
inline constexpr double kRequiredMargin = 3;

/// K_crit of the wall by method, device, hand, rate and delay.
[[nodiscard]] std::vector<Record> measureCritical(Scope scope, const CaseChoice& isChosen);
/// Largest stiffness against rendered damping.
[[nodiscard]] std::vector<Record> measureZWidth(Scope scope, const CaseChoice& isChosen);
/// Ours on other grounds than a wall.
[[nodiscard]] std::vector<Record> measureGrounds(Scope scope, const CaseChoice& isChosen);
/// Ours with a device, or a delay, that is not what it is told.
[[nodiscard]] std::vector<Record> measureRobustness(Scope scope, const CaseChoice& isChosen);

}  // namespace haptics::eval
