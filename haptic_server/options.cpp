#include "haptic_server/options.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <iostream>

#include "haptic_server/attached_device.h"
#include "haptic_server/device/presets.h"
#include "haptic_server/step/two_hands.h"

namespace haptics {
namespace {

template <class Presets>
[[nodiscard]] std::vector<std::string> namesOf(const Presets& presets) {
  std::vector<std::string> names;
  for (const auto& preset : presets) names.emplace_back(preset.name);
  return names;
}

/// An option of a device: given a second time, it is the second hand's. `values` stay valid while the app parses.
CLI::Option* addHandOption(CLI::App& app, const char* name, std::vector<std::string>& values,
                           const std::string& about) {
  return app.add_option(name, values, about + "; a second time: of the second hand")
      ->expected(1, static_cast<int>(kMaxHands))
      ->allow_extra_args(false)
      ->type_name("TEXT");
}

/// Of options of a device as they were given.
struct HandArguments {
  std::vector<std::string> devices, firmwares, calibrations, presets, hands, delays_ms;

  [[nodiscard]] std::size_t count() const {
    return std::max({devices.size(), firmwares.size(), calibrations.size(), presets.size(), hands.size(),
                     delays_ms.size(), std::size_t(1)});
  }
  /// What is given once holds for both.
  [[nodiscard]] HandOptions of(std::size_t hand) const {
    HandOptions options;
    const auto take = [hand](const std::vector<std::string>& given, std::string& value) {
      if (!given.empty()) value = given[std::min(hand, given.size() - 1)];
    };
    take(devices, options.device);
    take(firmwares, options.firmware);
    take(calibrations, options.calibration);
    take(presets, options.devicePreset);
    take(hands, options.hand);
    std::string delay_ms;
    take(delays_ms, delay_ms);
    if (!delay_ms.empty()) options.deviceDelay_ms = std::stod(delay_ms);
    return options;
  }
};

constexpr const char* kExamples = R"(
Examples:
  haptic_server --scene deploy/scenes/demo.scene --assets /usr/share/inventor/data
  haptic_server --device-preset falcon --hand light --rate 4000 --seconds 60 --summary out.json
  haptic_server --list-devices
  haptic_server --scene deploy/scenes/pinch.scene --hand nominal --hand light      # two hands in one scene
  haptic_server --scene my.scene --device falcon:FTX1 --device falcon:FTX2
  haptic_server --scene my.scene --device falcon --firmware falcon.bin
  haptic_server --scene my.scene --state /var/lib/haptics
  haptic_server --device plugin:./libmy_device.so --scene my.scene
  haptic_server --device replay:session.haptics
  haptic_server --scene my.scene --listen 192.168.1.5:7654 --credentials my_server

  haptic_server doctor                     # can this machine run a real-time servo?
  haptic_server check-device falcon        # what does the device tell, and which way does it push?

Runs until Ctrl-C, for --seconds, or to a recording's end; then stops the device and writes the summary.)";

}  // namespace

std::variant<ServerOptions, int> parseServerOptions(int argc, char** argv) {
  ServerOptions options;
  CLI::App app{
      "The haptic server: reads the force-feedback device, finds the contact, writes the force, keeps the scene."};
  app.set_version_flag("--version", "haptic_server " HAPTICS_VERSION);
  app.footer(kExamples);
  app.add_option("--scene", options.scene, "Scene file to start with (protobuf text format); \"-\" for standard input");
  app.add_option("--state", options.state,
                 "Folder that keeps the scene and every accepted edit, also across a crash; once it holds a scene, the "
                 "server goes on from it and --scene is not loaded");
  app.add_option("--assets", options.assets,
                 "Folder where scenes and clients may name mesh files (besides the scene file's)")
      ->check(CLI::ExistingDirectory);
  HandArguments hands;
  addHandOption(app, "--device", hands.devices,
                "Force-feedback device (default: simulated): simulated, falcon or wooden; :WHICH after it chooses one "
                "of several by serial "
                "number, BUS/ADDRESS or port. Or plugin:FILE[:WHICH]: the shared library FILE drives it "
                "(haptic_server/device/plugin/README.md). Or replay:FILE: plays a recording, positions, buttons, "
                "scene and edits, and says at its end whether every force was the recorded one")
      ->type_name("")
      ->check(CLI::Validator(
          [](const std::string& name) {
            return isDeviceName(name) ? std::string() : "there is no device \"" + name + "\"";
          },
          "simulated|falcon[:WHICH]|wooden[:WHICH]|plugin:FILE[:WHICH]|replay:FILE"));
  app.add_flag_callback(
      "--list-devices",
      [] {
        listDevices(std::cout);
        throw CLI::Success();
      },
      "Say which devices are plugged in and how to choose each");
  addHandOption(app, "--firmware", hands.firmwares,
                "Program of a Falcon that was just switched on (a .bin file; not ours)");
  addHandOption(app, "--calibration", hands.calibrations,
                "How the device stands in the world and how strong it is (proto/haptics/v1/device.proto, text format)");
  addHandOption(app, "--device-preset", hands.presets,
                "Device to simulate (default: " + std::string(kDefaultDevicePreset) + ")")
      ->type_name("")
      ->check(CLI::IsMember(namesOf(devicePresets())));
  addHandOption(app, "--hand", hands.hands,
                "Hand that holds the simulated device (default: " + std::string(kDefaultHandPreset) + ")")
      ->type_name("")
      ->check(CLI::IsMember(namesOf(handPresets())));
  app.add_option("--listen", options.listen, "HOST:PORT for clients; port 0 takes a free one")->capture_default_str();
  app.add_option(
         "--credentials", options.credentials,
         "Speak TLS 1.3 only, with clients that hold credentials of this folder (hapticctl credentials DIR). A token "
         "whose line is taken out of the folder's list is refused, and its clients cut, within a second; "
         "SIGHUP reads the list at once")
      ->type_name("DIR");
  app.add_flag("--allow-insecure-lan", options.allowInsecureLan,
               "Accept clients from other machines without credentials: where everybody may read and edit");
  app.add_option("--rate", options.rate_Hz, "Servo rate in Hz")
      ->check(CLI::Range(100.0, 20'000.0))
      ->default_str(std::to_string(std::lround(kDefaultRate_Hz)));
  addHandOption(
      app, "--device-delay-ms", hands.delays_ms,
      "Measured time from reading a position to the motors' force, beyond the hold of a period; the stabiliser "
      "looks ahead so far, and a simulated device has it")
      ->type_name("MS")
      ->check(CLI::Range(0.0, 60.0));
  app.add_flag("!--no-stabiliser", options.stabiliser,
               "Compute forces where the device was measured, without looking ahead");
  app.add_option("--seconds", options.seconds, "Stop after this time (default: run until a signal)")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--summary", options.summary, "Write the run's figures here as JSON");
  app.add_option("--record", options.record,
                 "Write all that the servo computes with here, tick by tick: haptic_eval replay FILE makes the same "
                 "forces of it again");
  app.add_option(
         "--recordings", options.recordings,
         "Folder where the last 10 s are recorded when a fault comes up, when hapticctl dump asks, and when the "
         "server crashes")
      ->type_name("DIR")
      ->capture_default_str();
  app.add_option("--recordings-max-mb", options.maxRecordings_MB,
                 "What these may take together, and 100 files at most; the oldest go first, never the last one or the "
                 "last of a fault")
      ->type_name("MB")
      ->check(CLI::Range(std::size_t(1), std::size_t(1) << 30))
      ->capture_default_str();
  app.add_option("--pin", options.cpu, "CPU to bind the servo thread to")->check(CLI::NonNegativeNumber);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  }
  static_cast<HandOptions&>(options) = hands.of(0);
  if (hands.count() > 1) options.secondHand = hands.of(1);
  if (!options.scene.empty() && options.scene != "-") {
    const auto folder = std::filesystem::absolute(options.scene).parent_path();
    options.assets.insert(options.assets.begin(), folder);
  }
  return options;
}

}  // namespace haptics
