#include "haptic_server/servo/flight_ring.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <new>
#include <thread>
#include <utility>

namespace haptics {
namespace {

/// Beyond kSeconds, so that who reads the oldest of them is not overtaken while it does.
constexpr double kSlack_s = 2;

}  // namespace

FlightRing::FlightRing(double rate_Hz, std::size_t hands)
    : FlightRing([&] {
        const auto slots = static_cast<std::uint64_t>(std::ceil((kSeconds + kSlack_s) * rate_Hz));
        auto memory = SharedMemory::make("flight ring", bytesFor(hands, slots));
        if (!memory) throw std::bad_alloc();
        std::construct_at(reinterpret_cast<Shared*>(memory->bytes().data()), hands, slots,
                          static_cast<std::uint64_t>(std::ceil(rate_Hz)));
        return *std::move(memory);
      }()) {
  for (std::size_t i = 0; i < hands_ * kKeyframes; ++i) std::construct_at(keyframes_ + i);
  std::uninitialized_value_construct_n(slots_, hands_ * slotCount_);
}

FlightRing::FlightRing(SharedMemory memory) noexcept
    : memory_(std::move(memory)),
      shared_(reinterpret_cast<Shared*>(memory_.bytes().data())),
      keyframes_(reinterpret_cast<Keyframe*>(memory_.bytes().data() + kKeyframesAt)),
      slots_(reinterpret_cast<Slot*>(memory_.bytes().data() + slotsAt(shared_->hands))),
      slotCount_(shared_->slotCount),
      hands_(shared_->hands) {}

Result<FlightRing> FlightRing::attach(FileHandle memory) {
  auto mapped = SharedMemory::map(std::move(memory), slotsAt(1));
  if (!mapped) return tl::unexpected(std::move(mapped.error()));
  const auto& shared = *reinterpret_cast<const Shared*>(mapped->bytes().data());
  if (shared.shape != kShape || shared.hands < 1 || shared.hands > kMaxHands || shared.slotCount < 1 ||
      shared.slotCount > mapped->bytes().size() / sizeof(Slot) ||
      bytesFor(shared.hands, shared.slotCount) > mapped->bytes().size()) {
    return refused("flight ring", "is that of another build");
  }
  return FlightRing(*std::move(mapped));
}

std::size_t FlightRing::bytesFor(std::uint64_t hands, std::uint64_t slots) noexcept {
  return slotsAt(hands) + hands * slots * sizeof(Slot);
}

void FlightRing::releaseDeadWriter() noexcept {
  constexpr std::uint64_t kNone = ~std::uint64_t{0};
  if (shared_->taking.exchange(false)) {
    // It may have been counted already, or not.
    for (const std::uint64_t index : {shared_->taken, shared_->taken + kKeyframes - 1}) {
      for (std::size_t hand = 0; hand < hands_; ++hand) keyframes_[index % kKeyframes * hands_ + hand].position = kNone;
    }
  }
}

void FlightRing::beginTick(std::span<const StateMoment> moments) noexcept {
  const std::uint64_t position = shared_->end.load(std::memory_order_relaxed);
  if (position < shared_->nextKeyframe) return;
  // Either the reader sees that one is being taken, or this sees that they are held.
  shared_->taking.store(true, std::memory_order_seq_cst);
  if (!shared_->held.load(std::memory_order_seq_cst)) {
    Keyframe* keyframe = keyframes_ + shared_->taken++ % kKeyframes * hands_;
    for (const StateMoment& moment : moments) {
      keyframe->position = position;
      keyframe->scene = moment.scene;
      keyframe->pending = moment.pending;
      copyInUse<StateFields>(keyframe->state, *moment.state);
      ++keyframe;
    }
    shared_->nextKeyframe = position + shared_->ticksPerKeyframe;
  }
  shared_->taking.store(false, std::memory_order_release);
}

void FlightRing::add(std::span<const RecordedTick> tick) noexcept {
  const std::uint64_t position = shared_->end.load(std::memory_order_relaxed);
  shared_->begun.store(position + 1, std::memory_order_relaxed);
  std::atomic_thread_fence(std::memory_order_release);
  Slot* slot = slots_ + position % slotCount_ * hands_;
  for (const RecordedTick& ofHand : tick) {
    std::array<std::uint64_t, kWords> words{};
    std::memcpy(words.data(), &ofHand, sizeof ofHand);
    for (std::size_t i = 0; i < kWords; ++i) (*slot)[i].store(words[i], std::memory_order_relaxed);
    ++slot;
  }
  shared_->end.store(position + 1, std::memory_order_release);
}

bool FlightRing::read(std::uint64_t position, std::span<RecordedTick> tick) const noexcept {
  if (position >= end()) return false;
  const Slot* slot = slots_ + position % slotCount_ * hands_;
  for (RecordedTick& ofHand : tick) {
    std::array<std::uint64_t, kWords> words;
    for (std::size_t i = 0; i < kWords; ++i) words[i] = (*slot)[i].load(std::memory_order_relaxed);
    std::memcpy(static_cast<void*>(&ofHand), words.data(), sizeof ofHand);
    ++slot;
  }
  std::atomic_thread_fence(std::memory_order_acquire);
  return shared_->begun.load(std::memory_order_relaxed) <= position + slotCount_;
}

FlightRing::HeldKeyframes::HeldKeyframes(FlightRing& ring) noexcept : ring_(ring) {
  ring_.shared_->held.store(true, std::memory_order_seq_cst);
  while (ring_.shared_->taking.load(std::memory_order_seq_cst)) std::this_thread::yield();
}

FlightRing::HeldKeyframes::~HeldKeyframes() { ring_.shared_->held.store(false, std::memory_order_seq_cst); }

std::span<const Keyframe> FlightRing::HeldKeyframes::atOrBefore(std::uint64_t position) const noexcept {
  const std::uint64_t end = ring_.end();
  const std::uint64_t capacity = ring_.slotCount_;
  const std::uint64_t oldest = end > capacity ? end - capacity : 0;
  const Keyframe* best = nullptr;
  const std::size_t count = std::min<std::size_t>(ring_.shared_->taken, kKeyframes);
  for (std::size_t i = 0; i < count; ++i) {
    const Keyframe& keyframe = ring_.keyframes_[i * ring_.hands_];
    if (keyframe.position < oldest || keyframe.position > end) continue;
    const bool early = keyframe.position <= position;
    const bool bestEarly = best != nullptr && best->position <= position;
    const bool better =
        best == nullptr ||
        (early == bestEarly ? (early ? keyframe.position > best->position : keyframe.position < best->position)
                            : early);
    if (better) best = &keyframe;
  }
  return {best, best != nullptr ? ring_.hands_ : 0};
}

}  // namespace haptics
