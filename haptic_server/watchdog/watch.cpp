#include "haptic_server/watchdog/watch.h"

#include <linux/usbdevice_fs.h>
#include <poll.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/mman.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <ctime>
#include <thread>
#include <utility>

#include "common/clock/monotonic.h"
#include "haptic_server/recording/last_seconds.h"

namespace haptics {
namespace {

constexpr unsigned kSendTimeOut_ms = 10;  // a command that the device does not take for so long is of no use

[[nodiscard]] std::string inMilliseconds(std::uint64_t time_ns) {
  return std::to_string(time_ns / 1'000'000) + '.' + std::to_string(time_ns / 100'000 % 10) + " ms";
}

}  // namespace

void Watch::run() {
  while (waitForOrders()) {
    if (monotonicNow_ns() >= nextPoll_ns_) poll();
  }
  if (!dismissed_) handleServerDeath();
}

/// @return False: the server has ended, or wants no watchdog any more.
bool Watch::waitForOrders() {
  const std::uint64_t now_ns = monotonicNow_ns();
  const std::uint64_t left_ns = nextPoll_ns_ > now_ns ? nextPoll_ns_ - now_ns : 0;
  const timespec left{static_cast<time_t>(left_ns / 1'000'000'000), static_cast<long>(left_ns % 1'000'000'000)};
  pollfd server{socket_, POLLIN, 0};
  if (ppoll(&server, 1, &left, nullptr) <= 0) return true;
  bool ended = false;
  while (auto received = receiveOrder(socket_, ended)) take(*std::move(received));
  return !ended && !dismissed_;
}

void Watch::take(ReceivedOrder received) {
  const WatchOrder& order = received.order;
  switch (order.kind) {
    case WatchOrder::Kind::kPage:
      if (auto page = SharedMemory::map(std::move(received.descriptor), sizeof(WatchPage))) page_ = *std::move(page);
      break;
    case WatchOrder::Kind::kRing: {
      hangsAfterPolls_ = std::max(kMissedPolls, (kSilentPeriods * order.period_ns + kPoll_ns - 1) / kPoll_ns);
      auto ring = FlightRing::attach(std::move(received.descriptor));
      if (!ring) return options_.warning("the watchdog cannot see the servo: " + ring.error().text());
      ring_.emplace(*std::move(ring));
      (void)mlockall(MCL_CURRENT);  // as far as it is permitted
      break;
    }
    case WatchOrder::Kind::kScenes:
      scenes_ = std::move(received.descriptor);
      break;
    case WatchOrder::Kind::kArm:
      armed_[order.device % kMaxHands] = Armed{std::move(received.descriptor), order.endpoint,
                                               std::min<std::uint8_t>(order.length, sizeof order.bytes), order.bytes};
      end_ = ring_ ? ring_->end() : 0;
      pollsWithoutTick_ = 0;
      nextPoll_ns_ = 0;
      break;
    case WatchOrder::Kind::kDisarm:
      armed_[order.device % kMaxHands].reset();
      tripped_ = tripped_ && isArmed();
      break;
    case WatchOrder::Kind::kEnding:
      ending_ = true;
      break;
    case WatchOrder::Kind::kDying:
      trip("the server is about to end");
      break;
    case WatchOrder::Kind::kDismiss:
      dismissed_ = true;
  }
}

void Watch::poll() {
  nextPoll_ns_ = monotonicNow_ns() + (isWatching() ? kPoll_ns : WatchPage::kSlowestPoll_ns);
  if (page_) page().polls.fetch_add(1, std::memory_order_relaxed);
  if (!isWatching()) return;
  if (commandsLeft_ > 0) {
    --commandsLeft_;
    sendZeroForce();
  }
  if (const std::uint64_t end = ring_->end(); end != end_) {
    if (std::exchange(tripped_, false)) options_.info("the servo ticks again");
    end_ = end;
    pollsWithoutTick_ = 0;
    return;
  }
  ++pollsWithoutTick_;
  if (tripped_) {
    if (pollsWithoutTick_ % kPollsBetweenCommands == 0) sendZeroForce();
  } else if (end_ > 0 && pollsWithoutTick_ >= hangsAfterPolls_) {
    trip("the servo stands still");
  }
}

/// Takes the force away. The driver hears of it first: it would push again. Where the servo stops on
/// request nothing is reported.
void Watch::trip(const std::string& why) {
  if (!isArmed() || tripped_) return;
  tripped_ = true;
  commandsLeft_ = kZeroCommands - 1;
  if (page_ && !ending_) page().trips.fetch_add(1, std::memory_order_seq_cst);
  sendZeroForce();
  if (!ending_) options_.warning(why + ": the watchdog has taken the force away");
}

/// One transfer that waits for its end. libusb would have to reap it, and with it those that the server has submitted on
/// the same descriptor, whose bytes the system then writes where the server wanted them: here, another process's memory.
/// An interrupt endpoint takes it too.
void Watch::sendZeroForce() {
  for (auto& armed : armed_) {
    if (!armed) continue;
    usbdevfs_bulktransfer transfer{armed->endpoint, armed->length, kSendTimeOut_ms, armed->bytes.data()};
    (void)ioctl(armed->node.descriptor(), USBDEVFS_BULK, &transfer);  // one that was unplugged has no force
  }
}

void Watch::handleServerDeath() {
  const std::uint64_t noticed_ns = monotonicNow_ns();
  if (isArmed()) {
    tripped_ = true;
    for (std::uint64_t i = 0; i < kZeroCommands; ++i) {
      if (i > 0) std::this_thread::sleep_for(std::chrono::nanoseconds(kBetweenCommands_ns));
      sendZeroForce();
    }
    armed_ = {};  // a server that is started anew may have the devices
  }
  const sched_param ordinary{};
  sched_setscheduler(0, SCHED_OTHER, &ordinary);
  munlockall();
  if (!ring_ || !scenes_) return options_.warning("the server has ended without a word");
  ring_->releaseDeadWriter();
  RecordedTick last;  // of the first hand
  const std::uint64_t end = ring_->end();
  const bool ticked = end > 0 && ring_->read(end - 1, {&last, 1});
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
