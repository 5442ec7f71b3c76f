#pragma once

#include <QString>
#include <string>

#include "common/text/printable.h"

namespace haptics {

/// What another party wrote, for a label: printable().
[[nodiscard]] inline QString text(const std::string& untrusted) { return QString::fromStdString(printable(untrusted)); }

}  // namespace haptics
