#include "haptic_server/watchdog/death_notice.h"

#include <signal.h>

#include <atomic>
#include <cerrno>

#include "haptic_server/watchdog/watch_order.h"

namespace haptics {
namespace {

std::atomic<int> watchdog{-1};
std::atomic<std::atomic<std::uint32_t>*> crashed{nullptr};
static_assert(std::atomic<int>::is_always_lock_free && std::atomic<std::uint32_t>::is_always_lock_free);
static_assert(std::atomic<std::atomic<std::uint32_t>*>::is_always_lock_free);

/// Only what may be done in a signal handler. The signal then has its ordinary effect.
void dying(int signal) {
  const int before = errno;
  if (auto* flag = crashed.load(std::memory_order_relaxed)) flag->store(1);
  if (const int socket = watchdog.load(std::memory_order_relaxed); socket >= 0) {
    sendOrder(socket, {.kind = WatchOrder::Kind::kDying});
  }
  errno = before;
  raise(signal);  // blocked until this returns
}

void install() noexcept {
  for (const int signal : {SIGABRT, SIGSEGV, SIGBUS, SIGFPE, SIGILL}) {
    struct sigaction action {};
    if (sigaction(signal, nullptr, &action) != 0 || action.sa_handler != SIG_DFL) continue;
    action.sa_handler = &dying;
    action.sa_flags = static_cast<int>(SA_RESETHAND) | SA_ONSTACK;
    sigaction(signal, &action, nullptr);
  }
}

}  // namespace

void setDeathNoticeSocket(int socket) noexcept {
  watchdog.store(socket, std::memory_order_relaxed);
  if (socket >= 0) install();
}

void setCrashFlag(std::atomic<std::uint32_t>* flag) noexcept {
  crashed.store(flag, std::memory_order_relaxed);
  if (flag != nullptr) install();
}

}  // namespace haptics
