#include "tests/e2e/led_device.h"

#include <algorithm>
#include <string>
#include <utility>

#include "haptic_server/attached_device.h"

namespace haptics::e2e {
namespace {

thread_local LedDevice* next = nullptr;

DeviceInfo infoOf(const DevicePreset& preset) {
  return {"led " + std::string(preset.title), preset.maxForce_N,        preset.maxStiffness_N_per_m,
          preset.maxDamping_Ns_per_m,         preset.resolution_m,      preset.apparentMass_kg,
          preset.viscousFriction_Ns_per_m,    preset.coulombFriction_N, 0};
}

class AttachedLedDevice final : public AttachedDevice {
 public:
  explicit AttachedLedDevice(LedDevice& device) : device_(device) {}
  [[nodiscard]] Device& device() noexcept override { return device_; }

 private:
  LedDevice& device_;
};

}  // namespace

LedDevice::LedDevice(const DevicePreset& preset, double period_s, Vec3 place)
    : info_(infoOf(preset)), period_s_(period_s), target_{place, 0}, position_(place) {}

void LedDevice::lead(Vec3 place) { newest_.put({place, ++led_}); }

DeviceReading LedDevice::read(std::uint64_t tick) noexcept {
  if (const Target* target = newest_.takeNew()) target_ = *target;
  const Vec3 way = target_.place - position_;
  const double left_m = glm::length(way);
  const double most_m = kSpeed_m_per_s * period_s_ * static_cast<double>(tick - std::exchange(tick_, tick));
  if (left_m <= most_m) {
    position_ = target_.place;
    arrived_ = target_.number;
  } else {
    position_ += way * (most_m / left_m);
  }
  return {position_, DeviceState::kReady, DeviceStatus{}};
}

void attachNext(LedDevice& device) { next = &device; }

}  // namespace haptics::e2e

namespace haptics {

Result<std::unique_ptr<AttachedDevice>> AttachedDevice::attach(const ServerOptions& /*options*/) {
  return std::make_unique<e2e::AttachedLedDevice>(*e2e::next);
}

}  // namespace haptics
