#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "tests/haptic_server/device/emulated/usb_model.h"
#include "tests/haptic_server/device/emulated/usbfs_wire.h"

namespace haptics::test {

/// An emulated device behind a usbfs node, as the kernel's usbfs shows it to libusb, with its own poll semantics. An open
/// file description is a pipe of one page, and its descriptors are write ends:
///   full: not POLLOUT, nothing to reap;  drained: POLLOUT, a transfer is done;  reader closed: POLLERR, unplugged.
/// It ends when its last descriptor is closed, in whichever process that is. One thread.
class UsbfsNode {
 public:
  explicit UsbfsNode(std::unique_ptr<EmulatedUsb> device) : device_(std::move(device)) {}

  /// A write end, which is the caller's; or a negative errno.
  [[nodiscard]] int open();
  [[nodiscard]] NodeReply ioctl(const NodeRequest& request);
  [[nodiscard]] std::vector<std::uint8_t> descriptors() const { return device_->descriptors(); }

  /// Completes what the device completes by now. @return When to call again.
  [[nodiscard]] std::uint64_t work(std::uint64_t now_ns);

  /// One command of a test, one line of answer: "fault NAME", "unplug", "plug", "await" (how much force comes within 20 ms), "state".
  [[nodiscard]] std::string command(const std::string& line);

 private:
  struct Urb {
    std::uint64_t id;
    std::uint32_t length;
    std::uint64_t posted_ns;
  };
  struct Description {
    std::uint64_t inode = 0;
    int readEnd = -1;
    bool signalled = true, unplugged = false, claimed = false;
    std::list<Urb> waiting = {};
    std::list<NodeReply> done = {};
  };

  void endClosed();
  void complete(Description& description, std::uint64_t now_ns, std::uint64_t& next_ns);
  static void finish(Description& description, std::uint64_t urb, int result, std::span<const std::uint8_t> data = {});
  static void signal(Description& description, bool ready);
  void unplug();
  [[nodiscard]] int claim(Description& description);
  [[nodiscard]] int submit(Description& description, const NodeRequest& request);
  [[nodiscard]] static NodeReply reap(Description& description);
  [[nodiscard]] static int discard(Description& description, std::uint64_t urb);
  [[nodiscard]] int out(std::span<const std::uint8_t> bytes);
  void noteMotors(std::uint64_t now_ns);

  std::unique_ptr<EmulatedUsb> device_;
  std::list<Description> descriptions_;
  bool present_ = true;
  std::uint64_t zeroSince_ns_ = 0;
  std::uint64_t awaits_ns_ = 0, awaited_ns_ = 0;  // how long the force is added up, and up to when it was
  double impulse_Ns_ = 0;
  std::uint64_t late_ = 0;    // replies
  std::uint64_t heldUp_ = 0;  // times that the processor let the hardware wait
};

}  // namespace haptics::test
