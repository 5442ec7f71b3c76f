#pragma once

#include <cstddef>
#include <limits>
#include <memory>
#include <string>

#include "common/wire/transport.h"

namespace haptics {

/// Two transports in one process and one thread, joined by queues that move only when pumped: client and server code
/// run together. The ends may outlive the link.
class MemoryLink {
 public:
  static constexpr std::size_t kEverything = std::numeric_limits<std::size_t>::max();

  MemoryLink();
  ~MemoryLink();

  /// The two ends, each to be taken once.
  [[nodiscard]] std::unique_ptr<Transport> takeClient();
  [[nodiscard]] std::unique_ptr<Transport> takeServer();

  /// Delivers what had been sent when it was called, at most `limit_bytes` in each direction, then what follows from it
  /// (drained, closed). Answers wait for the next call. Returns whether anything happened.
  bool pump(std::size_t limit_bytes = kEverything);
  /// Pumps until nothing moves any more.
  void settle();
  /// The line breaks: what is on the way is lost and both ends are closed.
  void cut(const std::string& why);

  struct Shared;

 private:
  std::shared_ptr<Shared> shared_;
  std::unique_ptr<Transport> client_, server_;
};

}  // namespace haptics
