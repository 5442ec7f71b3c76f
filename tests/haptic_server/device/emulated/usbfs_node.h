#pragma once

#include <linux/usbdevice_fs.h>
#include <pthread.h>

#include <cstdint>
#include <list>
#include <memory>
#include <string>

#include "tests/haptic_server/device/emulated/usb_model.h"

namespace haptics::test {

/// An emulated device behind a usbfs node, as the kernel's usbfs shows it to libusb, with its own poll semantics. The
/// descriptor that libusb holds is the write end of a pipe of one page:
///   full: not POLLOUT, nothing to reap;  drained: POLLOUT, a transfer is done;  reader closed: POLLERR, unplugged.
/// Any thread may call; a thread of its own completes transfers when the device would.
class UsbfsNode {
 public:
  explicit UsbfsNode(std::unique_ptr<EmulatedUsb> device);

  /// A descriptor, or -1 with errno.
  [[nodiscard]] int open();
  [[nodiscard]] bool owns(int descriptor) const noexcept { return descriptor >= 0 && descriptor == writeEnd_; }
  int ioctl(unsigned long request, void* argument);
  long read(void* bytes, std::size_t count);
  long seek(long offset) noexcept { return position_ = offset; }
  void closed();  ///< Before the descriptor itself is closed.

  /// One command of a test, one line of answer: "fault NAME", "unplug", "plug", "state".
  [[nodiscard]] std::string command(const std::string& line);

 private:
  struct Waiting {
    usbdevfs_urb* urb;
    std::uint64_t posted_ns;
  };
  class Lock;

  static void* work(void* node);
  void workUntilClosed();
  void completeReady(std::uint64_t now_ns, std::uint64_t& next_ns);
  void finish(usbdevfs_urb* urb, int result);
  void signal(bool ready);
  void unplug();
  [[nodiscard]] int submit(usbdevfs_urb* urb);
  [[nodiscard]] int reap(void* argument);
  [[nodiscard]] int discard(const void* urb);
  void noteMotors(std::uint64_t now_ns);

  std::unique_ptr<EmulatedUsb> device_;
  std::list<Waiting> waiting_;
  std::list<usbdevfs_urb*> done_;
  int readEnd_ = -1, writeEnd_ = -1;
  long position_ = 0;
  bool signalled_ = false, closing_ = false, present_ = true, unplugged_ = false, claimed_ = false;
  std::uint64_t zeroSince_ns_ = 0;
  std::uint64_t heldUp_ = 0;  // times that the processor let the hardware wait
  pthread_mutex_t mutex_;
  pthread_cond_t wake_;
  pthread_t thread_{};
};

}  // namespace haptics::test
