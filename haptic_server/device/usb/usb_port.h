#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/error/error.h"
#include "common/telemetry/device_status.h"

// The seam between the drivers and USB: libusb in a server, a model of the device in virtual time in tests.
namespace haptics {

/// Where a device is plugged in, and which one it is.
struct UsbPlace {
  std::uint8_t bus = 0, address = 0;  ///< As lsusb counts; another address after each plugging in.
  std::string path;                   ///< "1-4.2": bus and ports, stays the same.
  std::string serial;                 ///< Empty where it has none, or may not be opened to ask.
};

struct UsbModel {
  std::uint16_t vendor = 0, product = 0;
  std::uint8_t in = 0, out = 0;  ///< Endpoint addresses.
  bool interrupt = false;        ///< Endpoints are interrupt, not bulk, ones.
};

/// A request to the device itself (endpoint 0), without data.
struct UsbRequest {
  std::uint8_t type = 0, request = 0;
  std::uint16_t value = 0, index = 0;
};

enum class UsbOutcome : std::uint8_t {
  kDone,
  kBusy,     ///< send: as many transfers are under way as may be.
  kGone,     ///< Unplugged.
  kStalled,  ///< The device refuses.
  kTimeOut,
  kFailed,
};

struct UsbArrival {
  enum class Kind : std::uint8_t { kDeadline, kBytes, kGone, kStalled, kFailed };
  Kind kind = Kind::kDeadline;
  std::span<const std::uint8_t> bytes;  ///< Valid until the next call.
};

/// An opened device, its interface claimed. One thread uses it. Times are nanoseconds of clock().
class UsbPort {
 public:
  virtual ~UsbPort() = default;  ///< Cancels what is under way, releases the device.
  /// Waits for the answer, up to 100 ms.
  [[nodiscard]] virtual UsbOutcome control(const UsbRequest& request) = 0;
  /// Queues bytes to the OUT endpoint; does not wait.
  [[nodiscard]] virtual UsbOutcome send(std::span<const std::uint8_t> bytes) = 0;
  /// What comes next from the IN endpoint, until a deadline. Some transfers are always queued there, so that nothing is
  /// missed between two calls.
  [[nodiscard]] virtual UsbArrival next(std::uint64_t deadline_ns) = 0;
  /// After a stall: the endpoints work again.
  [[nodiscard]] virtual UsbOutcome clearStall() = 0;
  /// File descriptor of the device's node, for a process that writes to it when this one no longer can; -1: none.
  [[nodiscard]] virtual int descriptor() const noexcept { return -1; }
};

/// Why a device could not be opened: for the log, and for telemetry.
struct UsbRefusal {
  DeviceFault fault = DeviceFault::kNone;
  Error error;
};

/// All that is plugged in.
class UsbBus {
 public:
  virtual ~UsbBus() = default;
  [[nodiscard]] virtual std::uint64_t clock_ns() noexcept = 0;
  virtual void sleepUntil(std::uint64_t time_ns) = 0;
  [[nodiscard]] virtual std::vector<UsbPlace> list(const UsbModel& model) = 0;
  [[nodiscard]] virtual tl::expected<std::unique_ptr<UsbPort>, UsbRefusal> open(const UsbModel& model,
                                                                                const UsbPlace& place) = 0;
};

}  // namespace haptics
