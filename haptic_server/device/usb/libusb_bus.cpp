#include "haptic_server/device/usb/libusb_bus.h"

#include <fcntl.h>
#include <libusb-1.0/libusb.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <string>
#include <thread>

#include "common/process/file_handle.h"
#include "haptic_server/device/usb/choose_device.h"
#include "haptic_server/device/usb/libusb_port.h"

namespace haptics {
namespace {

[[nodiscard]] UsbContext newContext() {
  libusb_context* context = nullptr;
  if (libusb_init(&context) != LIBUSB_SUCCESS) return nullptr;
  return UsbContext(context);
}

[[nodiscard]] std::string pathOf(libusb_device* device) {
  std::array<std::uint8_t, 7> ports;
  const int depth = libusb_get_port_numbers(device, ports.data(), static_cast<int>(ports.size()));
  std::string path = std::to_string(libusb_get_bus_number(device));
  for (int i = 0; i < depth; ++i) {
    path += i == 0 ? '-' : '.';
    path += std::to_string(ports[static_cast<std::size_t>(i)]);
  }
  return path;
}

[[nodiscard]] std::string serialOf(libusb_device* device, std::uint8_t index) {
  libusb_device_handle* handle = nullptr;
  if (index == 0 || libusb_open(device, &handle) != LIBUSB_SUCCESS) return {};
  std::array<unsigned char, 128> text;
  const int length = libusb_get_string_descriptor_ascii(handle, index, text.data(), static_cast<int>(text.size()));
  libusb_close(handle);
  return length > 0 ? std::string(text.begin(), text.begin() + length) : std::string();
}

[[nodiscard]] std::string nodeOf(const UsbPlace& place) { return "/dev/bus/usb/" + addressOf(place); }

/// Error number of open(2) for one of libusb.
[[nodiscard]] int errorOf(int number) noexcept {
  if (number == EACCES || number == EPERM) return LIBUSB_ERROR_ACCESS;
  return number == ENOENT || number == ENODEV ? LIBUSB_ERROR_NO_DEVICE : LIBUSB_ERROR_IO;
}

[[nodiscard]] UsbRefusal refusalOf(int error, const UsbPlace& place) {
  const std::string node = nodeOf(place);
  switch (error) {
    case LIBUSB_ERROR_ACCESS:
      return {DeviceFault::kNotPermitted,
              {node,
               "no permission: copy deploy/udev/70-haptic-devices.rules to /etc/udev/rules.d, run \"udevadm control "
               "--reload\" and plug the device in again"}};
    case LIBUSB_ERROR_NO_DEVICE:
    case LIBUSB_ERROR_NOT_FOUND:
      return {DeviceFault::kNotFound, {node, "the device went away before it was opened"}};
    case LIBUSB_ERROR_BUSY:
      return {DeviceFault::kInUse, {node, "another program uses the device: end it first"}};
    default:
      return {DeviceFault::kNotAnswering,
              {node, std::string("the device cannot be opened: ") + libusb_strerror(error)}};
  }
}

}  // namespace

void UsbContextEnd::operator()(libusb_context* context) const noexcept { libusb_exit(context); }

void LibusbBus::sleepUntil(std::uint64_t time_ns) {
  if (const std::uint64_t now_ns = monotonicNow_ns(); now_ns < time_ns) {
    std::this_thread::sleep_for(std::chrono::nanoseconds(time_ns - now_ns));
  }
}

std::vector<UsbPlace> LibusbBus::list(const UsbModel& model) {
  std::vector<UsbPlace> places;
  const UsbContext context = newContext();
  if (!context) return places;
  libusb_device** devices = nullptr;
  const ssize_t count = libusb_get_device_list(context.get(), &devices);
  for (ssize_t i = 0; i < count; ++i) {
    libusb_device* const device = devices[i];
    libusb_device_descriptor descriptor;
    if (libusb_get_device_descriptor(device, &descriptor) != LIBUSB_SUCCESS) continue;
    if (descriptor.idVendor != model.vendor || descriptor.idProduct != model.product) continue;
    places.push_back({libusb_get_bus_number(device), libusb_get_device_address(device), pathOf(device),
                      serialOf(device, descriptor.iSerialNumber)});
  }
  if (count >= 0) libusb_free_device_list(devices, 1);
  std::ranges::sort(places, {}, [](const UsbPlace& place) { return std::pair(place.bus, place.address); });
  return places;
}

/// The node is opened here, not by libusb: its descriptor can be given to another process, which may then write to the
/// device when this one no longer lives.
tl::expected<std::unique_ptr<UsbPort>, UsbRefusal> LibusbBus::open(const UsbModel& model, const UsbPlace& place) {
  FileHandle node(::open(nodeOf(place).c_str(), O_RDWR | O_CLOEXEC));
  if (!node) return tl::unexpected(refusalOf(errorOf(errno), place));
  UsbContext context = newContext();
  if (!context) return tl::unexpected(refusalOf(LIBUSB_ERROR_OTHER, place));
  libusb_device_handle* handle = nullptr;
  int error = libusb_wrap_sys_device(context.get(), node.descriptor(), &handle);
  if (error != LIBUSB_SUCCESS) return tl::unexpected(refusalOf(error, place));
  libusb_set_auto_detach_kernel_driver(handle, 1);
  error = libusb_claim_interface(handle, 0);
  if (error != LIBUSB_SUCCESS) {
    libusb_close(handle);
    return tl::unexpected(refusalOf(error, place));
  }
  return std::make_unique<LibusbPort>(std::move(node), std::move(context), handle, model);
}

}  // namespace haptics
