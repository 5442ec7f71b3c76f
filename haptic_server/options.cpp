#include "haptic_server/options.h"

#include <algorithm>
#include <cmath>
#include <iostream>

#include "common/command_line/command_line.h"
#include "haptic_server/attached_device.h"
#include "haptic_server/device/presets.h"
#include "haptic_server/engine/step/two_hands.h"

namespace haptics {
namespace {

template <class Presets>
[[nodiscard]] std::vector<std::string> namesOf(const Presets& presets) {
  std::vector<std::string> names;
  for (const auto& preset : presets) names.emplace_back(preset.name);
  return names;
}

/// An option of a device: given a second time, it is the second hand's. `values` stay valid while the app parses.
Option addHandOption(Command& app, const char* name, std::vector<std::string>& values, const std::string& about) {
  return app.option(name, values, about + "; a second time: of the second hand").atMost(kMaxHands).typeName("TEXT");
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
  CommandLine app{
      "The haptic server: reads the force-feedback device, finds the contact, writes the force, keeps the scene."};
  app.version("haptic_server " HAPTICS_VERSION);
  app.footer(kExamples);
  app.option("--scene", options.scene, "Scene file to start with (protobuf text format); \"-\" for standard input");
  app.option("--state", options.state,
             "Folder that keeps the scene and every accepted edit, also across a crash; once it holds a scene, the "
             "server goes on from it and --scene is not loaded");
  app.option("--assets", options.assets,
             "Folder where scenes and clients may name mesh files (besides the scene file's)")
      .existingFolder();
  HandArguments hands;
  addHandOption(app, "--device", hands.devices,
                "Force-feedback device (default: simulated): simulated, falcon or wooden; :WHICH after it chooses one "
                "of several by serial "
                "number, BUS/ADDRESS or port. forcedimension[:WHICH], haply[:WHICH], openhaptics[:WHICH]: by their "
                "makers' library or service. Or "
                "plugin:FILE[:WHICH]: the shared library FILE drives it "
                "(haptic_server/device/plugin/README.md). Or replay:FILE: plays a recording, positions, buttons, "
                "scene and edits, and says at its end whether every force was the recorded one")
      .typeName("")
      .check(
          [](const std::string& name) -> Result<void> {
            if (!isDeviceName(name)) return refused("", "there is no device \"" + name + "\"");
            return {};
          },
          "simulated|falcon[:WHICH]|wooden[:WHICH]|forcedimension[:WHICH]|haply[:WHICH]|openhaptics[:WHICH]|plugin:"
          "FILE[:WHICH]|replay:FILE");
  app.action(
      "--list-devices", [] { listDevices(std::cout); }, "Say which devices are plugged in and how to choose each");
  addHandOption(app, "--firmware", hands.firmwares,
                "Program of a Falcon that was just switched on (a .bin file; not ours)");
  addHandOption(app, "--calibration", hands.calibrations,
                "How the device stands in the world and how strong it is (proto/haptics/v1/device.proto, text format)");
  addHandOption(app, "--device-preset", hands.presets,
                "Device to simulate (default: " + std::string(kDefaultDevicePreset) + ")")
      .typeName("")
      .oneOf(namesOf(devicePresets()));
  addHandOption(app, "--hand", hands.hands,
                "Hand that holds the simulated device (default: " + std::string(kDefaultHandPreset) + ")")
      .typeName("")
      .oneOf(namesOf(handPresets()));
  app.option("--listen", options.listen, "HOST:PORT for clients; port 0 takes a free one").showDefault();
  app.option(
         "--credentials", options.credentials,
         "Speak TLS 1.3 only, with clients that hold credentials of this folder (hapticctl credentials DIR). A token "
         "whose line is taken out of the folder's list is refused, and its clients cut, within a second; "
         "SIGHUP reads the list at once")
      .typeName("DIR");
  app.flag("--allow-insecure-lan", options.allowInsecureLan,
           "Accept clients from other machines without credentials: where everybody may read and edit");
  app.option("--rate", options.rate_Hz, "Servo rate in Hz")
      .range(100.0, 20'000.0)
      .showDefault(std::to_string(std::lround(kDefaultRate_Hz)));
  addHandOption(
      app, "--device-delay-ms", hands.delays_ms,
      "Measured time from reading a position to the motors' force, beyond the hold of a period; the stabiliser "
      "looks ahead so far, and a simulated device has it")
      .typeName("MS")
      .range(0.0, 60.0);
  app.flag("!--no-stabiliser", options.stabiliser,
           "Compute forces where the device was measured, without looking ahead");
  app.option("--seconds", options.seconds, "Stop after this time (default: run until a signal)").zeroOrMore();
  app.option("--summary", options.summary, "Write the run's figures here as JSON");
  app.option("--record", options.record,
             "Write all that the servo computes with here, tick by tick: haptic_eval replay FILE makes the same "
             "forces of it again");
  app.flag("--check-replay", options.checkReplay,
           "Replay beside the servo what it has just run, and say which force or field of the state is another one "
           "(log, hapticctl status, summary)");
  app.option("--recordings", options.recordings,
             "Folder where the last 10 s are recorded when a fault comes up, when hapticctl dump asks, and when the "
             "server crashes")
      .typeName("DIR")
      .showDefault();
  app.option("--recordings-max-mb", options.maxRecordings_MB,
             "What these may take together, and 100 files at most; the oldest go first, never the last one or the "
             "last of a fault")
      .typeName("MB")
      .range(std::size_t(1), std::size_t(1) << 30)
      .showDefault();
  app.option("--pin", options.cpu, "CPU to bind the servo thread to").zeroOrMore();
  if (const auto code = app.parse(argc, argv)) return *code == 0 ? 0 : 2;
  static_cast<HandOptions&>(options) = hands.of(0);
  if (hands.count() > 1) options.secondHand = hands.of(1);
  if (!options.scene.empty() && options.scene != "-") {
    const auto folder = std::filesystem::absolute(options.scene).parent_path();
    options.assets.insert(options.assets.begin(), folder);
  }
  return options;
}

}  // namespace haptics
