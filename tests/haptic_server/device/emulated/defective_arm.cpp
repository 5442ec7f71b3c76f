#include "tests/haptic_server/device/emulated/defective_arm.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace haptics::test {
namespace {

constexpr std::uint64_t kStep_ns = 100'000, kSample_ns = 1'000'000, kLongestGap_ns = 1'000'000'000;
constexpr double kStep_s = kStep_ns * 1e-9;

[[nodiscard]] DevicePreset arm() {
  DevicePreset preset{};
  preset.apparentMass_kg = 0.1;
  preset.viscousFriction_Ns_per_m = 0.5;
  preset.coulombFriction_N = 0.02;
  return preset;
}

}  // namespace

DefectiveArm::DefectiveArm(Defect defect, unsigned seed, double moves_s)
    : defect_(defect),
      draw_(seed),
      moves_s_(moves_s),
      magnitude_(drawnMagnitude()),
      delay_s_(defect == Defect::kLateForce ? magnitude_ : kDelay_s),
      amplitude_m_(between(0.01, 0.03), between(0.01, 0.03), between(0.01, 0.03)),
      frequency_Hz_(between(0.5, 1.5), between(0.5, 1.5), between(0.5, 1.5)),
      plant_(arm(), drawnHand()) {
  plant_.place(target(0));
}

HandPreset DefectiveArm::drawnHand() {
  HandPreset hand{};
  hand.mass_kg = between(0.1, 0.25);
  hand.stiffness_N_per_m = between(120, 250);
  hand.damping_Ns_per_m = between(4, 8);
  return hand;
}

double DefectiveArm::drawnMagnitude() {
  switch (defect_) {
    case Defect::kSpikes:
    case Defect::kJump:
      return between(0.002, 0.004);  // m
    case Defect::kNoise:
      return between(6e-5, 2e-4);  // m
    case Defect::kOldPositions:
    case Defect::kLateForce:
      return between(0.02, 0.04);  // s
    case Defect::kSlowWatchdog:
      return between(0.12, 0.25);  // s
    default:
      return 0;
  }
}

Vec3 DefectiveArm::target(double time_s) const {
  const double fades = std::clamp((moves_s_ - time_s) / 0.3, 0.0, 1.0);
  Vec3 at;
  for (int k = 0; k < 3; ++k)
    at[k] = fades * amplitude_m_[k] * std::sin(2 * std::numbers::pi * frequency_Hz_[k] * time_s + k);
  return at;
}

void DefectiveArm::write(Vec3 force_N, std::uint64_t now_ns) {
  moveTo(now_ns);
  lastWrite_ns_ = now_ns;
  written_.push_back({now_ns + static_cast<std::uint64_t>(delay_s_ * 1e9), force_N});
}

Vec3 DefectiveArm::motor() {
  while (written_.size() > 1 && written_[1].from_ns <= time_ns_) written_.pop_front();
  Vec3 force_N = written_.empty() || written_.front().from_ns > time_ns_ ? Vec3(0) : written_.front().force_N;
  const double watchdog_s = defect_ == Defect::kNoWatchdog     ? 1e9
                            : defect_ == Defect::kSlowWatchdog ? magnitude_
                                                               : 0.025;
  if (static_cast<double>(time_ns_ - std::min(time_ns_, lastWrite_ns_)) * 1e-9 > watchdog_s) force_N = Vec3(0);
  switch (defect_) {
    case Defect::kNoForce:
      return Vec3(0);
    case Defect::kReversedZ:
      return {force_N.x, force_N.y, -force_N.z};
    case Defect::kXForY:
      return {force_N.y, force_N.x, force_N.z};
    case Defect::kForceEndsSlowly: {
      const Vec3 to = force_N - motor_N_;
      const double most_N = 1.5 * kStep_s;
      return glm::length(to) > most_N ? motor_N_ + most_N / glm::length(to) * to : force_N;
    }
    default:
      return force_N;
  }
}

void DefectiveArm::sample() {
  ++sample_.count;
  const double time_s = static_cast<double>(time_ns_ - began_ns_) * 1e-9;
  sample_.measured_ns = time_ns_;
  if (defect_ == Defect::kOldPositions) sample_.measured_ns -= static_cast<std::uint64_t>(magnitude_ * 1e9);
  if (defect_ == Defect::kAllStandStill) return;
  if (defect_ == Defect::kValuesAt60Hz && sample_.count % 17 != 0) return;
  Vec3 at = plant_.position();
  if (defect_ == Defect::kXStandsStill) at.x = 0;
  if (defect_ == Defect::kSpikes && sample_.count % 211 == 0) at.z += magnitude_;
  if (defect_ == Defect::kJump && time_s > moves_s_ / 2) at.y += magnitude_;
  for (int k = 0; k < 3; ++k) {
    if (defect_ == Defect::kNoise) at[k] += std::normal_distribution<double>(0, magnitude_)(draw_);
    sample_.position[k] = kResolution_m * std::round(at[k] / kResolution_m);
  }
}

void DefectiveArm::moveTo(std::uint64_t now_ns) {
  if (began_ns_ == 0) began_ns_ = time_ns_ = nextSample_ns_ = now_ns;
  if (now_ns > time_ns_ + kLongestGap_ns) time_ns_ = nextSample_ns_ = now_ns - kLongestGap_ns;
  const std::uint64_t samples = defect_ == Defect::kPositionsAt60Hz ? 17 : defect_ == Defect::kPositionsAt500Hz ? 2 : 1;
  for (; time_ns_ + kStep_ns <= now_ns; time_ns_ += kStep_ns) {
    const double time_s = static_cast<double>(time_ns_ - began_ns_) * 1e-9;
    motor_N_ = motor();
    const Vec3 velocity = (target(time_s + kStep_s) - target(time_s)) / kStep_s;
    plant_.step(kStep_s, motor_N_, {target(time_s), Vec3(0)}, velocity);
    if (time_ns_ >= nextSample_ns_) {
      sample();
      nextSample_ns_ += samples * kSample_ns;
    }
  }
}

const DefectiveArm::Position& DefectiveArm::read(std::uint64_t now_ns) {
  moveTo(now_ns);
  return sample_;
}

}  // namespace haptics::test
