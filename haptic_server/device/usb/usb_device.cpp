#include "haptic_server/device/usb/usb_device.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "haptic_server/device/usb/choose_device.h"
#include "haptic_server/device/usb/usb_exchange.h"

namespace haptics {
namespace {

constexpr std::uint64_t kRetry_ns = 500'000'000;  // between looks for a device that is not there
constexpr std::uint64_t kNap_ns = 50'000'000;     // between looks whether to stop

}  // namespace

UsbDevice::UsbDevice(UsbBus& bus, std::unique_ptr<UsbProtocol> protocol, UsbDeviceSettings settings)
    : bus_(bus), protocol_(std::move(protocol)), settings_(std::move(settings)) {}

UsbDevice::~UsbDevice() {
  stop();
  quit_ = true;
  if (thread_.joinable()) thread_.join();
}

void UsbDevice::start(std::function<void()> become) {
  thread_ = std::thread([this, become = std::move(become)] {
    become();
    drive(quit_);
  });
}

void UsbDevice::drive(const std::atomic<bool>& stop) {
  DeviceFault last = DeviceFault::kNone;
  const auto wait = [&](std::uint64_t time_ns) {
    const std::uint64_t until_ns = bus_.clock_ns() + time_ns;
    while (!stop && bus_.clock_ns() < until_ns) bus_.sleepUntil(std::min(until_ns, bus_.clock_ns() + kNap_ns));
  };
  const auto absent = [&](const UsbRefusal& refusal) {
    const std::uint64_t connections = shared_.counters.connections.load(std::memory_order_relaxed);
    const bool unplugged = refusal.fault == DeviceFault::kNotFound && connections > 0;
    shared_.reports.put({.status = {.fault = unplugged ? DeviceFault::kUnplugged : refusal.fault, .homed = false},
                         .replies = shared_.counters.replies.load(std::memory_order_relaxed)});
    if (refusal.fault != last) {  // the same one again is no news
      settings_.warning(unplugged ? info().name + " may be plugged in again at any time" : refusal.error.text());
    }
    last = refusal.fault;
    wait(kRetry_ns);
  };
  while (!stop) {
    const auto place = chooseDevice(bus_.list(protocol_->model()), settings_.wanted, info().name);
    if (!place) {
      absent(place.error());
      continue;
    }
    auto port = bus_.open(protocol_->model(), *place);
    if (!port) {
      absent(port.error());
      continue;
    }
    if (const auto refusal = protocol_->start(**port, bus_)) {
      absent(*refusal);
      continue;
    }
    last = DeviceFault::kNone;
    // Plugged in again, it has another address; the same one is meant.
    settings_.wanted = place->serial.empty() ? place->path : place->serial;
    shared_.counters.connections.fetch_add(1, std::memory_order_relaxed);
    settings_.info(info().name + " at " + (place->bus == 0 ? "" : "USB ") + describe(*place) + " works");
    const bool watched = shared_.watchdog != nullptr && (*port)->descriptor() >= 0;
    if (watched) {
      shared_.watchdog->arm((*port)->descriptor(), protocol_->model().out,
                            protocol_->command(Vec3(0), DeviceLight::kFault));
    }
    UsbExchange(bus_, **port, *protocol_, shared_, settings_).run(stop, stopped_);
    if (watched) shared_.watchdog->disarm();
    port->reset();
    wait(kRetry_ns / 2);
  }
}

DeviceReading UsbDevice::read(std::uint64_t) noexcept {
  const DeviceReport& report = shared_.reports.newest();
  DeviceReading reading{report.position,           report.state, report.status, report.rotation,
                        report.handle.gripper_rad, report.handle};
  if (shared_.watchdog != nullptr &&
      shared_.watchdog->trips() != shared_.handledTrips.load(std::memory_order_relaxed)) {
    reading.state = DeviceState::kAbsent;
    reading.status.fault = DeviceFault::kWatchdog;
  }
  if (stopped_.load(std::memory_order_relaxed)) reading.state = DeviceState::kStopped;
  const std::uint64_t age_us = (std::max(bus_.clock_ns(), report.arrived_ns) - report.arrived_ns) / 1'000;
  reading.status.age_us =
      static_cast<std::uint32_t>(std::min<std::uint64_t>(age_us, std::numeric_limits<std::uint32_t>::max()));
  if (report.replies != repliesRead_) {
    repliesRead_ = report.replies;
    shared_.counters.used.fetch_add(1, std::memory_order_relaxed);
  }
  return reading;
}

void UsbDevice::write(Vec3 force_N) noexcept {
  if (!stopped_.load(std::memory_order_relaxed)) {
    shared_.orders.put({isFinite(force_N) ? force_N : Vec3(0), torque_Nm_, grip_Nm_, bus_.clock_ns()});
  }
}

void UsbDevice::stop() noexcept { stopped_ = true; }

}  // namespace haptics
