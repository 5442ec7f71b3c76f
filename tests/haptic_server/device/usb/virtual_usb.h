#pragma once

#include <algorithm>
#include <array>
#include <functional>
#include <list>
#include <memory>
#include <vector>

#include "haptic_server/device/usb/usb_port.h"
#include "tests/haptic_server/device/emulated/usb_model.h"

namespace haptics::test {

/// A bus in virtual time with at most a few emulated devices. Whoever waits on it moves time on; `onTime` is called at
/// each instant that it asked for and says when to call it next.
class VirtualUsb final : public UsbBus {
 public:
  struct Plugged {
    UsbPlace place;
    EmulatedUsb* device = nullptr;
    bool present = true;
    bool permitted = true;
  };

  std::uint64_t now_ns = 1'000'000'000;
  std::vector<Plugged> plugged;
  std::function<std::uint64_t(std::uint64_t now_ns)> onTime;
  std::uint64_t nextTime_ns = 0;

  std::uint64_t clock_ns() noexcept override { return now_ns; }
  void sleepUntil(std::uint64_t time_ns) override { advanceTo(time_ns); }
  std::vector<UsbPlace> list(const UsbModel&) override {
    std::vector<UsbPlace> places;
    for (const Plugged& p : plugged) {
      if (p.present) places.push_back(p.place);
    }
    return places;
  }
  tl::expected<std::unique_ptr<UsbPort>, UsbRefusal> open(const UsbModel& model, const UsbPlace& place) override;

  void advanceTo(std::uint64_t time_ns) {
    while (onTime && nextTime_ns <= time_ns) {
      now_ns = std::max(now_ns, nextTime_ns);
      nextTime_ns = onTime(now_ns);
    }
    now_ns = std::max(now_ns, time_ns);
  }
};

/// As a real port over usbfs: packets are taken from the device in the order in which transfers were posted, of which
/// four are under way.
class VirtualPort final : public UsbPort {
 public:
  VirtualPort(VirtualUsb& bus, VirtualUsb::Plugged& plugged) : bus_(bus), plugged_(plugged) {
    for (auto& posted_ns : posted_) posted_ns = bus.now_ns;
  }

  UsbOutcome control(const UsbRequest& request) override {
    bus_.advanceTo(bus_.now_ns + 125'000);
    if (!plugged_.present) return UsbOutcome::kGone;
    const int result = plugged_.device->control(request.type, request.request, request.value, bus_.now_ns);
    return result >= 0 ? UsbOutcome::kDone : UsbOutcome::kStalled;
  }
  UsbOutcome send(std::span<const std::uint8_t> bytes) override {
    if (!plugged_.present) return UsbOutcome::kGone;
    static_cast<void>(plugged_.device->out(bytes, bus_.now_ns));
    return UsbOutcome::kDone;
  }
  UsbArrival next(std::uint64_t deadline_ns) override {
    for (;;) {
      if (!plugged_.present) return {UsbArrival::Kind::kGone, {}};
      const auto ready_ns = plugged_.device->inReadyAt(posted_.front());
      const std::uint64_t next_ns = std::min(ready_ns.value_or(deadline_ns + 1), bus_.nextTime_ns);
      if (ready_ns && *ready_ns <= bus_.now_ns) return take();
      if (next_ns > deadline_ns) {
        bus_.advanceTo(deadline_ns);
        return plugged_.present ? UsbArrival{} : UsbArrival{UsbArrival::Kind::kGone, {}};
      }
      bus_.advanceTo(std::max(next_ns, bus_.now_ns));
    }
  }
  UsbOutcome clearStall() override {
    if (!plugged_.present) return UsbOutcome::kGone;
    plugged_.device->clearHalt();
    return UsbOutcome::kDone;
  }
  int descriptor() const noexcept override { return 0; }  // there is one for the watchdog, which looks at no number

 private:
  UsbArrival take() {
    const int length = plugged_.device->in(bytes_, bus_.now_ns);
    std::rotate(posted_.begin(), posted_.begin() + 1, posted_.end());
    posted_.back() = bus_.now_ns;
    if (length < 0) return {UsbArrival::Kind::kStalled, {}};
    return {UsbArrival::Kind::kBytes, {bytes_.data(), static_cast<std::size_t>(length)}};
  }

  VirtualUsb& bus_;
  VirtualUsb::Plugged& plugged_;
  std::array<std::uint64_t, 4> posted_{};
  std::array<std::uint8_t, 64> bytes_{};
};

inline tl::expected<std::unique_ptr<UsbPort>, UsbRefusal> VirtualUsb::open(const UsbModel&, const UsbPlace& place) {
  const auto found = std::ranges::find_if(plugged, [&](const Plugged& p) { return p.place.path == place.path; });
  if (found == plugged.end() || !found->present) {
    return tl::unexpected(UsbRefusal{DeviceFault::kNotFound, {place.path, "went away"}});
  }
  if (!found->permitted) return tl::unexpected(UsbRefusal{DeviceFault::kNotPermitted, {place.path, "no permission"}});
  return std::make_unique<VirtualPort>(*this, *found);
}

}  // namespace haptics::test
