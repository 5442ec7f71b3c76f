#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "common/telemetry/motion_state.h"
#include "common/telemetry/telemetry_sample.h"
#include "haptic_server/net/server_host.h"
#include "haptic_server/net/tick_history.h"

namespace haptics {

/// The network thread's end of the servo: samples through a queue, poses of moving bodies through a mailbox.
class ServoFeed {
 public:
  explicit ServoFeed(ServerHost& host) noexcept : host_(host) {}

  /// Empties the queue; calls onAdopted(revision, tick) for each scene revision that every hand has adopted, with the tick in
  /// which the last of them did.
  /// @return Whether there was a sample. The newest is then in last(), and where everything was at its tick in motion():
  /// the servo tells of that after the sample.
  template <class OnAdopted>
  bool drain(OnAdopted onAdopted) {
    takeMotion();
    bool any = drainSamples(onAdopted);
    while (takeMotion()) any = drainSamples(onAdopted) || any;
    takeEnergy();
    if (const ShapePlaces* shapes = host_.takeShapes()) shapes_ = *shapes;
    return any;
  }

  [[nodiscard]] const std::optional<TelemetrySample>& last() const noexcept { return last_; }
  /// The second hand's sample of the same tick; null: there is none, or it was dropped.
  [[nodiscard]] const TelemetrySample* lastOfSecondHand() const noexcept {
    return second_ && last_ && second_->tick == last_->tick ? &*second_ : nullptr;
  }
  /// Every sample, while they are kept.
  [[nodiscard]] TickHistory& ticks() noexcept { return ticks_; }
  /// Of both hands.
  [[nodiscard]] const MotionState& motion() const noexcept { return motion_; }
  [[nodiscard]] const ShapePlaces& shapes() const noexcept { return shapes_; }
  /// Energy that the objects gave the hand in the last 20 ms; and which gave most, object 0 for none.
  [[nodiscard]] const EnergyState& energy() const noexcept { return energy_; }
  [[nodiscard]] EnergySource largestEnergySource() const noexcept { return largestEnergySource_; }

 private:
  bool takeMotion() {
    const MotionState* newest = host_.takeMotion();
    HandHost* second = host_.secondHand();
    if (second == nullptr) {
      if (newest != nullptr) motion_ = *newest;
      return newest != nullptr;
    }
    const MotionState* newestOfSecond = second->takeMotion();
    if (newest != nullptr) motionOfFirst_ = *newest;
    if (newestOfSecond != nullptr) motionOfSecond_ = *newestOfSecond;
    if (newest == nullptr && newestOfSecond == nullptr) return false;
    motion_ = ofBothHands(motionOfFirst_, motionOfSecond_);
    return true;
  }

  void takeEnergy() {
    const EnergyState* newest = host_.takeEnergy();
    if (newest == nullptr) return;
    energy_ = *newest;
    largestEnergySource_ = largestSource(energy_).value_or(EnergySource{});
  }

  template <class OnAdopted>
  bool drainSamples(OnAdopted& onAdopted) {
    TelemetrySample sample;
    bool any = false;
    while (host_.popTelemetry(sample)) {
      any = true;
      last_ = sample;
      if (HandHost* second = host_.secondHand()) followTo(*second, sample.tick);
      const TelemetrySample& late = second_ && second_->sceneRevision < sample.sceneRevision ? *second_ : sample;
      if (late.sceneRevision != adoptedRevision_) {
        adoptedRevision_ = late.sceneRevision;
        onAdopted(late.sceneRevision, std::max(sample.adoptionTick, second_ ? second_->adoptionTick : 0));
      }
      ticks_.add(sample, lastOfSecondHand());
    }
    return any;
  }

  void followTo(HandHost& second, std::uint64_t tick) {
    TelemetrySample sample;
    while ((!second_ || second_->tick < tick) && second.popTelemetry(sample)) second_ = sample;
  }

  ServerHost& host_;
  std::optional<TelemetrySample> last_, second_;
  std::optional<std::uint64_t> adoptedRevision_;  ///< By every hand.
  TickHistory ticks_;
  MotionState motion_;
  MotionState motionOfFirst_, motionOfSecond_;  // where there are two hands
  ShapePlaces shapes_;
  EnergyState energy_;
  EnergySource largestEnergySource_;
};

}  // namespace haptics
