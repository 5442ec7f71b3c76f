#pragma once

#include <string>

#include "graphics_client/mirror/mirror_view.h"

namespace haptics {

/// What a person has to be told of the connection.
struct LinkNotice {
  std::string text;        ///< Empty: nothing.
  bool isRefusal = false;  ///< Nothing changes until the person does something.

  bool operator==(const LinkNotice&) const = default;
};

/// Nothing is said of a link that is live, or that makes its first attempt.
[[nodiscard]] LinkNotice noticeOf(const MirrorView& view);

}  // namespace haptics
