#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "common/process/shared_memory.h"
#include "haptic_server/recording/last_seconds.h"
#include "haptic_server/servo/flight_ring.h"
#include "haptic_server/watchdog/watch_order.h"

namespace haptics {

/// The watchdog's own side, in a process of its own: polls whether the servo ticks, and takes the devices' force away when it
/// no longer does, or the server has ended. In that case it also records the last seconds. One thread.
class Watch {
 public:
  static constexpr std::uint64_t kPoll_ns = 3'000'000;  ///< Between two polls while there is a device.
  /// A servo that did not tick from one poll to the next so many times together, and for kSilentPeriods of its own, hangs:
  /// 18 to 21 ms at 1 kHz. Polls, not time: where the machine holds up the watchdog too, nothing is known of the servo.
  static constexpr std::uint64_t kMissedPolls = 6, kSilentPeriods = 3;
  /// The command without force goes out so often: one of a driver that still runs, for another moment, may cross it.
  static constexpr std::uint64_t kZeroCommands = 5;
  static constexpr std::uint64_t kBetweenCommands_ns = 2'000'000;
  /// As long as the servo hangs it goes out again, after so many polls.
  static constexpr std::uint64_t kPollsBetweenCommands = 33;

  struct Options {
    RecordingPlace recordings;  ///< Of a crash.
    std::function<void(const std::string&)> info, warning;
  };
  /// @param socket  To the server.
  Watch(int socket, Options options) : socket_(socket), options_(std::move(options)) {}

  /// Until the server says that nothing is to be watched any more, or has ended.
  void run();

 private:
  struct Armed {
    FileHandle node;
    std::uint8_t endpoint;
    std::uint8_t length;
    std::array<std::uint8_t, 64> bytes;
  };

  [[nodiscard]] bool waitForOrders();
  void take(ReceivedOrder received);
  void poll();
  void trip(const std::string& why);
  void sendZeroForce();
  void handleServerDeath();
  [[nodiscard]] WatchPage& page() const noexcept { return *reinterpret_cast<WatchPage*>(page_->bytes().data()); }
  [[nodiscard]] bool isArmed() const noexcept { return armed_[0] || armed_[1]; }
  [[nodiscard]] bool isWatching() const noexcept { return isArmed() && ring_; }

  int socket_;
  Options options_;
  std::optional<SharedMemory> page_;
  std::optional<FlightRing> ring_;
  std::optional<FileHandle> scenes_;
  std::array<std::optional<Armed>, kMaxHands> armed_;
  std::uint64_t hangsAfterPolls_ = kMissedPolls;  // after which the servo hangs
  std::uint64_t nextPoll_ns_ = 0;
  std::uint64_t end_ = 0;               // ticks at the last poll
  std::uint64_t pollsWithoutTick_ = 0;  // since the last tick
  std::uint64_t commandsLeft_ = 0;      // commands without force that are still to go out, one a poll
  bool ending_ = false, dismissed_ = false, tripped_ = false;
};

}  // namespace haptics
