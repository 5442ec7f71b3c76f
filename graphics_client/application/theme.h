#pragma once

class QColor;
class QPalette;

namespace haptics {

/// Whether the user has chosen dark panels.
[[nodiscard]] bool isDarkChosen();
/// Of all windows, now and in later runs.
void chooseDark(bool on);
/// As chosen; where nothing was, as the desktop has it.
void applyTheme();

/// Of words about an error, on the ground of a window.
[[nodiscard]] QColor errorColor(const QPalette& palette);

}  // namespace haptics
