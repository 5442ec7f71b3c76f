#include "haptic_server/servo/flight_ring.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <thread>

namespace haptics {
namespace {

/// Beyond kSeconds, so that who reads the oldest of them is not overtaken while it does.
constexpr double kSlack_s = 2;

}  // namespace

FlightRing::FlightRing(double rate_Hz, const StepConfig& config)
    : slots_(static_cast<std::size_t>(std::ceil((kSeconds + kSlack_s) * rate_Hz))),
      ticksPerKeyframe_(static_cast<std::uint64_t>(std::ceil(rate_Hz))),
      keyframes_(kKeyframes, Keyframe(config)) {}

void FlightRing::beginTick(const HapticState& state, std::uint64_t scene, std::uint64_t pending) noexcept {
  const std::uint64_t position = end_.load(std::memory_order_relaxed);
  if (position < nextKeyframe_) return;
  // Either the reader sees that one is being taken, or this sees that they are held.
  taking_.store(true, std::memory_order_seq_cst);
  if (!held_.load(std::memory_order_seq_cst)) {
    Keyframe& keyframe = keyframes_[taken_++ % kKeyframes];
    keyframe.position = position;
    keyframe.scene = scene;
    keyframe.pending = pending;
    keyframe.state.copyInUse(state);
    nextKeyframe_ = position + ticksPerKeyframe_;
  }
  taking_.store(false, std::memory_order_release);
}

void FlightRing::add(const RecordedTick& tick) noexcept {
  const std::uint64_t position = end_.load(std::memory_order_relaxed);
  std::array<std::uint64_t, kWords> words{};
  std::memcpy(words.data(), &tick, sizeof tick);
  begun_.store(position + 1, std::memory_order_relaxed);
  std::atomic_thread_fence(std::memory_order_release);
  Slot& slot = slots_[position % slots_.size()];
  for (std::size_t i = 0; i < kWords; ++i) slot[i].store(words[i], std::memory_order_relaxed);
  end_.store(position + 1, std::memory_order_release);
}

bool FlightRing::read(std::uint64_t position, RecordedTick& tick) const noexcept {
  if (position >= end()) return false;
  std::array<std::uint64_t, kWords> words;
  const Slot& slot = slots_[position % slots_.size()];
  for (std::size_t i = 0; i < kWords; ++i) words[i] = slot[i].load(std::memory_order_relaxed);
  std::atomic_thread_fence(std::memory_order_acquire);
  if (begun_.load(std::memory_order_relaxed) > position + slots_.size()) return false;
  std::memcpy(static_cast<void*>(&tick), words.data(), sizeof tick);
  return true;
}

FlightRing::HeldKeyframes::HeldKeyframes(FlightRing& ring) noexcept : ring_(ring) {
  ring_.held_.store(true, std::memory_order_seq_cst);
  while (ring_.taking_.load(std::memory_order_seq_cst)) std::this_thread::yield();
}

FlightRing::HeldKeyframes::~HeldKeyframes() { ring_.held_.store(false, std::memory_order_seq_cst); }

const Keyframe* FlightRing::HeldKeyframes::atOrBefore(std::uint64_t position) const noexcept {
  const std::uint64_t end = ring_.end();
  const std::uint64_t capacity = ring_.slots_.size();
  const std::uint64_t oldest = end > capacity ? end - capacity : 0;
  const Keyframe* best = nullptr;
  const std::size_t count = std::min<std::size_t>(ring_.taken_, kKeyframes);
  for (std::size_t i = 0; i < count; ++i) {
    const Keyframe& keyframe = ring_.keyframes_[i];
    if (keyframe.position < oldest) continue;
    const bool early = keyframe.position <= position;
    const bool bestEarly = best != nullptr && best->position <= position;
    const bool better =
        best == nullptr ||
        (early == bestEarly ? (early ? keyframe.position > best->position : keyframe.position < best->position)
                            : early);
    if (better) best = &keyframe;
  }
  return best;
}

}  // namespace haptics
