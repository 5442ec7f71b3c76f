#pragma once

#include <sys/types.h>

#include <memory>

#include "common/error/error.h"

namespace haptics::eval {

/// An X display to draw on: that of the session, or an Xvfb of our own while this lives.
class VirtualDisplay {
 public:
  /// Sets DISPLAY where it was not set. Refused where there is no display and Xvfb cannot be started.
  [[nodiscard]] static Result<std::unique_ptr<VirtualDisplay>> ensure();
  ~VirtualDisplay();
  VirtualDisplay(const VirtualDisplay&) = delete;
  VirtualDisplay& operator=(const VirtualDisplay&) = delete;

 private:
  explicit VirtualDisplay(pid_t server) : server_(server) {}
  pid_t server_;  // 0: the session's
};

}  // namespace haptics::eval
