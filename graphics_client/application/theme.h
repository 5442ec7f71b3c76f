#pragma once

namespace haptics {

/// Whether the user has chosen dark panels.
[[nodiscard]] bool isDarkChosen();
/// Of all windows, now and in later runs.
void chooseDark(bool on);
/// As chosen; where nothing was, as the desktop has it.
void applyTheme();

}  // namespace haptics
