#include "haptic_server/attached_device.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <ostream>
#include <string_view>
#include <utility>

#include "common/log/log.h"
#include "common/text/printable.h"
#include "haptic_server/calibration_file.h"
#include "haptic_server/device/leadable_hand.h"
#include "haptic_server/device/plugin/plugin_link.h"
#include "haptic_server/device/simulated_device.h"
#include "haptic_server/device/usb/choose_device.h"
#include "haptic_server/device/usb/falcon.h"
#include "haptic_server/device/usb/libusb_bus.h"
#include "haptic_server/device/usb/usb_device.h"
#include "haptic_server/device/usb/wooden_haptics.h"
#include "haptic_server/engine/force/predictive_observer.h"
#include "haptic_server/servo/realtime.h"

namespace haptics {
namespace {

struct UsbKind {
  std::string_view name, title;
  UsbModel model;
};
constexpr std::array kUsbKinds{UsbKind{"falcon", "Novint Falcon", kFalconModel},
                               UsbKind{"wooden", "WoodenHaptics", kWoodenHapticsModel}};

/// Plug-ins of our own, which load what their devices' makers have installed.
constexpr std::array<std::string_view, 3> kOwnPlugins{"forcedimension", "haply", "openhaptics"};

constexpr std::string_view kReplay = "replay", kPlugin = "plugin";

struct DeviceName {
  std::string_view kind, which;
};

[[nodiscard]] DeviceName split(std::string_view name) {
  const std::size_t colon = name.find(':');
  std::string_view kind = name.substr(0, colon);
  if (kind == "woodenhaptics") kind = "wooden";
  return {kind, colon == std::string_view::npos ? std::string_view() : name.substr(colon + 1)};
}

[[nodiscard]] const UsbKind* usbKind(std::string_view kind) {
  const auto found = std::ranges::find(kUsbKinds, kind, &UsbKind::name);
  return found == kUsbKinds.end() ? nullptr : &*found;
}

[[nodiscard]] bool isOwnPlugin(std::string_view kind) {
  return std::ranges::find(kOwnPlugins, kind) != kOwnPlugins.end();
}

/// In the folder device_plugins of where the user says, or beside this program.
[[nodiscard]] std::string ownPlugin(std::string_view kind) {
  std::error_code error;
  const char* const said = std::getenv("HAPTICS_PROGRAMS");
  const auto folder = said != nullptr ? std::filesystem::path(said)
                                      : std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
  return folder / "device_plugins" / (std::string(kind) + ".so");
}

class Simulated final : public AttachedDevice {
 public:
  Simulated(const DevicePreset& preset, const HandPreset& hand, double startsAt, double period_s, double delay_s)
      : hand_(hand, preset.maxForce_N, startsAt), device_({preset, hand, period_s, delay_s}, hand_) {}
  [[nodiscard]] Device& device() noexcept override { return device_; }
  [[nodiscard]] bool commandHand(const HandCommand& command) override {
    hand_.command(command);
    return true;
  }

 private:
  LeadableHand hand_;
  SimulatedDevice device_;
};

/// On USB, or behind a plug-in.
class Driven final : public AttachedDevice {
 public:
  Driven(std::unique_ptr<UsbBus> bus, std::unique_ptr<UsbProtocol> protocol, UsbDeviceSettings settings)
      : bus_(std::move(bus)), device_(*bus_, std::move(protocol), std::move(settings)) {}
  [[nodiscard]] Device& device() noexcept override { return device_; }
  void setWatchdog(OutputWatchdog& watchdog) override { device_.setWatchdog(watchdog); }
  void start() override {
    device_.start([] {
      RealtimeStatus status;
      configureDriverThread(status);
      for (const std::string& warning : status.warnings) logWarning(warning);
    });
  }
  void fillStatus(v1::Status& status) const override {
    const UsbDeviceCounters& counters = device_.counters();
    v1::DeviceExchange& exchange = *status.mutable_device_exchange();
    exchange.set_commands(counters.commands);
    exchange.set_replies(counters.replies);
    exchange.set_replies_used(counters.used);
    exchange.set_garbled_packets(counters.garbled);
    exchange.set_connections(counters.connections);
    exchange.set_faults(counters.faults);
  }

 private:
  std::unique_ptr<UsbBus> bus_;
  UsbDevice device_;
};

class Recorded final : public AttachedDevice {
 public:
  explicit Recorded(std::unique_ptr<RecordingPlayer> player) : player_(std::move(player)) {}
  [[nodiscard]] Device& device() noexcept override { return player_->device(); }
  [[nodiscard]] RecordingPlayer* player() noexcept override { return player_.get(); }
  void start() override { player_->start(); }
  void fillStatus(v1::Status& status) const override {
    const PlayedSoFar& played = player_->played();
    v1::PlayedRecording& message = *status.mutable_played_recording();
    message.set_ticks(played.ticks);
    message.set_differing_ticks(played.differing);
    message.set_first_differing_tick(played.firstTick);
    message.set_to_its_end(played.toItsEnd);
    message.set_same_step(player_->sameStep());
  }

 private:
  std::unique_ptr<RecordingPlayer> player_;
};

[[nodiscard]] double rateOf(const ServerOptions& options) { return options.rate_Hz.value_or(kDefaultRate_Hz); }

[[nodiscard]] Result<std::unique_ptr<AttachedDevice>> simulate(const ServerOptions& options) {
  const auto preset = findDevicePreset(options.devicePreset);
  if (!preset) return tl::unexpected(preset.error());
  const auto hand = findHandPreset(options.hand);
  if (!hand) return tl::unexpected(hand.error());
  if (hand->stiffness_N_per_m <= 0) logWarning("--hand " + options.hand + ": a hand without a spring moves nothing");
  return std::make_unique<Simulated>(*preset, *hand, options.startsAt, 1 / rateOf(options),
                                     options.deviceDelay_ms.value_or(0) * 1e-3);
}

[[nodiscard]] Result<void> tryToOpen(const UsbKind& kind, const std::string& which) {
  LibusbBus bus;
  const auto place = chooseDevice(bus.list(kind.model), which, std::string(kind.title));
  if (!place) return tl::unexpected(place.error().error);
  if (auto port = bus.open(kind.model, *place); !port) return tl::unexpected(port.error().error);
  return {};
}

[[nodiscard]] Result<DeviceCalibration> calibrationOf(const ServerOptions& options) {
  if (options.calibration.empty()) return DeviceCalibration{};
  auto read = readCalibration(options.calibration);
  if (!read) return tl::unexpected(std::move(read.error()).within("--calibration "));
  return read;
}

/// The device `which` of the plug-in `file`; `origin` is the option as far as these.
[[nodiscard]] Result<std::unique_ptr<AttachedDevice>> attachPlugin(const ServerOptions& options,
                                                                   const std::string& file, const std::string& which,
                                                                   const std::string& origin) {
  auto library = PluginLibrary::load(file);
  if (!library) return tl::unexpected(std::move(library.error()).within(origin));
  const auto description = library->describe(which);
  if (!description) return tl::unexpected(Error(description.error()).within(origin));
  if (rateOf(options) > description->max_rate_Hz) {
    return refused("--rate", "is " + std::to_string(std::lround(rateOf(options))) + " Hz; the " + description->name +
                                 " exchanges positions and forces at most " +
                                 std::to_string(std::lround(description->max_rate_Hz)) + " times a second");
  }
  const auto calibration = calibrationOf(options);
  if (!calibration) return tl::unexpected(calibration.error());
  if (calibration->motorUnitsPerNm)
    return refused("--calibration", "motor_units_per_Nm is of a Falcon on USB; a plug-in takes force_scale");
  return std::make_unique<Driven>(std::make_unique<PluginBus>(*std::move(library), which, logWarning),
                                  std::make_unique<PluginProtocol>(*description, *calibration),
                                  UsbDeviceSettings{.wanted = {},
                                                    .period_s = 1 / rateOf(options),
                                                    .maxRate_Hz = rateOf(options),
                                                    .info = logInfo,
                                                    .warning = logWarning});
}

[[nodiscard]] Result<std::unique_ptr<AttachedDevice>> attachUsb(const UsbKind& kind, const ServerOptions& options) {
  if (rateOf(options) > UsbDevice::kMaxRate_Hz) {
    return refused("--rate", "is " + std::to_string(std::lround(rateOf(options))) + " Hz; a " +
                                 std::string(kind.title) + " exchanges positions and forces at most " +
                                 std::to_string(std::lround(UsbDevice::kMaxRate_Hz)) + " times a second");
  }
  const auto calibration = calibrationOf(options);
  if (!calibration) return tl::unexpected(calibration.error());
  std::unique_ptr<UsbProtocol> protocol;
  if (kind.name == "falcon") {
    std::optional<FalconFirmware> firmware;
    if (!options.firmware.empty()) {
      auto read = readFirmware(options.firmware);
      if (!read) return tl::unexpected(std::move(read.error()).within("--firmware "));
      firmware = *std::move(read);
    }
    protocol = std::make_unique<Falcon>(*calibration, std::move(firmware));
  } else {
    protocol = std::make_unique<WoodenHaptics>(*calibration);
  }
  const std::string which(split(options.device).which);
  if (auto there = tryToOpen(kind, which); !there) return tl::unexpected(there.error());
  return std::make_unique<Driven>(
      std::make_unique<LibusbBus>(), std::move(protocol),
      UsbDeviceSettings{.wanted = which, .period_s = 1 / rateOf(options), .info = logInfo, .warning = logWarning});
}

/// A recording has its own scene, state and rate, and is not recorded again.
[[nodiscard]] Result<std::unique_ptr<AttachedDevice>> playBack(const ServerOptions& options) {
  const std::string file(split(options.device).which);
  if (file.empty()) return refused("--device", "replay:FILE names the recording that is to be played");
  auto player = RecordingPlayer::open(file);
  if (!player) return tl::unexpected(std::move(player.error()).within("--device replay:"));
  const double rate_Hz = (*player)->facts().rate_Hz;
  if (options.rate_Hz && *options.rate_Hz != rate_Hz) {
    return refused("--rate", "is " + std::to_string(std::lround(*options.rate_Hz)) + " Hz; " + file +
                                 " was recorded at " + std::to_string(std::lround(rate_Hz)) +
                                 " Hz, at which it is played without the option");
  }
  for (const auto& [option, isGiven] :
       {std::pair{"--state", !options.state.empty()}, std::pair{"--record", !options.record.empty()},
        std::pair{"--check-replay", options.checkReplay}}) {
    if (isGiven) return refused(option, "goes with a device that is felt; " + file + " is a recording already");
  }
  if (options.secondHand)
    return refused("--device", "replay:FILE plays every hand of the recording; it is given alone");
  if (!options.scene.empty()) logWarning(options.scene + " is not loaded: " + file + " has its own scenes");
  return std::make_unique<Recorded>(*std::move(player));
}

}  // namespace

Result<std::unique_ptr<AttachedDevice>> AttachedDevice::attach(const ServerOptions& options) {
  if (split(options.device).kind == kReplay) return playBack(options);
  if (options.secondHand && split(options.secondHand->device).kind == kReplay)
    return refused("--device", "replay:FILE plays every hand of the recording; it is given alone");
  const double longest_ms = 1e3 * PredictiveObserver::longestDelay_s(1 / rateOf(options));
  if (options.stabiliser && options.deviceDelay_ms.value_or(0) > longest_ms) {
    return refused("--device-delay-ms", "at " + std::to_string(std::lround(rateOf(options))) +
                                            " Hz the stabiliser looks ahead by at most " + std::to_string(longest_ms) +
                                            " ms; lower --rate, or go without it by --no-stabiliser");
  }
  const auto [name, which] = split(options.device);
  if (name == kPlugin) {
    const auto [file, ofIt] = split(which);
    if (file.empty()) return refused("--device", "plugin:FILE[:WHICH] names the shared library of a plug-in");
    return attachPlugin(options, std::string(file), std::string(ofIt), "--device plugin:");
  }
  if (isOwnPlugin(name)) return attachPlugin(options, ownPlugin(name), std::string(which), "--device: ");
  const UsbKind* kind = usbKind(name);
  return kind == nullptr ? simulate(options) : attachUsb(*kind, options);
}

bool isDeviceName(const std::string& name) {
  const std::string_view kind = split(name).kind;
  return name == "simulated" || kind == kReplay || kind == kPlugin || isOwnPlugin(kind) || usbKind(kind) != nullptr;
}

void listDevices(std::ostream& out) {
  LibusbBus bus;
  bool any = false;
  for (const UsbKind& kind : kUsbKinds) {
    for (const UsbPlace& place : bus.list(kind.model)) {
      any = true;
      const auto port = bus.open(kind.model, place);
      out << "--device " << kind.name << ':' << (place.serial.empty() ? place.path : place.serial) << "   "
          << kind.title << " at USB " << describe(place) << ", " << (port ? "ready" : port.error().error.text())
          << '\n';
    }
  }
  if (!any) out << "no device on USB; --device simulated needs none\n";
  for (const std::string_view kind : kOwnPlugins) {
    out << "--device " << kind << "   ";
    const auto described = PluginLibrary::load(ownPlugin(kind)).and_then([](const PluginLibrary& library) {
      return library.describe("");
    });
    out << printable(described ? described->name + std::string(", ready") : described.error().text()) << '\n';
  }
}

}  // namespace haptics
