// Preloaded before libusb: /dev/bus/usb/001/002 becomes the node of an emulated device. EMULATED_USB says which ("falcon",
// "wooden"); EMULATED_USB_CONTROL names a Unix socket on which a test breaks it; EMULATED_USB_DENY and EMULATED_USB_BUSY
// take the permission and the interface away.
#include <dlfcn.h>
#include <fcntl.h>
#include <pthread.h>
#include <sys/socket.h>
#include <sys/types.h>
#include <sys/un.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdarg>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <thread>

#include "tests/haptic_server/device/emulated/falcon_model.h"
#include "tests/haptic_server/device/emulated/usbfs_node.h"
#include "tests/haptic_server/device/emulated/wooden_model.h"

namespace haptics::test {
namespace {

constexpr const char* kNodes = "/dev/bus/usb/";
constexpr const char* kNode = "/dev/bus/usb/001/002";

template <class Function>
Function next(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

/// Answers one test at a time, line by line, for the life of the process.
void serve(UsbfsNode& node, const std::string& path) {
  const int listening = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof address.sun_path - 1);
  unlink(path.c_str());  // an earlier program's
  if (bind(listening, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) std::abort();
  if (listen(listening, 1) != 0) std::abort();
  for (;;) {
    const int test = accept4(listening, nullptr, nullptr, SOCK_CLOEXEC);
    if (test < 0) continue;
    std::string heard;
    char byte = 0;
    while (recv(test, &byte, 1, 0) == 1) {
      if (byte != '\n') {
        heard += byte;
        continue;
      }
      const std::string answer = node.command(heard) + '\n';
      heard.clear();
      if (send(test, answer.data(), answer.size(), MSG_NOSIGNAL) < 0) break;
    }
    ::close(test);
  }
}

std::atomic<UsbfsNode*> opened{nullptr};  // from the first open() on, to the process's end

UsbfsNode* makeNode() {
  const char* kind = std::getenv("EMULATED_USB");
  std::unique_ptr<EmulatedUsb> device;
  if (kind != nullptr && std::strcmp(kind, "wooden") == 0) {
    device = std::make_unique<WoodenModel>();
  } else {
    device = std::make_unique<FalconModel>();
  }
  auto* made = new UsbfsNode(std::move(device));
  if (const char* path = std::getenv("EMULATED_USB_CONTROL")) {
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);  // signals are the program's
    std::thread([made, path = std::string(path)] { serve(*made, path); }).detach();
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
  }
  opened = made;
  return made;
}

/// The node that this descriptor is of, or null.
UsbfsNode* nodeOf(int descriptor) {
  UsbfsNode* node = opened.load(std::memory_order_acquire);
  return node != nullptr && node->owns(descriptor) ? node : nullptr;
}

bool isNode(const char* path) { return path != nullptr && std::strncmp(path, kNodes, std::strlen(kNodes)) == 0; }

int openNode(const char* path) {
  if (std::getenv("EMULATED_USB_DENY") != nullptr) {
    errno = EACCES;
    return -1;
  }
  if (std::strcmp(path, kNode) != 0) {  // of another device, of which there is no more than its place in sysfs
    errno = ENOENT;
    return -1;
  }
  static UsbfsNode* const kOnly = makeNode();
  return kOnly->open();
}

}  // namespace
}  // namespace haptics::test

using haptics::test::isNode;
using haptics::test::next;
using haptics::test::nodeOf;
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
  if (auto* node = nodeOf(descriptor)) return node->ioctl(request, argument);
  static const auto kNext = next<int (*)(int, unsigned long, ...)>("ioctl");
  return kNext(descriptor, request, argument);
}

ssize_t read(int descriptor, void* bytes, size_t count) {
  if (auto* node = nodeOf(descriptor)) return node->read(bytes, count);
  static const auto kNext = next<ssize_t (*)(int, void*, size_t)>("read");
  return kNext(descriptor, bytes, count);
}

off_t lseek(int descriptor, off_t offset, int whence) {
  if (auto* node = nodeOf(descriptor)) return node->seek(offset);
  static const auto kNext = next<off_t (*)(int, off_t, int)>("lseek");
  return kNext(descriptor, offset, whence);
}

off64_t lseek64(int descriptor, off64_t offset, int whence) {
  if (auto* node = nodeOf(descriptor)) return node->seek(offset);
  static const auto kNext = next<off64_t (*)(int, off64_t, int)>("lseek64");
  return kNext(descriptor, offset, whence);
}

int close(int descriptor) {
  if (auto* node = nodeOf(descriptor)) node->closed();
  static const auto kNext = next<int (*)(int)>("close");
  return kNext(descriptor);
}
}
