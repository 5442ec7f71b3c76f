#pragma once

#include <QString>
#include <chrono>
#include <memory>

#include "graphics_client/mirror/server_link.h"

namespace haptics {

/// What there is to say of the server's watchdog, which is asked for every few seconds.
class WatchdogWords {
 public:
  explicit WatchdogWords(ServerLink& link);

  /// Logged too, once. Empty: it is there and was started once; the device has none; or nothing is known yet.
  [[nodiscard]] QString words(const MirrorView& view);

 private:
  struct Said;

  ServerLink& link_;
  std::shared_ptr<Said> said_;
  std::chrono::steady_clock::time_point asked_;
  QString logged_;
};

}  // namespace haptics
