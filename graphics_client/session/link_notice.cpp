#include "graphics_client/session/link_notice.h"

#include "common/text/printable.h"

namespace haptics {

LinkNotice noticeOf(const MirrorView& view) {
  const std::string text = printable(view.linkText);
  switch (view.link) {
    case LinkState::kLive:
    case LinkState::kSyncing:
      return {};
    case LinkState::kRefused:
      return {text, true};
    case LinkState::kClosed:
      return {"Not connected to a server", false};
    case LinkState::kConnecting:
      break;
  }
  if (view.connections > 0)
    return {"The server is gone; trying again. Edits wait until it is back. (" + text + ")", false};
  if (text.starts_with("connecting to ")) return {};
  return {"No server answers; trying again. (" + text + ")", false};
}

}  // namespace haptics
