#include "haptic_server/watchdog/watchdog.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <new>
#include <system_error>
#include <utility>

#include "common/clock/monotonic.h"
#include "haptic_server/watchdog/death_notice.h"

namespace haptics {
namespace {

/// One that ends sooner after its start is not started again.
constexpr std::uint64_t kSoon_ns = 1'000'000'000;
/// One that has not looked for so long hangs.
constexpr int kPatience_ms = 1'000;
static_assert(kPatience_ms * 1'000'000ULL >= 5 * WatchPage::kSlowestLook_ns);

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
/// @return Its process, or a negative error number.
[[nodiscard]] pid_t spawn(const std::filesystem::path& file, const std::string& recordings, int socket) {
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&files, STDERR_FILENO, STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&files, socket, kWatchSocket);
  posix_spawn_file_actions_addclosefrom_np(&files, kWatchSocket + 1);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGTSTP, SIGPIPE, SIGUSR1, SIGUSR2}) {
    sigaddset(&signals, signal);
  }
  posix_spawnattr_setsigmask(&attributes, &signals);
  sigfillset(&signals);
  posix_spawnattr_setsigdefault(&attributes, &signals);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETSID);

  std::string path = file.string(), folder = recordings;
  const std::array<char*, 3> arguments{path.data(), folder.data(), nullptr};
  pid_t process = 0;
  const int error = posix_spawn(&process, path.c_str(), &files, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  return error == 0 ? process : -error;
}

}  // namespace

Watchdog::Watchdog(Options options, const FlightRing& ring)
    : options_(std::move(options)),
      page_(newPage()),
      ring_(copyOf(ring.descriptor())),
      quit_(::eventfd(0, EFD_CLOEXEC)) {
  if (startProgram()) guard_ = std::thread([this] { guard(); });
}

Watchdog::~Watchdog() {
  const std::uint64_t one = 1;
  if (guard_.joinable() && ::write(quit_.descriptor(), &one, sizeof one) == sizeof one) guard_.join();
  say({.kind = WatchOrder::Kind::kBye});
  endProgram(kPatience_ms);
}

/// False, with a warning: there is none.
bool Watchdog::startProgram() {
  std::array<int, 2> ends;
  const std::filesystem::path file = program();
  pid_t process = -1;
  if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) == 0) {
    const std::lock_guard lock(mutex_);
    socket_ = FileHandle(ends[0]);
    const FileHandle its(ends[1]);
    process_ = process = spawn(file, std::filesystem::absolute(options_.recordings).string(), its.descriptor());
    if (process > 0) {
      sendOrder(ends[0], {.kind = WatchOrder::Kind::kPage}, page_.descriptor());
      sendOrder(ends[0],
                {.kind = WatchOrder::Kind::kRing,
                 .period_ns = static_cast<std::uint64_t>(std::llround(options_.period_s * 1e9))},
                ring_.descriptor());
      if (ending_) sendOrder(ends[0], {.kind = WatchOrder::Kind::kEnding});
      for (const auto* kept : {&scenes_, &held_}) {
        if (*kept) sendOrder(ends[0], (*kept)->order, (*kept)->descriptor.descriptor());
      }
      tellDeathTo(ends[0]);
    }
  } else {
    process = -errno;
  }
  alive_ = process > 0;
  if (process > 0) {
    ++started_;
    return true;
  }
  options_.warning("there is no watchdog, and nobody takes the force away should the server hang or be killed: " +
                   file.string() + ": " + std::generic_category().message(-process));
  return false;
}

/// Of one that was told to go, that has ended, or that hangs. Kills it if it takes longer.
void Watchdog::endProgram(int patience_ms) {
  const std::lock_guard lock(mutex_);
  if (process_ <= 0) return;
  tellDeathTo(-1);
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

void Watchdog::hold(int node, std::uint8_t out, std::span<const std::uint8_t> zero) noexcept {
  WatchOrder order{.kind = WatchOrder::Kind::kHold, .endpoint = out};
  order.length = static_cast<std::uint8_t>(std::min(zero.size(), order.bytes.size()));
  std::copy_n(zero.begin(), order.length, order.bytes.begin());
  const std::lock_guard lock(mutex_);
  held_ = Kept{order, copyOf(node)};
  if (socket_) sendOrder(socket_.descriptor(), order, node);
}

void Watchdog::letGo() noexcept {
  const std::lock_guard lock(mutex_);
  held_.reset();
  if (socket_) sendOrder(socket_.descriptor(), {.kind = WatchOrder::Kind::kLetGo});
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
  message.set_forces_taken_away(spoken());
}

/// A thread of its own: starts another one each time that one ends.
void Watchdog::guard() {
  std::uint64_t started_ns = 0;  // again
  while (waitForItsEnd()) {
    endProgram(0);
    const std::uint64_t now_ns = monotonicNow_ns();
    if (now_ns - std::exchange(started_ns, now_ns) < kSoon_ns) {
      options_.warning(
          "the watchdog ended again at once: there is none from here on, and nobody takes the force away "
          "should the server hang or be killed");
      return;
    }
    options_.warning("the watchdog has ended, or hangs");
    if (!startProgram()) return;
    options_.info("another watchdog was started");
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
    const std::uint64_t looks = page().looks.load(std::memory_order_relaxed);
    const std::uint64_t asked_ns = monotonicNow_ns();
    const int changes = ::poll(polled.data(), polled.size(), kPatience_ms);
    if (polled[0].revents != 0) return false;
    if (polled[1].revents != 0) return true;
    // Where this thread was held up much longer, so were others.
    const bool asleep = monotonicNow_ns() - asked_ns > 3ULL * kPatience_ms * 1'000'000;
    if (changes == 0 && !asleep && page().looks.load(std::memory_order_relaxed) == looks) return true;
  }
}

}  // namespace haptics
