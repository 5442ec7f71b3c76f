#pragma once

#include <array>
#include <cstddef>
#include <deque>
#include <memory>
#include <vector>

#include "common/process/file_handle.h"
#include "haptic_server/device/usb/usb_port.h"

struct libusb_context;
struct libusb_device_handle;
struct libusb_transfer;
struct pollfd;

namespace haptics {

struct UsbContextEnd {
  void operator()(libusb_context* context) const noexcept;
};
using UsbContext = std::unique_ptr<libusb_context, UsbContextEnd>;

/// A device opened by libusb, used by one thread, which also handles libusb's events: it waits on libusb's own descriptors
/// to the nanosecond, where libusb's own wait counts milliseconds.
class LibusbPort final : public UsbPort {
 public:
  /// Takes an opened handle of the context on the device's node, with interface 0 claimed; all end with the port.
  LibusbPort(FileHandle node, UsbContext context, libusb_device_handle* handle, const UsbModel& model);
  ~LibusbPort() override;
  LibusbPort(const LibusbPort&) = delete;
  LibusbPort& operator=(const LibusbPort&) = delete;

  [[nodiscard]] UsbOutcome control(const UsbRequest& request) override;
  [[nodiscard]] UsbOutcome send(std::span<const std::uint8_t> bytes) override;
  [[nodiscard]] UsbArrival next(std::uint64_t deadline_ns) override;
  [[nodiscard]] UsbOutcome clearStall() override;
  [[nodiscard]] int descriptor() const noexcept override { return node_.descriptor(); }

 private:
  static constexpr std::size_t kPacket_bytes = 64;
  static constexpr std::size_t kQueuedIn = 4;   // three are with the device while one is looked at
  static constexpr std::size_t kQueuedOut = 4;  // commands on their way before the device counts as busy

  struct Transfer {
    LibusbPort* port = nullptr;
    libusb_transfer* transfer = nullptr;
    std::array<std::uint8_t, kPacket_bytes> bytes{};
    bool underWay = false;
    bool in = false;
  };

  static void completed(libusb_transfer* transfer) noexcept;  // libusb, which calls it, is C
  bool submit(Transfer& transfer, std::size_t length);
  void keepReceiving();
  void handleEvents(std::uint64_t deadline_ns);

  FileHandle node_;
  UsbContext context_;
  libusb_device_handle* handle_;
  UsbModel model_;
  std::array<Transfer, kQueuedIn + kQueuedOut> transfers_;
  std::deque<Transfer*> arrived_;          // IN transfers with bytes
  std::deque<UsbArrival::Kind> happened_;  // besides bytes
  Transfer* shown_ = nullptr;              // its bytes were given out last
  std::vector<pollfd> polled_;
  bool gone_ = false;
  bool halted_ = false;  // stalled, until clearStall()
};

}  // namespace haptics
