#include "haptic_server/surface_limits_cache.h"

#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <optional>
#include <system_error>

#include "common/hash/content_hash.h"
#include "haptic_server/device/presets.h"
#include "haptic_server/device/simulated_device.h"
#include "haptic_server/recording/recording_format.h"

namespace haptics {
namespace {

/// What the simulated device does under a few forces: another one wherever its mechanics are changed.
void addSimulation(Hasher& key, const DeviceInfo& device, double period_s) {
  class IdleHand final : public HandIntent {
   public:
    HandTarget next(double /*dt_s*/, Vec3 /*felt_N*/) noexcept override { return {}; }
  };
  constexpr std::uint64_t kTicks = 100;
  constexpr double kForce_N = 1;
  for (const HandPreset& hand : handPresets()) {
    IdleHand idle;
    SimulatedDevice simulated({presetOf(device), hand, period_s, device.delay_s}, idle);
    for (std::uint64_t tick = 0; tick < kTicks; ++tick) {
      const Vec3 measured = simulated.read(tick).position;
      simulated.write({0, 0, tick % 3 == 0 ? kForce_N : -kForce_N});
      key.add(measured.z).add(simulated.plant().position().z);
    }
  }
}

[[nodiscard]] ContentHash keyOf(const DeviceInfo& device, double rate_Hz, bool stabilised) {
  Hasher key;
  key.add("surface limits").add(ownStepSources());  // the definition of coming to rest included
  for (const double figure :
       {device.maxForce_N, device.maxStiffness_N_per_m, device.maxDamping_Ns_per_m, device.resolution_m,
        device.apparentMass_kg, device.viscousFriction_Ns_per_m, device.coulombFriction_N, device.delay_s,
        device.rotation.maxTorque_Nm, device.rotation.maxTorsion_Nm_per_rad, device.rotation.resolution_rad,
        device.rotation.inertia_kgm2, device.rotation.viscousFriction_Nms_per_rad, device.rotation.coulombFriction_Nm,
        rate_Hz}) {
    key.add(figure);
  }
  addSimulation(key, device, 1 / rate_Hz);
  return key.add(std::uint64_t{stabilised}).finish();
}

/// The whole file. Hexadecimal figures are read back bit for bit.
[[nodiscard]] std::string textOf(const ContentHash& key, const SurfaceLimits& limits) {
  char figures[160];
  std::snprintf(figures, sizeof figures, "stiffness_N_per_m %a\ndamping_Ns_per_m %a\ntorsion_Nm_per_rad %a\n",
                limits.stiffness_N_per_m, limits.damping_Ns_per_m, limits.torsion_Nm_per_rad);
  std::string text = "key " + key.hex() + '\n' + figures;
  return text + "sha256 " + Hasher().add(text).finish().hex() + '\n';
}

/// Nothing unless the text is, to the byte, what is written for the limits that it names.
[[nodiscard]] std::optional<SurfaceLimits> limitsIn(const std::string& text, const ContentHash& key) {
  SurfaceLimits limits;
  if (std::sscanf(text.c_str(), "key %*64s stiffness_N_per_m %la damping_Ns_per_m %la torsion_Nm_per_rad %la",
                  &limits.stiffness_N_per_m, &limits.damping_Ns_per_m, &limits.torsion_Nm_per_rad) != 3) {
    return std::nullopt;
  }
  return text == textOf(key, limits) ? std::optional(limits) : std::nullopt;
}

[[nodiscard]] std::string contentsOf(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Whole or not at all, whoever else writes it. What a crash leaves of it does not pass as limits.
void replace(const std::filesystem::path& file, const std::string& text) {
  std::error_code failed;
  std::filesystem::create_directories(file.parent_path(), failed);
  std::filesystem::path fresh = file;
  fresh += '.' + std::to_string(getpid());
  std::ofstream out(fresh, std::ios::binary);
  out << text;
  out.close();
  if (out) std::filesystem::rename(fresh, file, failed);
  if (!out || failed) std::filesystem::remove(fresh, failed);
}

[[nodiscard]] std::filesystem::path absoluteFolder(const char* variable) {
  const char* value = std::getenv(variable);
  const std::filesystem::path folder = value != nullptr ? value : "";
  return folder.is_absolute() ? folder : std::filesystem::path();
}

}  // namespace

std::filesystem::path SurfaceLimitsCache::userFolder() {
  if (const auto cache = absoluteFolder("XDG_CACHE_HOME"); !cache.empty()) return cache / "haptics";
  if (const auto home = absoluteFolder("HOME"); !home.empty()) return home / ".cache" / "haptics";
  return {};
}

std::filesystem::path SurfaceLimitsCache::fileFor(const DeviceInfo& device, double rate_Hz, bool stabilised) const {
  return folder_ / ("surface-limits-" + keyOf(device, rate_Hz, stabilised).hex());
}

SurfaceLimitsCache::Found SurfaceLimitsCache::find(const DeviceInfo& device, double rate_Hz, bool stabilised) const {
  const bool isKept = !folder_.empty() && device.apparentMass_kg > 0;  // else there is nothing to search
  if (!isKept) return {surfaceLimits(device, rate_Hz, stabilised), true};
  const ContentHash key = keyOf(device, rate_Hz, stabilised);
  const std::filesystem::path file = fileFor(device, rate_Hz, stabilised);
  if (const auto limits = limitsIn(contentsOf(file), key)) return {*limits, false};
  const SurfaceLimits limits = surfaceLimits(device, rate_Hz, stabilised);
  replace(file, textOf(key, limits));
  return {limits, true};
}

}  // namespace haptics
