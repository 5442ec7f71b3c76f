// Preloaded before libusb: /dev/bus/usb/001/002 becomes the node of a device that is emulated in another process, which
// EMULATED_USB names by its Unix socket. EMULATED_USB_DENY and EMULATED_USB_BUSY take the permission and the interface
// away. A descriptor of the node means the same in every process that has it, as the kernel's do.
#include <dlfcn.h>
#include <fcntl.h>
#include <linux/usbdevice_fs.h>
#include <pthread.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>

#include "tests/haptic_server/device/emulated/usbfs_wire.h"

namespace haptics::test {
namespace {

constexpr const char* kNodes = "/dev/bus/usb/";
constexpr const char* kNode = "/dev/bus/usb/001/002";

template <class Function>
Function next(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

int failed(int error) {
  errno = error;
  return -1;
}

/// The process's connection to the hardware, made when it is first wanted. One request at a time.
class Hardware {
 public:
  Hardware() {
    pthread_mutexattr_t inheriting;
    pthread_mutexattr_init(&inheriting);
    pthread_mutexattr_setprotocol(&inheriting, PTHREAD_PRIO_INHERIT);
    pthread_mutex_init(&mutex_, &inheriting);
  }
  /// @param[out] descriptor  That came with the reply; may be null.
  NodeReply ask(const NodeRequest& request, int* descriptor = nullptr) {
    pthread_mutex_lock(&mutex_);
    NodeReply reply{.result = -ENODEV};
    if (connected() && send(socket_, &request, sizeof request, MSG_NOSIGNAL) == sizeof request) {
      receive(reply, descriptor);
    }
    pthread_mutex_unlock(&mutex_);
    return reply;
  }

 private:
  bool connected() {
    const char* path = std::getenv("EMULATED_USB");
    if (socket_ >= 0 || path == nullptr) return socket_ >= 0;
    socket_ = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path, sizeof address.sun_path - 1);
    return connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  }
  void receive(NodeReply& reply, int* descriptor) const {
    iovec bytes{&reply, sizeof reply};
    alignas(cmsghdr) char room[CMSG_SPACE(sizeof(int))]{};
    msghdr message{};
    message.msg_iov = &bytes;
    message.msg_iovlen = 1;
    message.msg_control = room;
    message.msg_controllen = sizeof room;
    ssize_t count = -1;
    do {
      count = recvmsg(socket_, &message, MSG_CMSG_CLOEXEC);
    } while (count < 0 && errno == EINTR);
    if (count != sizeof reply) reply = {.result = -ENODEV};
    const cmsghdr* head = count > 0 ? CMSG_FIRSTHDR(&message) : nullptr;
    if (head != nullptr && descriptor != nullptr) std::memcpy(descriptor, CMSG_DATA(head), sizeof *descriptor);
  }

  pthread_mutex_t mutex_;
  int socket_ = -1;
};

Hardware& hardware() {
  static auto* const kOnly = new Hardware;
  return *kOnly;
}

/// Descriptors that were opened here, and how far each was read.
struct Opened {
  std::atomic<int> descriptor{-1};
  off_t position = 0;
  std::uint32_t length = 0;
  std::array<std::uint8_t, kMaxNodeData> descriptors{};
};
std::array<Opened, 8> opened;

Opened* openedAs(int descriptor) {
  if (descriptor < 0) return nullptr;
  const auto found = std::ranges::find_if(opened, [&](const Opened& o) { return o.descriptor == descriptor; });
  return found == opened.end() ? nullptr : &*found;
}

bool isNode(const char* path) { return path != nullptr && std::strncmp(path, kNodes, std::strlen(kNodes)) == 0; }

int openNode(const char* path) {
  if (std::getenv("EMULATED_USB_DENY") != nullptr) return failed(EACCES);
  if (std::strcmp(path, kNode) != 0) return failed(ENOENT);  // of a device that has no more than its place in sysfs
  int descriptor = -1;
  const NodeReply reply = hardware().ask({}, &descriptor);
  if (reply.result < 0) return failed(-reply.result);
  const auto free = std::ranges::find_if(opened, [](const Opened& o) { return o.descriptor < 0; });
  if (free == opened.end()) return failed(EMFILE);
  free->position = 0;
  free->length = reply.length;
  free->descriptors = reply.data;
  free->descriptor = descriptor;
  return descriptor;
}

int bulk(NodeRequest& asked, const usbdevfs_bulktransfer& transfer) {
  asked.endpoint = static_cast<std::uint8_t>(transfer.ep);
  asked.length = std::min<std::uint32_t>(transfer.len, kMaxNodeData);
  std::memcpy(asked.data.data(), transfer.data, asked.length);
  const NodeReply reply = hardware().ask(asked);
  return reply.result < 0 ? failed(-reply.result) : reply.result;
}

int control(NodeRequest& asked, const usbdevfs_ctrltransfer& transfer) {
  static_assert(sizeof asked.setup == offsetof(usbdevfs_ctrltransfer, timeout));
  std::memcpy(asked.setup.data(), &transfer, sizeof asked.setup);
  const NodeReply reply = hardware().ask(asked);
  if (reply.result < 0) return failed(-reply.result);
  std::memcpy(transfer.data, reply.data.data(), reply.length);
  return reply.result;
}

int submit(NodeRequest& asked, const usbdevfs_urb& urb) {
  asked.urb = reinterpret_cast<std::uintptr_t>(&urb);
  asked.type = urb.type;
  asked.endpoint = urb.endpoint;
  asked.length = std::min<std::uint32_t>(static_cast<std::uint32_t>(urb.buffer_length), kMaxNodeData);
  if (urb.type == USBDEVFS_URB_TYPE_CONTROL) {
    std::memcpy(asked.setup.data(), urb.buffer, asked.setup.size());
  } else if ((urb.endpoint & 0x80) == 0) {
    std::memcpy(asked.data.data(), urb.buffer, asked.length);
  }
  const NodeReply reply = hardware().ask(asked);
  return reply.result < 0 ? failed(-reply.result) : 0;
}

/// The node whose last transfer was reaped just now. libusb asks for another one at once, which need not be sent to the
/// hardware: one that is done since then is found by the next poll.
std::atomic<std::uint64_t> reapedDry{0};

/// Writes where the transfer was submitted from, in the memory of whoever reaps: as the kernel does.
int reap(const NodeRequest& asked, void** reaped) {
  if (reapedDry.exchange(0) == asked.node) return failed(EAGAIN);
  const NodeReply reply = hardware().ask(asked);
  if (reply.urb == 0) return failed(-reply.result);
  if (reply.isLast) reapedDry = asked.node;
  auto* urb = reinterpret_cast<usbdevfs_urb*>(static_cast<std::uintptr_t>(reply.urb));
  auto* buffer = static_cast<std::uint8_t*>(urb->buffer);
  if (urb->type == USBDEVFS_URB_TYPE_CONTROL) buffer += sizeof asked.setup;
  std::memcpy(buffer, reply.data.data(), reply.length);
  urb->status = reply.status;
  urb->actual_length = reply.result;
  *reaped = urb;
  return 0;
}

int nodeIoctl(std::uint64_t inode, unsigned long request, void* argument) {
  NodeRequest asked{.node = inode, .request = request};
  switch (request) {
    case USBDEVFS_GET_CAPABILITIES:
      *static_cast<std::uint32_t*>(argument) = USBDEVFS_CAP_BULK_CONTINUATION | USBDEVFS_CAP_NO_PACKET_SIZE_LIM |
                                               USBDEVFS_CAP_REAP_AFTER_DISCONNECT | USBDEVFS_CAP_ZERO_PACKET;
      return 0;
    case USBDEVFS_GET_SPEED:
      return 2;  // full speed
    case USBDEVFS_CONNECTINFO:
      *static_cast<usbdevfs_connectinfo*>(argument) = {.devnum = 2, .slow = 0};
      return 0;
    case USBDEVFS_GETDRIVER:
      return failed(ENODATA);
    case USBDEVFS_RESET:
    case USBDEVFS_SETCONFIGURATION:
      return 0;
    case USBDEVFS_BULK:
      return bulk(asked, *static_cast<usbdevfs_bulktransfer*>(argument));
    case USBDEVFS_CONTROL:
      return control(asked, *static_cast<usbdevfs_ctrltransfer*>(argument));
    case USBDEVFS_SUBMITURB:
      return submit(asked, *static_cast<usbdevfs_urb*>(argument));
    case USBDEVFS_REAPURB:
    case USBDEVFS_REAPURBNDELAY:
      return reap(asked, static_cast<void**>(argument));
    case USBDEVFS_CLAIMINTERFACE:
    case USBDEVFS_DISCONNECT_CLAIM:
      if (std::getenv("EMULATED_USB_BUSY") != nullptr) return failed(EBUSY);
      break;
    default:
      asked.urb = reinterpret_cast<std::uintptr_t>(argument);  // of those that discard a transfer
  }
  const NodeReply reply = hardware().ask(asked);
  return reply.result < 0 ? failed(-reply.result) : reply.result;
}

/// The inode of the pipe that a descriptor of the node is of, in whichever process it was opened; 0: it is none.
std::uint64_t nodeOf(int descriptor, unsigned long request) {
  struct stat about {};
  if (_IOC_TYPE(request) != 'U' || fstat(descriptor, &about) != 0 || !S_ISFIFO(about.st_mode)) return 0;
  return about.st_ino;
}

}  // namespace
}  // namespace haptics::test

using haptics::test::isNode;
using haptics::test::next;
using haptics::test::openedAs;
using haptics::test::openNode;

extern "C" {

int open(const char* path, int flags, ...) {
  if (isNode(path)) return openNode(path);
  va_list rest;
  va_start(rest, flags);
  const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(rest, mode_t) : 0;
  va_end(rest);
  static const auto kNext = next<int (*)(const char*, int, ...)>("open");
  return kNext(path, flags, mode);
}

int open64(const char* path, int flags, ...) {
  if (isNode(path)) return openNode(path);
  va_list rest;
  va_start(rest, flags);
  const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(rest, mode_t) : 0;
  va_end(rest);
  static const auto kNext = next<int (*)(const char*, int, ...)>("open64");
  return kNext(path, flags, mode);
}

int __open_2(const char* path, int flags) {
  static const auto kNext = next<int (*)(const char*, int)>("__open_2");
  return isNode(path) ? openNode(path) : kNext(path, flags);
}

int __open64_2(const char* path, int flags) {
  static const auto kNext = next<int (*)(const char*, int)>("__open64_2");
  return isNode(path) ? openNode(path) : kNext(path, flags);
}

int ioctl(int descriptor, unsigned long request, ...) {
  va_list rest;
  va_start(rest, request);
  void* argument = va_arg(rest, void*);
  va_end(rest);
  if (const auto node = haptics::test::nodeOf(descriptor, request)) {
    return haptics::test::nodeIoctl(node, request, argument);
  }
  static const auto kNext = next<int (*)(int, unsigned long, ...)>("ioctl");
  return kNext(descriptor, request, argument);
}

ssize_t read(int descriptor, void* bytes, size_t count) {
  if (auto* node = openedAs(descriptor)) {
    const auto at = std::min(static_cast<std::uint32_t>(node->position), node->length);
    const std::size_t length = std::min<std::size_t>(count, node->length - at);
    std::memcpy(bytes, node->descriptors.data() + at, length);
    node->position += static_cast<off_t>(length);
    return static_cast<ssize_t>(length);
  }
  static const auto kNext = next<ssize_t (*)(int, void*, size_t)>("read");
  return kNext(descriptor, bytes, count);
}

off_t lseek(int descriptor, off_t offset, int whence) {
  if (auto* node = openedAs(descriptor)) return node->position = offset;
  static const auto kNext = next<off_t (*)(int, off_t, int)>("lseek");
  return kNext(descriptor, offset, whence);
}

off64_t lseek64(int descriptor, off64_t offset, int whence) {
  if (auto* node = openedAs(descriptor)) return node->position = offset;
  static const auto kNext = next<off64_t (*)(int, off64_t, int)>("lseek64");
  return kNext(descriptor, offset, whence);
}

int close(int descriptor) {
  if (auto* node = openedAs(descriptor)) node->descriptor = -1;
  static const auto kNext = next<int (*)(int)>("close");
  return kNext(descriptor);
}
}
