// --device openhaptics[:NAME]: 3D Systems' Touch and Touch X, and Phantoms, through OpenHaptics, which is in a process of its own
// (openhaptics_host.cpp). openhaptics.md, beside this file, says how it is used.
#include <dlfcn.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <memory>
#include <string>
#include <string_view>
#include <thread>

#include "common/clock/monotonic.h"
#include "common/process/file_handle.h"
#include "haptic_server/device/plugin/vendors/openhaptics_link.h"

extern "C" __attribute__((visibility("default"))) const haptics_device_functions* haptics_device_plugin();

namespace haptics {
namespace {

/// A library may look for its device for long.
constexpr int kHelloWithin_ms = 20'000;
constexpr std::chrono::milliseconds kEndsWithin{500};

/// Beside this library.
[[nodiscard]] std::string hostProgram() {
  Dl_info here{};
  if (::dladdr(reinterpret_cast<const void*>(&haptics_device_plugin), &here) == 0 || here.dli_fname == nullptr)
    return {};
  const std::string_view file = here.dli_fname;
  return std::string(file.substr(0, file.rfind('/') + 1)) + "openhaptics_host";
}

class OpenHaptics {
 public:
  OpenHaptics() = default;
  ~OpenHaptics() {
    if (process_ <= 0) return;
    (void)write({});
    socket_ = FileHandle();  // at which it ends
    for (auto waited = std::chrono::milliseconds(0); waited < kEndsWithin; waited += std::chrono::milliseconds(5)) {
      if (::waitpid(process_, nullptr, WNOHANG) != 0) return;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    ::kill(process_, SIGKILL);
    (void)::waitpid(process_, nullptr, 0);
  }
  OpenHaptics(const OpenHaptics&) = delete;
  OpenHaptics& operator=(const OpenHaptics&) = delete;

  /// Empty, or why not.
  [[nodiscard]] std::string open(const char* name, haptics_device_info& info) {
    int ends[2];
    if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0) return std::strerror(errno);
    socket_ = FileHandle(ends[0]);
    const FileHandle theirs(ends[1]);
    if (const int error = spawn(name, theirs.descriptor()); error != 0)
      return hostProgram() + " cannot be started: " + std::strerror(error);
    return hear(info);
  }

  [[nodiscard]] int read(std::uint64_t timeout_ns, haptics_device_state& state) {
    pollfd ready{socket_.descriptor(), POLLIN, 0};
    const timespec timeout{static_cast<time_t>(timeout_ns / 1'000'000'000),
                           static_cast<long>(timeout_ns % 1'000'000'000)};
    if (::ppoll(&ready, 1, &timeout, nullptr) <= 0) return HAPTICS_DEVICE_NOTHING;
    HostState newest, next;
    bool any = false;
    ssize_t size = 0;
    while ((size = ::recv(ready.fd, &next, sizeof next, MSG_DONTWAIT)) == sizeof next) {
      newest = next;
      any = true;
    }
    if (!any) return size == 0 || errno != EAGAIN ? HAPTICS_DEVICE_GONE : HAPTICS_DEVICE_NOTHING;
    state = newest.state;
    const std::uint64_t now_ns = monotonicNow_ns();
    state.age_us = static_cast<std::uint32_t>((now_ns - std::min(now_ns, newest.measured_ns)) / 1'000);
    return newest.isBroken != 0 ? -1 : HAPTICS_DEVICE_DONE;
  }

  [[nodiscard]] int write(const HostForce& force) {
    if (::send(socket_.descriptor(), &force, sizeof force, MSG_DONTWAIT | MSG_NOSIGNAL) >= 0)
      return HAPTICS_DEVICE_DONE;
    return errno == EAGAIN ? HAPTICS_DEVICE_NOTHING : HAPTICS_DEVICE_GONE;
  }

 private:
  FileHandle socket_;
  pid_t process_ = -1;

  /// 0, or an errno. Its signals are as a program's that a person starts.
  [[nodiscard]] int spawn(const char* name, int theirs) {
    const std::string program = hostProgram();
    char* const arguments[]{const_cast<char*>(program.c_str()), name[0] != 0 ? const_cast<char*>(name) : nullptr,
                            nullptr};
    posix_spawn_file_actions_t files;
    posix_spawnattr_t attributes;
    sigset_t none;
    ::sigemptyset(&none);
    ::posix_spawn_file_actions_init(&files);
    ::posix_spawnattr_init(&attributes);
    ::posix_spawn_file_actions_adddup2(&files, theirs, kHostSocket);
    ::posix_spawnattr_setsigmask(&attributes, &none);
    // A group of its own: Ctrl-C is the server's alone, which takes the force away first.
    ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETPGROUP);
    const int error = ::posix_spawn(&process_, program.c_str(), &files, &attributes, arguments, environ);
    ::posix_spawnattr_destroy(&attributes);
    ::posix_spawn_file_actions_destroy(&files);
    if (error != 0) process_ = -1;
    return error;
  }

  [[nodiscard]] std::string hear(haptics_device_info& info) {
    pollfd ready{socket_.descriptor(), POLLIN, 0};
    HostHello hello;
    if (::poll(&ready, 1, kHelloWithin_ms) <= 0) return "OpenHaptics does not find its device within 20 s";
    if (::recv(ready.fd, &hello, sizeof hello, 0) != sizeof hello)
      return "OpenHaptics ended its process: is the device there, powered and paired?";
    hello.refusal[sizeof hello.refusal - 1] = 0;
    if (hello.refusal[0] != 0) return hello.refusal;
    info = hello.info;
    return {};
  }
};

const char* openDevice(const char* which, void** device, haptics_device_info* info) {
  static std::string reason;
  auto opened = std::make_unique<OpenHaptics>();
  reason = opened->open(which, *info);
  if (!reason.empty()) return reason.c_str();
  *device = opened.release();
  return nullptr;
}

}  // namespace
}  // namespace haptics

const haptics_device_functions* haptics_device_plugin() {
  using haptics::OpenHaptics;
  static const haptics_device_functions functions{
      HAPTICS_DEVICE_ABI,
      haptics::openDevice,
      [](void* device, std::uint64_t timeout_ns, haptics_device_state* state) {
        return static_cast<OpenHaptics*>(device)->read(timeout_ns, *state);
      },
      [](void* device, const double* f, const double*) {
        return static_cast<OpenHaptics*>(device)->write({{f[0], f[1], f[2]}});
      },
      [](void* device) { delete static_cast<OpenHaptics*>(device); },
      nullptr};
  return &functions;
}
