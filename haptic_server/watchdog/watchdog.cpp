#include "haptic_server/watchdog/watchdog.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <system_error>
#include <utility>

#include "common/clock/monotonic.h"
#include "common/process/spawn.h"
#include "haptic_server/watchdog/death_notice.h"

namespace haptics {
namespace {

/// Before another one is started: nothing at first, then from the one to the other, each time twice as long.
constexpr int kFirstPause_ms = 50, kLongestPause_ms = 1'000;
constexpr std::uint64_t kWell_ns = 10'000'000'000;  // one that lives so long is well
constexpr int kPatience_ms = 1'000;                 // one that has not polled for so long hangs
constexpr int kDismissed_ms = 300;                  // one that is dismissed ends at once, unless it stands still
static_assert(kPatience_ms * 1'000'000ULL >= 5 * WatchPage::kSlowestPoll_ns);

[[nodiscard]] SharedMemory newPage() {
  auto page = SharedMemory::make("watchdog", sizeof(WatchPage));
  if (!page) throw std::bad_alloc();
  std::construct_at(reinterpret_cast<WatchPage*>(page->bytes().data()));
  return *std::move(page);
}

[[nodiscard]] FileHandle copyOf(int descriptor) noexcept {
  return FileHandle(::fcntl(descriptor, F_DUPFD_CLOEXEC, kWatchSocket + 1));
}

[[nodiscard]] std::filesystem::path program() {
  std::error_code error;
  return std::filesystem::read_symlink("/proc/self/exe", error).parent_path() / "haptic_watchdog";
}

/// In a session of its own, deaf to what ends or stops the server's process group; with the server's standard error.
[[nodiscard]] Result<pid_t> start(const Watchdog::Options& options, int socket) {
  return spawn(program(), {.arguments = {options.recordings.string(), std::to_string(options.maxRecordings_bytes)},
                           .descriptors = {-1, STDERR_FILENO, STDERR_FILENO, socket},
                           .ownSession = true,
                           .blockedSignals = {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGTSTP, SIGPIPE, SIGUSR1, SIGUSR2}});
}

}  // namespace

Watchdog::Watchdog(Options options, const FlightRing& ring)
    : options_(std::move(options)),
      page_(newPage()),
      ring_(copyOf(ring.descriptor())),
      quit_(::eventfd(0, EFD_CLOEXEC)) {
  options_.recordings = std::filesystem::absolute(options_.recordings);  // the folder that we are in may go
  (void)startProgram();
  guard_ = std::thread([this] { guard(); });
}

Watchdog::~Watchdog() { dismiss(); }

void Watchdog::dismiss() {
  const std::uint64_t one = 1;
  if (guard_.joinable() && ::write(quit_.descriptor(), &one, sizeof one) == sizeof one) guard_.join();
  say({.kind = WatchOrder::Kind::kDismiss});
  endProgram(kDismissed_ms);
}

/// False, with a warning: there is none.
bool Watchdog::startProgram() {
  std::array<int, 2> ends{-1, -1};
  Result<pid_t> process = refused("", "no socket");
  if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) == 0) {
    const std::lock_guard lock(mutex_);
    socket_ = FileHandle(ends[0]);
    const FileHandle its(ends[1]);
    process = start(options_, its.descriptor());
    if (process) instruct(*process);
  }
  alive_ = process.has_value();
  if (alive_) {
    ++started_;
    saidWhy_ = false;
    return true;
  }
  if (std::exchange(saidWhy_, true)) return false;
  options_.warning("there is no watchdog, and nobody takes the force away should the server hang or be killed: " +
                   process.error().text() + "; trying again");
  return false;
}

void Watchdog::instruct(pid_t process) {
  process_ = process;
  const int socket = socket_.descriptor();
  sendOrder(socket, {.kind = WatchOrder::Kind::kPage}, page_.descriptor());
  sendOrder(
      socket,
      {.kind = WatchOrder::Kind::kRing, .period_ns = static_cast<std::uint64_t>(std::llround(options_.period_s * 1e9))},
      ring_.descriptor());
  if (ending_) sendOrder(socket, {.kind = WatchOrder::Kind::kEnding});
  for (const auto* kept : {&scenes_, &armed_[0], &armed_[1]}) {
    if (*kept) sendOrder(socket, (*kept)->order, (*kept)->descriptor.descriptor());
  }
  setDeathNoticeSocket(socket);
}

/// Waits for a program that was dismissed, has ended or hangs. Kills it if it takes longer.
void Watchdog::endProgram(int patience_ms) {
  const std::lock_guard lock(mutex_);
  if (process_ <= 0) return;
  setDeathNoticeSocket(-1);
  alive_ = false;
  for (int waited_ms = 0; ::waitpid(process_, nullptr, WNOHANG) == 0; ++waited_ms) {
    if (waited_ms >= patience_ms) ::kill(process_, SIGKILL);
    ::usleep(1'000);
  }
  process_ = -1;
  socket_ = {};
}

void Watchdog::say(const WatchOrder& order, int descriptor) noexcept {
  const std::lock_guard lock(mutex_);
  if (socket_) sendOrder(socket_.descriptor(), order, descriptor);
}

void Watchdog::arm(std::uint8_t hand, int node, std::uint8_t out, std::span<const std::uint8_t> zero) noexcept {
  WatchOrder order{.kind = WatchOrder::Kind::kArm, .device = hand, .endpoint = out};
  order.length = static_cast<std::uint8_t>(std::min(zero.size(), order.bytes.size()));
  std::copy_n(zero.begin(), order.length, order.bytes.begin());
  const std::lock_guard lock(mutex_);
  armed_[hand] = Kept{order, copyOf(node)};
  if (socket_) sendOrder(socket_.descriptor(), order, node);
}

void Watchdog::disarm(std::uint8_t hand) noexcept {
  const std::lock_guard lock(mutex_);
  armed_[hand].reset();
  if (socket_) sendOrder(socket_.descriptor(), {.kind = WatchOrder::Kind::kDisarm, .device = hand});
}

void Watchdog::keepScenes(int descriptor) noexcept {
  const WatchOrder order{.kind = WatchOrder::Kind::kScenes};
  const std::lock_guard lock(mutex_);
  scenes_ = Kept{order, copyOf(descriptor)};
  if (socket_) sendOrder(socket_.descriptor(), order, descriptor);
}

void Watchdog::ending() noexcept {
  const std::lock_guard lock(mutex_);
  ending_ = true;
  if (socket_) sendOrder(socket_.descriptor(), {.kind = WatchOrder::Kind::kEnding});
}

void Watchdog::fillStatus(v1::Status& status) const {
  v1::WatchdogStatus& message = *status.mutable_watchdog();
  message.set_alive(alive_);
  message.set_started(started_);
  message.set_forces_taken_away(page().trips.load(std::memory_order_acquire));
}

/// A thread of its own: starts another one each time that one ends, or does not start.
void Watchdog::guard() {
  int pause_ms = 0;
  std::uint64_t started_ns = monotonicNow_ns();
  while (!alive_ || waitForItsEnd()) {
    if (alive_) {
      endProgram(0);
      if (monotonicNow_ns() - started_ns >= kWell_ns) pause_ms = 0;
      options_.warning("the watchdog has ended, or hangs; another one is started " +
                       (pause_ms == 0 ? "at once" : "in " + std::to_string(pause_ms) + " ms"));
    }
    pollfd quit{quit_.descriptor(), POLLIN, 0};
    if (::poll(&quit, 1, pause_ms) > 0) return;
    pause_ms = std::clamp(2 * pause_ms, kFirstPause_ms, kLongestPause_ms);
    started_ns = monotonicNow_ns();
    if (startProgram()) options_.info("another watchdog was started");
  }
}

/// @return False: it is to go.
bool Watchdog::waitForItsEnd() {
  int socket = -1;
  {
    const std::lock_guard lock(mutex_);
    socket = socket_.descriptor();
  }
  std::array<pollfd, 2> polled{pollfd{quit_.descriptor(), POLLIN, 0}, pollfd{socket, 0, 0}};
  for (;;) {
    const std::uint64_t polls = page().polls.load(std::memory_order_relaxed);
    const std::uint64_t asked_ns = monotonicNow_ns();
    const int changes = ::poll(polled.data(), polled.size(), kPatience_ms);
    if (polled[0].revents != 0) return false;
    if (polled[1].revents != 0) return true;
    // Where this thread was held up much longer, so were others.
    const bool asleep = monotonicNow_ns() - asked_ns > 3ULL * kPatience_ms * 1'000'000;
    if (changes == 0 && !asleep && page().polls.load(std::memory_order_relaxed) == polls) return true;
  }
}

}  // namespace haptics
