#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <utility>

#include "haptic_server/net/rate_limit.h"

namespace haptics {

/// Lines about connections in the log, so many a second: a flood of them must not fill the disk.
class ConnectionLog {
 public:
  /// `write` may be empty.
  explicit ConnectionLog(std::function<void(const std::string&)> write) : write_(std::move(write)) {}

  void add(const std::string& line, std::uint64_t now_ns) {
    if (!write_) return;
    if (!rate_.allow(now_ns)) {
      ++leftOut_;
      return;
    }
    if (leftOut_ > 0) write_(std::to_string(leftOut_) + " lines about connections left out");
    leftOut_ = 0;
    write_(line);
  }

 private:
  static constexpr double kLinesPerSecond = 5;
  static constexpr double kBurst = 50;

  std::function<void(const std::string&)> write_;
  RateLimit rate_{kLinesPerSecond, kBurst};
  std::uint64_t leftOut_ = 0;
};

}  // namespace haptics
