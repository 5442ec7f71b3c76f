#include "haptic_server/device/usb/usb_exchange.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "common/maths/rotation.h"

namespace haptics {
namespace {

constexpr int kOffCommands = 5;  // at the end

void add(std::atomic<std::uint64_t>& counter) noexcept { counter.fetch_add(1, std::memory_order_relaxed); }

/// As often as the bus carries, a whole number of times a servo period.
[[nodiscard]] std::uint64_t exchangePeriod_ns(double servoPeriod_s, double maxRate_Hz) noexcept {
  const double times = std::max(1.0, std::floor(servoPeriod_s * maxRate_Hz + 1e-9));
  return static_cast<std::uint64_t>(std::llround(servoPeriod_s / times * 1e9));
}

}  // namespace

UsbExchange::UsbExchange(UsbBus& bus, UsbPort& port, UsbProtocol& protocol, UsbShared& shared,
                         const UsbDeviceSettings& settings)
    : bus_(bus),
      port_(port),
      protocol_(protocol),
      shared_(shared),
      settings_(settings),
      period_ns_(exchangePeriod_ns(settings.period_s, settings.maxRate_Hz)),
      watch_(bus.clock_ns(), period_ns_, protocol.answersEachCommand()),
      cycleBegan_ns_(bus.clock_ns()) {
  report_.replies = shared.counters.replies.load(std::memory_order_relaxed);
  report_.status = {.homed = false};
}

void UsbExchange::run(const std::atomic<bool>& quit, const std::atomic<bool>& stopped) {
  std::uint64_t deadline_ns = bus_.clock_ns();
  while (!quit) {
    const std::uint64_t now_ns = bus_.clock_ns();
    longestCycle_ns_ = std::max(now_ns - cycleBegan_ns_, longestCycle_ns_ / 2);
    cycleBegan_ns_ = now_ns;
    sendCommand(now_ns, stopped);
    deadline_ns = nextDeadline(deadline_ns);
    const bool there = receiveUntilOrdered(deadline_ns);
    watch_.cycle();
    judge(bus_.clock_ns());
    shared_.reports.put(report_);
    // One that took its force away by itself, as a person's switch has it do, is not the better for being brought up anew.
    const bool absent = report_.state == DeviceState::kAbsent && fault_ != DeviceFault::kForceOff;
    if (!there || (absent && bus_.clock_ns() - faultSince_ns_ > kGiveUp_ns)) break;
  }
  protocol_.setTorque(Vec3(0), 0);
  sendAgain(port_, bus_, protocol_.command(Vec3(0), DeviceLight::kOff), kOffCommands);
  if (hasJumped()) protocol_.invalidateHoming();
  if (fault_ != DeviceFault::kNone) return;
  report_.state = DeviceState::kAbsent;
  report_.status.fault = DeviceFault::kNone;
  shared_.reports.put(report_);
}

/// Once the watchdog has taken the force away there is none before the servo has written again, and has found the fault.
/// @return False: there is to be no force.
bool UsbExchange::handleTrip(std::uint64_t now_ns) {
  if (shared_.watchdog == nullptr) return true;
  const std::uint64_t trips = shared_.watchdog->trips();
  if (trips == shared_.handledTrips.load(std::memory_order_relaxed)) return true;
  if (trips != trips_) tripped_ns_ = now_ns;
  trips_ = trips;
  gain_.cut();
  watch_.raise(DeviceFault::kWatchdog);
  faultSince_ns_ = now_ns;  // the device is well
  if (shared_.orders.newest().written_ns > tripped_ns_) shared_.handledTrips.store(trips, std::memory_order_relaxed);
  return false;
}

void UsbExchange::sendCommand(std::uint64_t now_ns, bool stopped) {
  const DeviceOrder& order = shared_.orders.newest();
  ordered_ns_ = order.written_ns;
  const bool servoAlive = now_ns - std::min(now_ns, order.written_ns) < kServoSilence_ns;
  const bool feelable = handleTrip(now_ns) && report_.state == DeviceState::kReady && !stopped && servoAlive;
  const double gain = gain_.next(!feelable, static_cast<double>(period_ns_) * 1e-9);
  if (!watch_.maySend(now_ns, silenced_)) return;
  const Vec3 force = stopped ? Vec3(0) : gain * protocol_.placement().forceToDevice(order.force_N);
  protocol_.setTorque(stopped ? Vec3(0) : gain * protocol_.placement().forceToDevice(order.torque_Nm),
                      stopped ? 0 : gain * order.grip_Nm);
  const DeviceLight light = report_.state == DeviceState::kHoming  ? DeviceLight::kHoming
                            : report_.state == DeviceState::kReady ? DeviceLight::kReady
                                                                   : DeviceLight::kFault;
  if (port_.send(protocol_.command(force, light)) != UsbOutcome::kDone) return;
  silenced_ = gain <= 0;
  watch_.sent();
  add(shared_.counters.commands);
}

/// Until the deadline, or up to half a period longer while the servo, which is late, has not written: its force would wait
/// for the command after this one. False when the device is gone.
bool UsbExchange::receiveUntilOrdered(std::uint64_t deadline_ns) {
  const std::uint64_t latest_ns = deadline_ns + period_ns_ / 2;
  while (receiveUntil(deadline_ns)) {
    const std::uint64_t now_ns = bus_.clock_ns();
    const std::uint64_t written_ns = shared_.orders.newest().written_ns;
    const bool servoLate = written_ns == ordered_ns_ && now_ns - std::min(now_ns, written_ns) < kServoSilence_ns;
    if (!servoLate || now_ns >= latest_ns) return true;
    deadline_ns = now_ns + kLookAgain_ns;
  }
  return false;
}

/// False when the device is gone.
bool UsbExchange::receiveUntil(std::uint64_t deadline_ns) {
  for (;;) {
    const UsbArrival arrival = port_.next(deadline_ns);
    const std::uint64_t now_ns = bus_.clock_ns();
    switch (arrival.kind) {
      case UsbArrival::Kind::kDeadline:
        return true;
      case UsbArrival::Kind::kGone:
        gone_ = true;
        return false;
      case UsbArrival::Kind::kStalled:
        watch_.raise(DeviceFault::kStalled);
        gone_ = port_.clearStall() == UsbOutcome::kGone;
        if (gone_) return false;
        bus_.sleepUntil(deadline_ns);  // a device that stalls again at once would be asked without end
        return true;
      case UsbArrival::Kind::kFailed:
        watch_.garbled(now_ns);
        bus_.sleepUntil(std::min(deadline_ns, now_ns + kLookAgain_ns));  // it may fail again at once, without end
        break;
      case UsbArrival::Kind::kBytes:
        if (protocol_.take(arrival.bytes, [&](const DeviceReply& reply) { take(reply, now_ns); })) {
          watch_.garbled(now_ns);
          add(shared_.counters.garbled);
        }
    }
  }
}

void UsbExchange::take(const DeviceReply& reply, std::uint64_t now_ns) {
  const auto position = protocol_.locate(reply);
  if (!position) {  // counts that no pose has: a reply that was damaged on its way
    watch_.garbled(now_ns);
    add(shared_.counters.garbled);
    return;
  }
  watch_.reply(now_ns);
  if (reply.forceOff) watch_.raise(DeviceFault::kForceOff);
  watchHoming(reply);
  if (homedReplies_ >= kHomedReplies) watchMove(*position, protocol_.rotation(), now_ns);
  add(shared_.counters.replies);
  report_.position = protocol_.placement().toWorld(*position);
  report_.rotation = protocol_.placement().toWorld(protocol_.rotation());
  report_.handle = protocol_.placement().toWorld(protocol_.handle());
  report_.arrived_ns = now_ns - std::min(now_ns, std::uint64_t{1'000} * reply.age_us);
  report_.replies = shared_.counters.replies.load(std::memory_order_relaxed);
  report_.status.homedAxes = reply.homedAxes;
  report_.status.buttons = reply.buttons;
  judge(now_ns);
  shared_.reports.put(report_);
}

/// Coordinates jump at homing, and one reply's word is not enough: a bit may be wrong.
void UsbExchange::watchHoming(const DeviceReply& reply) {
  if (reply.homedAxes == kAllAxes) {
    if (homedReplies_ < kHomedReplies && ++homedReplies_ == kHomedReplies) {
      settings_.info(protocol_.info().name + " is homed");
      position_.reset();
      velocity_ = Vec3(0);
      jumped_ = jumped_rad_ = Vec3(0);
      homingLost_ = false;
    }
    return;
  }
  if (homedReplies_ >= kHomedReplies) homingLost_ = true;
  homedReplies_ = 0;
  if (!guided_) settings_.info("homing: " + std::string(protocol_.homingGuide()));
  guided_ = true;
}

void UsbExchange::watchMove(Vec3 to, Quat rotation, std::uint64_t now_ns) noexcept {
  if (position_) {
    // After the driver was held up, replies that lay waiting come in one go.
    const std::uint64_t elapsed_ns =
        std::max({period_ns_, now_ns - positioned_ns_, now_ns - cycleBegan_ns_, longestCycle_ns_});
    const double elapsed_s = static_cast<double>(elapsed_ns) * 1e-9;
    const Vec3 move = to - *position_;
    const Vec3 change = move - elapsed_s * velocity_;
    if (glm::length(move) > kMaxSpeed_m_per_s * elapsed_s ||
        glm::length(change) > std::max(kSameAgain_m, kMaxChange_m_per_s2 * elapsed_s * elapsed_s)) {
      jumped_ += change;
    } else {
      velocity_ = move / elapsed_s;
    }
    const Vec3 turn = rotationVector(rotation * glm::conjugate(rotation_));
    if (glm::length(turn) > kMaxTurn_rad_per_s * elapsed_s) jumped_rad_ += turn;
  }
  position_ = to;
  rotation_ = rotation;
  positioned_ns_ = now_ns;
  if (hasJumped()) watch_.raise(DeviceFault::kJumped);
}

bool UsbExchange::hasJumped() const noexcept {
  return glm::length(jumped_) > kSameAgain_m || glm::length(jumped_rad_) > kSameAgain_rad;
}

void UsbExchange::judge(std::uint64_t now_ns) {
  DeviceFault judged = gone_ ? DeviceFault::kUnplugged : watch_.judge(now_ns);
  if (judged == DeviceFault::kNone && homingLost_) judged = DeviceFault::kHomingLost;
  const bool homed = homedReplies_ >= kHomedReplies;
  if (judged != fault_) {
    if (judged != DeviceFault::kNone) {
      settings_.warning(protocol_.info().name + ": " + inWords(judged));
      add(shared_.counters.faults);
      if (report_.state != DeviceState::kAbsent) faultSince_ns_ = now_ns;
      guided_ = false;
    } else {
      settings_.info(protocol_.info().name + " works again");
    }
    fault_ = judged;
  }
  report_.status.fault = fault_;
  report_.status.homed = homed;
  const bool exchanging = fault_ == DeviceFault::kNone || fault_ == DeviceFault::kHomingLost;
  report_.state = !exchanging ? DeviceState::kAbsent : homed ? DeviceState::kReady : DeviceState::kHoming;
}

/// A period after the last one, drawn gently to kAfterServo_ns after the servo writes.
std::uint64_t UsbExchange::nextDeadline(std::uint64_t last_ns) noexcept {
  const std::uint64_t now_ns = bus_.clock_ns();
  auto next = static_cast<std::int64_t>(last_ns + period_ns_);
  if (next <= static_cast<std::int64_t>(now_ns)) next = static_cast<std::int64_t>(now_ns + period_ns_);
  const std::uint64_t written_ns = shared_.orders.newest().written_ns;
  if (written_ns != 0) {
    const auto period = static_cast<std::int64_t>(period_ns_);
    std::int64_t off = (next - static_cast<std::int64_t>(written_ns) - kAfterServo_ns) % period;
    if (off > period / 2) off -= period;
    if (off < -period / 2) off += period;
    constexpr std::int64_t kSoftness = 8;
    next -= off / kSoftness;
  }
  return static_cast<std::uint64_t>(next);
}

}  // namespace haptics
