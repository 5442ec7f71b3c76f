#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "haptic_server/engine/step/haptic_state.h"

namespace haptics {

/// A tick of an object that a client drives (KinematicPose): at an even speed to the newest sample, in as many ticks as lie
/// between that and the one before, so that a stream of any rate moves it without a stop, and a sample in every tick puts it
/// there. One that comes kLongestPause_s or more after the last begins a stream: the object takes KinematicPose::first_s to it,
/// longer where it would be faster than kFirstSpeed_m_per_s, kLongestPause_s at most. Where the next ones come sooner than that,
/// the object is up to two of them late, and catches up slowly (kCaughtUp): it does not throw what lies on it. Surfaces that move
/// so are met on their way as any moving body is, and push the hand.
/// @return Whether it is driven, or comes to rest after it was.
[[nodiscard]] bool moveDrivenObject(const ServoScene& scene, HapticState& state, double period_s,
                                    std::size_t object) noexcept;

/// A tick of an object whose vertices a client moves (KinematicShape): from sample to sample, in the times that poses take. Its
/// surface takes the contact with it (surfaceShift()); what is near the IHIP deforms in this tick. After its pose in this tick is
/// set.
/// @return Whether they are moved, or come to rest after they were.
[[nodiscard]] bool moveDrivenShape(const ServoScene& scene, HapticState& state, double period_s,
                                   std::size_t object) noexcept;

/// The hand's own.
[[nodiscard]] inline ShapeMemory& memoryOf(const KinematicShape& shape, const HapticState& state) noexcept {
  return *shape.memory[state.motion.follows ? 1 : 0];
}

/// Some object of the scene has a sample, or comes to have one between two ticks.
void beginDriving(HapticState& state) noexcept;
void beginReshaping(HapticState& state) noexcept;  ///< Likewise.
/// moveDrivenObject() and moveDrivenShape() of all, in a tick in which no contact is followed: what is driven does not wait for the device.
void moveDrivenObjects(const ServoScene& scene, HapticState& state, double period_s) noexcept;

/// Where an object is on its way over the samples of its shape, by their number: 6.25 is a quarter of the way from 6 to 7.
struct ShapePlace {
  std::uint64_t object = 0;
  double sample = 0;
  bool operator==(const ShapePlace&) const = default;
};
struct ShapePlaces {
  std::size_t count = 0;
  std::array<ShapePlace, kMaxServoObjects> place;

  [[nodiscard]] std::span<const ShapePlace> all() const noexcept { return std::span(place).first(count); }
};
/// @return Whether they are others than before.
bool updateShapePlaces(const ServoScene& scene, const HapticState& state, ShapePlaces& shapes) noexcept;

/// Shorter makes slow streams go by fits and starts; longer makes the first sample after a pause late.
inline constexpr double kLongestPause_s = 0.1;
inline constexpr double kFirstSpeed_m_per_s = 1;
/// Of a second in a second: a speed of up to 1 / (1 - kCaughtUp) of the samples'.
inline constexpr double kCaughtUp = 0.125;

}  // namespace haptics
