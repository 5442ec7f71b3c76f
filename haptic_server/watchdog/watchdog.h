#pragma once

#include <sys/types.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "common/process/shared_memory.h"
#include "haptic_server/device/usb/output_watchdog.h"
#include "haptic_server/servo/flight_ring.h"
#include "haptic_server/watchdog/watch_order.h"
#include "haptics/v1/envelope.pb.h"

namespace haptics {

/// The server's side of its watchdog, the program haptic_watchdog, which lies beside the server's: starts it, in a session
/// of its own, tells it which devices are armed, and starts another one when it ends or hangs: the first time at once, then
/// after pauses that grow to a second, and at once again after one that lived for 10 s. As long as there is none, a warning
/// has said so.
class Watchdog final {
 public:
  struct Options {
    std::filesystem::path recordings;  ///< Folder for the recording of a crash,
    std::size_t maxRecordings_bytes;   ///< and what it holds at most.
    double period_s = 1e-3;            ///< Of the servo.
    std::function<void(const std::string&)> info, warning;
  };
  /// Throws std::bad_alloc where the system has no memory for a page.
  Watchdog(Options options, const FlightRing& ring);
  ~Watchdog();  ///< Dismisses.
  Watchdog(const Watchdog&) = delete;
  Watchdog& operator=(const Watchdog&) = delete;

  /// For the device of a hand, below kMaxHands; lives as long as this.
  [[nodiscard]] OutputWatchdog& ofDevice(std::size_t hand) noexcept { return devices_[hand]; }

  /// Memory of the scene journal, in place of the one before; the descriptor stays the caller's. Any thread.
  void keepScenes(int descriptor) noexcept;
  /// The servo is about to stop on request. Any thread.
  void ending() noexcept;
  /// Ends haptic_watchdog, which records no crash: no device has a force any more. Nothing is watched from now on. One
  /// thread at a time.
  void dismiss();
  /// Any thread.
  void fillStatus(v1::Status& status) const;

 private:
  struct Kept {
    WatchOrder order;
    FileHandle descriptor;
  };
  class WatchedDevice final : public OutputWatchdog {
   public:
    WatchedDevice(Watchdog& watchdog, std::uint8_t hand) : watchdog_(watchdog), hand_(hand) {}
    void arm(int node, std::uint8_t out, std::span<const std::uint8_t> zero) noexcept override {
      watchdog_.arm(hand_, node, out, zero);
    }
    void disarm() noexcept override { watchdog_.disarm(hand_); }
    [[nodiscard]] std::uint64_t trips() const noexcept override {
      return watchdog_.page().trips.load(std::memory_order_acquire);
    }

   private:
    Watchdog& watchdog_;
    const std::uint8_t hand_;
  };

  void arm(std::uint8_t hand, int node, std::uint8_t out, std::span<const std::uint8_t> zero) noexcept;
  void disarm(std::uint8_t hand) noexcept;

  [[nodiscard]] const WatchPage& page() const noexcept {
    return *reinterpret_cast<const WatchPage*>(page_.bytes().data());
  }
  [[nodiscard]] bool startProgram();
  void instruct(pid_t process);
  void endProgram(int patience_ms);
  void say(const WatchOrder& order, int descriptor = -1) noexcept;
  void guard();
  [[nodiscard]] bool waitForItsEnd();

  Options options_;
  SharedMemory page_;
  FileHandle ring_;
  FileHandle quit_;  // an event: the guard is to end
  std::atomic<bool> alive_{false};
  std::atomic<std::uint64_t> started_{0};
  bool saidWhy_ = false;  // there is none; the guard's
  std::thread guard_;
  std::array<WatchedDevice, kMaxHands> devices_{WatchedDevice{*this, 0}, WatchedDevice{*this, 1}};

  std::mutex mutex_;  // guards what follows
  FileHandle socket_;
  pid_t process_ = -1;
  std::optional<Kept> scenes_;
  std::array<std::optional<Kept>, kMaxHands> armed_;
  bool ending_ = false;
};

}  // namespace haptics
