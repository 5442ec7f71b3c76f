#include "haptic_server/device/usb/choose_device.h"

#include <algorithm>
#include <cstdio>

namespace haptics {
namespace {

[[nodiscard]] std::string listed(std::span<const UsbPlace> places) {
  std::string text;
  for (const UsbPlace& place : places) text += (text.empty() ? "" : ", ") + describe(place);
  return text;
}

}  // namespace

std::string addressOf(const UsbPlace& place) {
  char text[16];
  std::snprintf(text, sizeof text, "%03u/%03u", place.bus, place.address);
  return text;
}

std::string describe(const UsbPlace& place) {
  if (place.bus == 0) return place.path;
  return addressOf(place) + " (port " + place.path + (place.serial.empty() ? "" : ", serial " + place.serial) + ")";
}

tl::expected<UsbPlace, UsbRefusal> chooseDevice(std::span<const UsbPlace> places, std::string_view wanted,
                                                const std::string& title) {
  const auto refuse = [](DeviceFault fault, std::string reason) {
    return tl::unexpected(UsbRefusal{fault, {"--device", std::move(reason)}});
  };
  if (places.empty()) {
    return refuse(DeviceFault::kNotFound, "no " + title + " is plugged in (haptic_server --list-devices)");
  }
  if (wanted.empty()) {
    if (places.size() == 1) return places.front();
    return refuse(DeviceFault::kAmbiguous,
                  "there are " + std::to_string(places.size()) + " devices of this kind: " + listed(places) +
                      "; choose one by its serial number, address or port, as in --device NAME:" +
                      (places[0].serial.empty() ? addressOf(places[0]) : places[0].serial));
  }
  const auto found = std::ranges::find_if(places, [&](const UsbPlace& place) {
    return place.serial == wanted || place.path == wanted || addressOf(place) == wanted;
  });
  if (found != places.end()) return *found;
  return refuse(DeviceFault::kNotFound,
                "no " + title + " is called \"" + std::string(wanted) + "\"; there is " + listed(places));
}

}  // namespace haptics
