#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "haptic_server/device/presets.h"

namespace haptics {

inline constexpr double kDefaultRate_Hz = 1000;

/// A device, and the hand that holds it.
struct HandOptions {
  /// Or one on USB, "falcon" or "wooden", with ":WHICH" where there are several; or "replay:FILE", a recording.
  std::string device = "simulated";
  std::string firmware;     ///< File for a Falcon that has none.
  std::string calibration;  ///< File; empty: the driver's defaults.
  std::string devicePreset = std::string(kDefaultDevicePreset);
  std::string hand = std::string(kDefaultHandPreset);
  std::optional<double> deviceDelay_ms;  ///< As measured; empty: the driver's own figure.
  double startsAt = 0;                   ///< As for ExploringHand.
};

/// Options of a server, from its command line.
struct ServerOptions : HandOptions {
  std::optional<HandOptions> secondHand;      ///< None: one hand feels the scene.
  std::string scene;                          ///< Scene file; empty: an empty scene.
  std::string state;                          ///< Folder that keeps the scene across a crash; empty: none.
  std::vector<std::filesystem::path> assets;  ///< Folders where scenes and clients may name mesh and image files.
  std::string listen = "127.0.0.1:7654";      ///< Empty: only for clients in this process.
  std::string credentials;                    ///< Folder; empty: everybody who can connect may edit.
  bool allowInsecureLan = false;
  std::optional<double> rate_Hz;  ///< Empty: a recording's own, else kDefaultRate_Hz.
  bool stabiliser = true;
  double seconds = 0;        ///< 0: until a signal.
  std::string summary;       ///< JSON file, written at the end.
  std::string record;        ///< Recording of every tick; empty: none.
  bool checkReplay = false;  ///< Replays beside the servo what it has just run.
  /// Folder for recordings of the last seconds: of a fault, or asked for.
  std::filesystem::path recordings = ".";
  std::size_t maxRecordings_MB = 1024;  ///< All of them together; the oldest go first.
  std::optional<int> cpu;               ///< To bind the servo thread to.

  /// With the second hand's device in place of the first's.
  [[nodiscard]] ServerOptions ofSecondHand() const {
    ServerOptions second = *this;
    static_cast<HandOptions&>(second) = secondHand.value_or(HandOptions());
    second.secondHand.reset();
    second.startsAt = 0.5;
    return second;
  }
};

}  // namespace haptics
