#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>
#include <span>
#include <type_traits>

#include "common/error/error.h"
#include "common/process/shared_memory.h"
#include "haptic_server/engine/step/two_hands.h"

namespace haptics {

/// One recorded tick: its inputs beside scene and state, and its outputs.
struct RecordedTick {
  StepInput input;
  std::uint64_t scene = 0;  ///< ServoScene::number of the one that came at its start; 0: none came.
  Vec3 force_N{0};          ///< As written to the device.
  Fault fault = Fault::kNone;
  Vec3 torque_Nm{0};       ///< As written to the device.
  HandleReading handle{};  ///< As read with its pose.
  Wrench added{};          ///< By a client.
  double grip_Nm = 0;      ///< As written to the device's gripper.
};
static_assert(std::is_trivially_copyable_v<RecordedTick>, "crosses threads by copy");

/// The state between two ticks, from which a recording can begin.
struct Keyframe {
  std::uint64_t position = 0;  ///< In the ring: of the tick that came next.
  std::uint64_t scene = 0;     ///< ServoScene::number of the one that the state had adopted, 0 for the empty one,
  std::uint64_t pending = 0;   ///< and of the one that it was still to adopt, 0 for none.
  StateFields state;
};

/// A hand between two ticks, of which a keyframe is taken.
struct StateMoment {
  const HapticState* state;
  std::uint64_t scene;    ///< As in Keyframe,
  std::uint64_t pending;  ///< likewise.
};

/// The last ticks of the servo in shared memory, allocated at the start, which outlives the process where another one has
/// mapped it: at least kSeconds of ticks, and a keyframe for each second of them, of each hand. One servo thread writes, one
/// other thread reads.
class FlightRing {
 public:
  /// How far back one can always look: a reader that is later than this has lost ticks.
  static constexpr double kSeconds = 10;

  /// @param hands  At most kMaxHands. Throws std::bad_alloc where the system has no such memory.
  FlightRing(double rate_Hz, std::size_t hands);
  /// For a reader in another process. Refused: memory of a build whose ring looks different.
  [[nodiscard]] static Result<FlightRing> attach(FileHandle memory);

  /// File descriptor of its memory, for attach().
  [[nodiscard]] int descriptor() const noexcept { return memory_.descriptor(); }

  /// Servo, wait-free. At a tick's start, before a scene is adopted: takes a keyframe where one is due.
  /// @param moments  Of each hand, as all spans of one tick here.
  void beginTick(std::span<const StateMoment> moments) noexcept;
  /// Servo, wait-free. At its end.
  void add(std::span<const RecordedTick> tick) noexcept;

  [[nodiscard]] std::size_t hands() const noexcept { return shared_->hands; }

  /// Reader, wait-free. Ticks added so far; the newest is at the position before this one.
  [[nodiscard]] std::uint64_t end() const noexcept { return shared_->end.load(std::memory_order_acquire); }
  /// Reader, wait-free. @return False when it has been overwritten.
  [[nodiscard]] bool read(std::uint64_t position, std::span<RecordedTick> tick) const noexcept;

  /// Reader, once the servo's process has ended: lets go of the keyframe that it was taking.
  void releaseDeadWriter() noexcept;

  /// Reader. While it lives the servo takes no keyframes: they can be read. One at a time.
  class HeldKeyframes {
   public:
    explicit HeldKeyframes(FlightRing& ring) noexcept;
    ~HeldKeyframes();
    HeldKeyframes(const HeldKeyframes&) = delete;
    HeldKeyframes& operator=(const HeldKeyframes&) = delete;
    /// The newest from which all ticks since `position` follow, else the oldest from which all are still there; of each
    /// hand. Empty: there is none.
    [[nodiscard]] std::span<const Keyframe> atOrBefore(std::uint64_t position) const noexcept;

   private:
    FlightRing& ring_;
  };

 private:
  static constexpr std::size_t kWords = (sizeof(RecordedTick) + 7) / 8;
  static constexpr std::size_t kKeyframes = static_cast<std::size_t>(kSeconds) + 3;
  using Slot = std::array<std::atomic<std::uint64_t>, kWords>;  // of a hand
  static_assert(std::atomic<std::uint64_t>::is_always_lock_free && std::atomic<bool>::is_always_lock_free);

  struct Shared {
    Shared(std::uint64_t hand, std::uint64_t slots, std::uint64_t perKeyframe) noexcept
        : hands(hand), slotCount(slots), ticksPerKeyframe(perKeyframe) {}

    std::uint64_t shape = kShape;
    std::uint64_t hands;
    std::uint64_t slotCount;  // of each hand
    std::uint64_t ticksPerKeyframe;
    std::atomic<std::uint64_t> begun{0};  // ticks whose slot is being written, or was
    std::atomic<std::uint64_t> end{0};
    std::uint64_t taken = 0;         // servo, and reader while it holds them: keyframes so far
    std::uint64_t nextKeyframe = 0;  // servo: position at which one is due
    std::atomic<bool> held{false};
    std::atomic<bool> taking{false};
  };
  /// Tells builds apart.
  static constexpr std::uint64_t kShape =
      (sizeof(RecordedTick) * 1'000'003 + sizeof(Keyframe)) * 1'000'003 + sizeof(Shared);

  static constexpr std::size_t kKeyframesAt =
      (sizeof(Shared) + alignof(Keyframe) - 1) / alignof(Keyframe) * alignof(Keyframe);
  static_assert(alignof(Slot) <= alignof(Keyframe));

  explicit FlightRing(SharedMemory memory) noexcept;
  [[nodiscard]] static std::size_t slotsAt(std::uint64_t hands) noexcept {
    return kKeyframesAt + hands * kKeyframes * sizeof(Keyframe);
  }
  [[nodiscard]] static std::size_t bytesFor(std::uint64_t hands, std::uint64_t slots) noexcept;

  SharedMemory memory_;  // Shared; keyframes, those of one moment together; slots, those of one tick together
  Shared* shared_;
  Keyframe* keyframes_;
  Slot* slots_;
  std::uint64_t slotCount_ = 0;
  std::size_t hands_ = 1;
};

}  // namespace haptics
