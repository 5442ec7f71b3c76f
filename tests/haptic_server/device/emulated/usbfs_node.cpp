#include "tests/haptic_server/device/emulated/usbfs_node.h"

#include <fcntl.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <span>
#include <vector>

#include "common/clock/monotonic.h"

namespace haptics::test {
namespace {

constexpr std::uint64_t kSecond_ns = 1'000'000'000;
constexpr std::uint64_t kHeldUp_ns = 1'000'000;
/// Hardware is not delayed by what runs on the processor: above the servo, where that is permitted.
constexpr int kHardwarePriority = 90;

int failed(int error) {
  errno = error;
  return -1;
}

/// Past whatever else stands before read(2) and close(2).
long rawRead(int descriptor, void* bytes, std::size_t count) { return syscall(SYS_read, descriptor, bytes, count); }
void rawClose(int descriptor) { syscall(SYS_close, descriptor); }

int stringDescriptor(const EmulatedUsb& device, int index, std::span<std::uint8_t> bytes) {
  std::vector<std::uint8_t> text{4, 3, 9, 4};  // index 0: in English
  if (index != 0) {
    text = {0, 3};
    for (const char character : device.stringDescriptor(index)) {
      text.push_back(static_cast<std::uint8_t>(character));
      text.push_back(0);
    }
    text[0] = static_cast<std::uint8_t>(text.size());
  }
  const std::size_t count = std::min(bytes.size(), text.size());
  std::copy_n(text.begin(), count, bytes.begin());
  return static_cast<int>(count);
}

int control(EmulatedUsb& device, unsigned type, unsigned request, unsigned value, std::span<std::uint8_t> data) {
  constexpr unsigned kToHost = 0x80, kGetDescriptor = 6, kSetConfiguration = 9;
  if (type == kToHost && request == kGetDescriptor && value >> 8 == 3) {
    return stringDescriptor(device, static_cast<int>(value & 0xFF), data);
  }
  if (type == 0 && request == kSetConfiguration) return 0;
  return device.control(static_cast<std::uint8_t>(type), static_cast<std::uint8_t>(request),
                        static_cast<std::uint16_t>(value), monotonicNow_ns());
}

}  // namespace

class UsbfsNode::Lock {
 public:
  explicit Lock(pthread_mutex_t& mutex) : mutex_(mutex) { pthread_mutex_lock(&mutex_); }
  ~Lock() { pthread_mutex_unlock(&mutex_); }
  Lock(const Lock&) = delete;
  Lock& operator=(const Lock&) = delete;

 private:
  pthread_mutex_t& mutex_;
};

UsbfsNode::UsbfsNode(std::unique_ptr<EmulatedUsb> device) : device_(std::move(device)) {
  pthread_mutexattr_t inheriting;
  pthread_mutexattr_init(&inheriting);
  pthread_mutexattr_setprotocol(&inheriting, PTHREAD_PRIO_INHERIT);
  pthread_mutex_init(&mutex_, &inheriting);
  pthread_condattr_t monotonic;
  pthread_condattr_init(&monotonic);
  pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC);
  pthread_cond_init(&wake_, &monotonic);
}

int UsbfsNode::open() {
  const Lock lock(mutex_);
  if (!present_) return failed(ENOENT);
  if (writeEnd_ >= 0) return failed(EBUSY);
  std::array<int, 2> ends;
  if (pipe2(ends.data(), O_NONBLOCK | O_CLOEXEC) != 0) return -1;
  fcntl(ends[1], F_SETPIPE_SZ, 4096);
  readEnd_ = ends[0];
  writeEnd_ = ends[1];
  position_ = 0;
  closing_ = unplugged_ = claimed_ = false;
  signalled_ = true;
  signal(false);
  pthread_create(&thread_, nullptr, &UsbfsNode::work, this);
  return writeEnd_;
}

void UsbfsNode::closed() {
  {
    const Lock lock(mutex_);
    closing_ = true;
    pthread_cond_signal(&wake_);
  }
  pthread_join(thread_, nullptr);
  const Lock lock(mutex_);
  if (!unplugged_) rawClose(readEnd_);
  readEnd_ = writeEnd_ = -1;
  waiting_.clear();
  done_.clear();
}

void* UsbfsNode::work(void* node) {
  pthread_setname_np(pthread_self(), "usb-hardware");
  prctl(PR_SET_TIMERSLACK, 1UL);
  const sched_param priority{.sched_priority = kHardwarePriority};
  pthread_setschedparam(pthread_self(), SCHED_FIFO, &priority);
  static_cast<UsbfsNode*>(node)->workUntilClosed();
  return nullptr;
}

void UsbfsNode::workUntilClosed() {
  const Lock lock(mutex_);
  while (!closing_) {
    const std::uint64_t now_ns = monotonicNow_ns();
    std::uint64_t next_ns = now_ns + kSecond_ns;
    if (!unplugged_) completeReady(now_ns, next_ns);
    const timespec until{static_cast<time_t>(next_ns / kSecond_ns), static_cast<long>(next_ns % kSecond_ns)};
    pthread_cond_timedwait(&wake_, &mutex_, &until);
  }
}

void UsbfsNode::completeReady(std::uint64_t now_ns, std::uint64_t& next_ns) {
  while (!waiting_.empty()) {  // an endpoint's transfers complete in their order
    const auto ready_ns = device_->inReadyAt(waiting_.front().posted_ns);
    if (!ready_ns || *ready_ns > now_ns) {
      next_ns = ready_ns ? std::min(next_ns, *ready_ns) : next_ns;
      return;
    }
    if (now_ns - *ready_ns > kHeldUp_ns) ++heldUp_;
    usbdevfs_urb* urb = waiting_.front().urb;
    waiting_.pop_front();
    finish(urb, device_->in({static_cast<std::uint8_t*>(urb->buffer), static_cast<std::size_t>(urb->buffer_length)},
                            now_ns));
  }
}

void UsbfsNode::finish(usbdevfs_urb* urb, int result) {
  urb->status = std::min(result, 0);
  urb->actual_length = std::max(result, 0);
  done_.push_back(urb);
  signal(true);
}

void UsbfsNode::signal(bool ready) {
  if (ready == signalled_ || unplugged_) return;
  signalled_ = ready;
  char byte = 0;
  const long moved = ready ? rawRead(readEnd_, &byte, 1) : ::write(writeEnd_, &byte, 1);
  if (moved != 1) std::abort();
}

void UsbfsNode::unplug() {
  present_ = false;
  if (writeEnd_ < 0 || unplugged_) return;
  for (const Waiting& waiting : waiting_) finish(waiting.urb, -ENODEV);
  waiting_.clear();
  unplugged_ = true;
  rawClose(readEnd_);
}

int UsbfsNode::submit(usbdevfs_urb* urb) {
  const std::uint64_t now_ns = monotonicNow_ns();
  if (urb->type == USBDEVFS_URB_TYPE_CONTROL) {
    auto* setup = static_cast<std::uint8_t*>(urb->buffer);
    const std::size_t length = static_cast<std::size_t>(setup[6] | setup[7] << 8);
    finish(urb,
           control(*device_, setup[0], setup[1], static_cast<unsigned>(setup[2] | setup[3] << 8), {setup + 8, length}));
  } else if ((urb->endpoint & 0x80) == 0) {
    finish(urb,
           device_->out({static_cast<const std::uint8_t*>(urb->buffer), static_cast<std::size_t>(urb->buffer_length)},
                        now_ns));
    noteMotors(now_ns);
  } else {
    waiting_.push_back({urb, now_ns});
  }
  pthread_cond_signal(&wake_);
  return 0;
}

void UsbfsNode::noteMotors(std::uint64_t now_ns) {
  if (device_->motorsOn()) {
    zeroSince_ns_ = 0;
  } else if (zeroSince_ns_ == 0) {
    zeroSince_ns_ = now_ns;
  }
}

int UsbfsNode::reap(void* argument) {
  if (done_.empty()) {
    signal(false);
    return failed(unplugged_ ? ENODEV : EAGAIN);
  }
  *static_cast<void**>(argument) = done_.front();
  done_.pop_front();
  if (done_.empty()) signal(false);
  return 0;
}

int UsbfsNode::discard(const void* urb) {
  const auto found = std::ranges::find_if(waiting_, [&](const Waiting& waiting) { return waiting.urb == urb; });
  if (found == waiting_.end()) return failed(EINVAL);
  usbdevfs_urb* discarded = found->urb;
  waiting_.erase(found);
  finish(discarded, -ENOENT);
  return 0;
}

int UsbfsNode::ioctl(unsigned long request, void* argument) {
  const Lock lock(mutex_);
  if (unplugged_ && request != USBDEVFS_REAPURBNDELAY) return failed(ENODEV);
  switch (request) {
    case USBDEVFS_GET_CAPABILITIES:
      *static_cast<std::uint32_t*>(argument) = USBDEVFS_CAP_BULK_CONTINUATION | USBDEVFS_CAP_NO_PACKET_SIZE_LIM |
                                               USBDEVFS_CAP_REAP_AFTER_DISCONNECT | USBDEVFS_CAP_ZERO_PACKET;
      return 0;
    case USBDEVFS_GET_SPEED:
      return 2;  // full speed
    case USBDEVFS_GETDRIVER:
      return failed(ENODATA);
    case USBDEVFS_CLAIMINTERFACE:
    case USBDEVFS_DISCONNECT_CLAIM:
      if (std::getenv("EMULATED_USB_BUSY") != nullptr) return failed(EBUSY);
      claimed_ = true;
      return 0;
    case USBDEVFS_RELEASEINTERFACE:
    case USBDEVFS_RESET:
    case USBDEVFS_SETCONFIGURATION:
      return 0;
    case USBDEVFS_CLEAR_HALT:
      device_->clearHalt();
      return 0;
    case USBDEVFS_CONTROL: {
      auto* transfer = static_cast<usbdevfs_ctrltransfer*>(argument);
      const int result = control(*device_, transfer->bRequestType, transfer->bRequest, transfer->wValue,
                                 {static_cast<std::uint8_t*>(transfer->data), transfer->wLength});
      return result < 0 ? failed(-result) : result;
    }
    case USBDEVFS_SUBMITURB:
      return submit(static_cast<usbdevfs_urb*>(argument));
    case USBDEVFS_REAPURB:
    case USBDEVFS_REAPURBNDELAY:
      return reap(argument);
    case USBDEVFS_DISCARDURB:
      return discard(argument);
    default:
      return failed(ENOTTY);
  }
}

long UsbfsNode::read(void* bytes, std::size_t count) {
  const Lock lock(mutex_);
  const auto all = device_->descriptors();
  const std::size_t at = std::min(static_cast<std::size_t>(position_), all.size());
  const std::size_t length = std::min(count, all.size() - at);
  std::memcpy(bytes, all.data() + at, length);
  position_ += static_cast<long>(length);
  return static_cast<long>(length);
}

std::string UsbfsNode::command(const std::string& line) {
  const Lock lock(mutex_);
  const std::uint64_t now_ns = monotonicNow_ns();
  if (line == "unplug") {
    unplug();
  } else if (line == "plug") {
    device_->powerCycle();
    present_ = true;
  } else if (line.starts_with("fault ")) {
    const auto fault = emulatedFault(line.substr(6));
    if (!fault) return "unknown fault";
    device_->setFault(*fault, now_ns);
  } else if (line != "state") {
    return "unknown command";
  }
  pthread_cond_signal(&wake_);
  char answer[200];
  std::snprintf(answer, sizeof answer,
                R"({"now_ns": %llu, "motors_on": %s, "zero_since_ns": %llu, "held_up": %llu, "replies": %llu})",
                static_cast<unsigned long long>(now_ns), device_->motorsOn() ? "true" : "false",
                static_cast<unsigned long long>(zeroSince_ns_), static_cast<unsigned long long>(heldUp_),
                static_cast<unsigned long long>(device_->replies()));
  return answer;
}

}  // namespace haptics::test
