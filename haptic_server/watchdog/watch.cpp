#include "haptic_server/watchdog/watch.h"

#include <linux/usbdevice_fs.h>
#include <poll.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <utility>

#include "common/clock/monotonic.h"
#include "haptic_server/recording/last_seconds.h"

namespace haptics {
namespace {

/// A command that the device does not take for so long is of no use.
constexpr unsigned kSendTimeOut_ms = 10;

[[nodiscard]] timespec spanOf(std::uint64_t time_ns) noexcept {
  return {static_cast<time_t>(time_ns / 1'000'000'000), static_cast<long>(time_ns % 1'000'000'000)};
}

[[nodiscard]] std::string inMilliseconds(std::uint64_t time_ns) {
  return std::to_string(time_ns / 1'000'000) + '.' + std::to_string(time_ns / 100'000 % 10) + " ms";
}

}  // namespace

void Watch::run() {
  while (waitForOrders()) {
    if (monotonicNow_ns() >= nextLook_ns_) look();
  }
  if (!bye_) outlive();
}

/// @return False: the server has ended, or wants no watchdog any more.
bool Watch::waitForOrders() {
  const std::uint64_t now_ns = monotonicNow_ns();
  const timespec left = spanOf(nextLook_ns_ > now_ns ? nextLook_ns_ - now_ns : 0);
  pollfd server{socket_, POLLIN, 0};
  if (ppoll(&server, 1, &left, nullptr) <= 0) return true;
  return takeOrders();
}

bool Watch::takeOrders() {
  bool ended = false;
  while (auto received = receiveOrder(socket_, ended)) take(*std::move(received));
  return !ended && !bye_;
}

void Watch::take(ReceivedOrder received) {
  const WatchOrder& order = received.order;
  switch (order.kind) {
    case WatchOrder::Kind::kPage:
      if (auto page = SharedMemory::map(std::move(received.descriptor), sizeof(WatchPage))) page_ = *std::move(page);
      break;
    case WatchOrder::Kind::kRing: {
      silentLooks_ = std::max(kSilentLooks, (kSilentPeriods * order.period_ns + kLook_ns - 1) / kLook_ns);
      auto ring = FlightRing::attach(std::move(received.descriptor));
      if (!ring) return options_.warning("the watchdog cannot see the servo: " + ring.error().text());
      ring_.emplace(*std::move(ring));
      (void)mlockall(MCL_CURRENT);  // as far as it is permitted
      break;
    }
    case WatchOrder::Kind::kScenes:
      scenes_ = std::move(received.descriptor);
      break;
    case WatchOrder::Kind::kHold:
      held_ = Held{std::move(received.descriptor), order.endpoint,
                   std::min<std::uint8_t>(order.length, sizeof order.bytes), order.bytes};
      end_ = ring_ ? ring_->end() : 0;
      silent_ = 0;
      nextLook_ns_ = 0;
      break;
    case WatchOrder::Kind::kLetGo:
      held_.reset();
      speaking_ = false;
      break;
    case WatchOrder::Kind::kEnding:
      ending_ = true;
      break;
    case WatchOrder::Kind::kDying:
      speak("the server is about to end");
      break;
    case WatchOrder::Kind::kBye:
      bye_ = true;
  }
}

void Watch::look() {
  nextLook_ns_ = monotonicNow_ns() + (looksNow() ? kLook_ns : WatchPage::kSlowestLook_ns);
  if (page_) page().looks.fetch_add(1, std::memory_order_relaxed);
  if (!looksNow()) return;
  if (words_ > 0) {
    --words_;
    sendZero();
  }
  if (const std::uint64_t end = ring_->end(); end != end_) {
    if (std::exchange(speaking_, false)) options_.info("the servo ticks again");
    end_ = end;
    silent_ = 0;
    return;
  }
  ++silent_;
  if (speaking_) {
    if (silent_ % kLooksBetweenWords == 0) sendZero();
  } else if (end_ > 0 && silent_ >= silentLooks_) {
    speak("the servo stands still");
  }
}

/// Takes the force away. The driver hears of it first: it would push again. When the servo was told to stop there is
/// nothing to say.
void Watch::speak(const std::string& why) {
  if (!held_ || speaking_) return;
  speaking_ = true;
  words_ = kWords - 1;
  if (page_ && !ending_) page().spoken.fetch_add(1, std::memory_order_seq_cst);
  sendZero();
  if (!ending_) options_.warning(why + ": the watchdog has taken the force away");
}

/// One transfer that waits for its end. libusb would have to reap it, and with it those that the server has submitted on
/// the same descriptor, whose bytes the system then writes where the server wanted them: here, another process's memory.
/// An interrupt endpoint takes it too.
void Watch::sendZero() {
  if (!held_) return;
  usbdevfs_bulktransfer transfer{held_->endpoint, held_->length, kSendTimeOut_ms, held_->bytes.data()};
  (void)ioctl(held_->node.descriptor(), USBDEVFS_BULK, &transfer);  // one that was unplugged has no force
}

/// The server has ended without a word.
void Watch::outlive() {
  const std::uint64_t noticed_ns = monotonicNow_ns();
  if (held_) {
    speaking_ = true;
    for (std::uint64_t i = 0; i < kWords; ++i) {
      if (i > 0) {
        const timespec pause = spanOf(kBetweenWords_ns);
        nanosleep(&pause, nullptr);
      }
      sendZero();
    }
    held_.reset();  // a server that is started anew may have the device
  }
  const sched_param ordinary{};
  sched_setscheduler(0, SCHED_OTHER, &ordinary);
  munlockall();
  if (!ring_ || !scenes_) return options_.warning("the server has ended without a word");
  ring_->outlive();
  RecordedTick last;
  const std::uint64_t end = ring_->end();
  const bool ticked = end > 0 && ring_->read(end - 1, last);
  options_.warning("the server has ended without a word" +
                   (ticked ? ", " + inMilliseconds(noticed_ns - std::min(noticed_ns, last.input.time_ns)) +
                                 " after the servo's last tick"
                           : ""));
  if (!ticked) return;
  if (const auto file = recordCrash(options_.recordings, *ring_, scenes_->descriptor())) {
    options_.info("its last " + std::to_string(static_cast<int>(FlightRing::kSeconds)) + " s are in " + file->string() +
                  " (crash)");
  } else {
    options_.warning("its last seconds could not be kept: " + file.error().text());
  }
}

}  // namespace haptics
