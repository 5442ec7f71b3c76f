#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>

#include "common/process/file_handle.h"

// Between the server and its watchdog: orders over a socket, some with a descriptor, and a page of memory that both have.
// The socket's end is the server's death, unless kDismiss was the last order.
namespace haptics {

inline constexpr int kWatchSocket = 3;  ///< Descriptor at which the watchdog finds its socket.

struct WatchOrder {
  enum class Kind : std::uint8_t {
    kPage,     ///< Memory of the WatchPage.
    kRing,     ///< Memory of the flight ring; `period_ns`.
    kScenes,   ///< Memory of the scene journal, in place of the one before.
    kArm,      ///< Node of `device`, `endpoint` and `bytes` that take its force away.
    kDisarm,   ///< No such device any more.
    kEnding,   ///< The servo is about to stop on request.
    kDying,    ///< The server is about to end because something is wrong.
    kDismiss,  ///< There is nothing to watch any more.
  };
  Kind kind = Kind::kDismiss;
  std::uint8_t device = 0;  ///< Of which hand, below kMaxHands.
  std::uint8_t endpoint = 0;
  std::uint8_t length = 0;
  std::array<std::uint8_t, 64> bytes{};
  std::uint64_t period_ns = 0;  ///< Of the servo.
};

struct ReceivedOrder {
  WatchOrder order;
  FileHandle descriptor;  ///< None where the order has none.
};

/// What the watchdog says. It writes, the server reads.
struct WatchPage {
  std::atomic<std::uint64_t> trips{0};  ///< Times that it began to take the force away.
  std::atomic<std::uint64_t> polls{0};  ///< It lives: one at least each kSlowestPoll_ns.
  static constexpr std::uint64_t kSlowestPoll_ns = 100'000'000;
};

/// Does not wait. @param descriptor  Goes with it, and stays the caller's; -1: none. @return False: nobody is there.
bool sendOrder(int socket, const WatchOrder& order, int descriptor = -1) noexcept;
/// Does not wait. Nothing: there is none now, or `ended` is set.
[[nodiscard]] std::optional<ReceivedOrder> receiveOrder(int socket, bool& ended) noexcept;

}  // namespace haptics
