#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>

namespace haptics {

/// A reliable, ordered byte stream to one peer. It knows nothing of what it carries. Used from one thread, the one that
/// runs its callbacks. Destroying it, which its own callbacks may do, drops the connection at once and silently.
class Transport {
 public:
  struct Events {
    std::function<void(std::span<const char>)> received;
    std::function<void()> drained;                       ///< Everything sent has been taken by the system.
    std::function<void(const std::string& why)> closed;  ///< Once, also after close(); nothing follows it.
  };

  virtual ~Transport() = default;
  /// Nothing is received before it. Never calls back from within.
  virtual void start(Events events) = 0;
  /// Queues the bytes behind what is queued. Ignored after close.
  virtual void send(std::string bytes) = 0;
  /// Bytes queued here and not yet taken by the system: 0 means that a newest-only message may be sent now.
  [[nodiscard]] virtual std::size_t backlog() const noexcept = 0;
  /// Sends what is queued (for at most a second), then closes. Nothing is received from now on; `closed` is called
  /// later, not from within. The peer gets what was sent even if it is itself still sending.
  virtual void close(const std::string& why) = 0;
  [[nodiscard]] virtual std::string peer() const = 0;  ///< For the log.
  /// From now on a stream is sent that must not fall behind on a line that loses packets; as far as the system can.
  virtual void preferThroughput() {}
};

}  // namespace haptics
