#pragma once

#include <optional>
#include <string>

namespace haptics {

/// Draws "making soup [#####     ] 40 %" over itself on standard error, if that is a terminal; without a share a bar that
/// only says that something is going on.
/// \param what   Printable, before the bar.
/// \param after  Printable, behind it.
void showProgress(const std::string& what, std::optional<double> share, const std::string& after = {});
/// The line is done.
void endProgress();

}  // namespace haptics
