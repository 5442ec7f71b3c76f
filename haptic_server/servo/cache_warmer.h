#pragma once

#include "haptic_server/engine/contact/fast_path/triangle_cache.h"
#include "haptic_server/engine/step/haptic_step.h"

namespace haptics {

/// Rehearses the coming tick while the hand's place is not yet known. After a period of sleep the caches have lost what
/// a tick reads, and it would wait for memory between the device's position and its force, the longer the larger the
/// mesh; after a rehearsal it need not. What comes after the force is awaited by nobody, and not rehearsed.
class CacheWarmer {
 public:
  explicit CacheWarmer(const StepConfig& config) noexcept : config_(config), rehearsal_(config) {}

  /// Runs computeForce() on a copy of the state, with the HIP where its velocity takes it; then works out the polygons
  /// around the contact, before and after, which the tick may come over; then, unless that took too long, runs the step
  /// once more, which teaches the processor what branches to expect. Costs what a tick with cold caches costs, between
  /// two ticks, and changes nothing that the tick can tell. Does nothing after a tick that took much of its allowance,
  /// for the next may take all.
  void operator()(const ServoScene& scene, const HapticState& state) noexcept;

  /// The allowance that a tick has left.
  void note(const Allowance& left) noexcept { left_ = left; }

  /// For the tick that comes next, until a scene is adopted.
  [[nodiscard]] const TriangleCache& cache() const noexcept { return cache_; }

 private:
  void prefetchNeighbours(const ContactState& contact, Allowance& looks) noexcept;
  /// False when its allowance did not last.
  bool rehearse(const ServoScene& scene, const HapticState& state) noexcept;

  StepConfig config_;
  HapticState rehearsal_;
  TriangleCache cache_;
  Allowance left_;                     // of the last tick's
  const ServoScene* scene_ = nullptr;  // whose polygons are known
  bool isCopy_ = false;                // the rehearsal, of a state that has that scene
};

}  // namespace haptics
