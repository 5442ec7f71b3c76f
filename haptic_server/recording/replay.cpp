#include "haptic_server/recording/replay.h"

#include <algorithm>
#include <bit>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "haptic_server/recording/recorded_scenes.h"
#include "haptic_server/recording/recording_reader.h"
#include "haptic_server/recording/state_image.h"
#include "haptic_server/servo/moving_bodies.h"
#include "haptic_server/servo/soft_bodies.h"

namespace haptics {
namespace {

[[nodiscard]] bool sameBits(Vec3 a, Vec3 b) {
  const auto bits = [](double x) { return std::bit_cast<std::uint64_t>(x); };
  return bits(a.x) == bits(b.x) && bits(a.y) == bits(b.y) && bits(a.z) == bits(b.z);
}

/// The servo of a recording, in its own time.
class ReplayedServo {
 public:
  ReplayedServo(ReplayOutcome& outcome, bool sameLayout, const OnReplayedTick& onTick)
      : outcome_(outcome),
        sameLayout_(sameLayout),
        onTick_(onTick),
        state_(std::make_unique<HapticState>(outcome.facts.config)) {}

  [[nodiscard]] Result<void> take(const v1::RecordingPart& part) {
    switch (part.part_case()) {
      case v1::RecordingPart::kAsset:
        return scenes_.add(part.asset());
      case v1::RecordingPart::kScene:
        return take(part.scene());
      case v1::RecordingPart::kState:
        return take(part.state());
      case v1::RecordingPart::kTicks:
        return take(part.ticks());
      default:
        return refused("head", "comes a second time");
    }
  }

 private:
  [[nodiscard]] Result<void> take(const v1::RecordedScene& message) {
    auto scene = scenes_.make(message);
    if (!scene) return tl::unexpected(std::move(scene.error()));
    given_[message.number()] = *std::move(scene);
    ++outcome_.scenes;
    return {};
  }

  [[nodiscard]] Result<void> take(const v1::RecordedState& message) {
    if (outcome_.ticks != 0) return refused("state", "comes after the first tick");
    if (!sameLayout_) {
      return refused("state",
                     "was recorded by a build whose state looks different, and the recording begins with it; "
                     "replay it with that build");
    }
    if (message.scene() != 0 && !find(message.scene(), scene_)) return unknownScene("state.scene", message.scene());
    if (message.pending() != 0 && !find(message.pending(), next_))
      return unknownScene("state.pending", message.pending());
    auto state = stateFrom(message.image(), *scene_, outcome_.facts.config);
    if (!state) return tl::unexpected(std::move(state.error()));
    state_ = *std::move(state);
    return {};
  }

  [[nodiscard]] Result<void> take(const v1::RecordedTicks& message) {
    std::string_view bytes = message.ticks();
    if (bytes.size() % kTickBytes != 0) return refused("ticks", "has a part of a tick");
    for (; !bytes.empty(); bytes.remove_prefix(kTickBytes)) {
      const auto tick = tickFrom(bytes.substr(0, kTickBytes));
      if (!tick) return tl::unexpected(tick.error());
      if (auto run = take(*tick); !run) return run;
    }
    return {};
  }

  [[nodiscard]] Result<void> take(const RecordedTick& recorded) {
    if (outcome_.ticks != 0 && recorded.input.tick <= lastTick_)
      return refused("ticks",
                     "tick " + std::to_string(recorded.input.tick) + " comes after tick " + std::to_string(lastTick_));
    if (recorded.scene != 0 && !find(recorded.scene, next_)) return unknownScene("ticks.scene", recorded.scene);
    if (next_ != nullptr && adoptScene(*next_, *state_, recorded.input.tick)) {
      scene_ = std::exchange(next_, nullptr);
      std::erase_if(given_, [this](const auto& given) { return given.first < scene_->number; });
    }
    const TelemetrySample sample = hapticStep(*scene_, *state_, outcome_.facts.config, recorded.input);
    account(recorded, sample);
    if (onTick_) {
      const bool moved = describeMotion(*state_, recorded.input.tick, motion_);
      const bool gave = describeDents(*state_, recorded.input.tick, motion_);
      onTick_(sample, moved || gave ? &motion_ : nullptr);
    }
    return {};
  }

  void account(const RecordedTick& recorded, const TelemetrySample& sample) {
    if (!sameBits(recorded.force_N, sample.force.written)) {
      ++outcome_.differing;
      const ForceDifference difference{outcome_.ticks, recorded.input.tick, recorded.force_N, sample.force.written};
      if (!outcome_.first) outcome_.first = difference;
      outcome_.largestDifference_N =
          std::max(outcome_.largestDifference_N, glm::distance(difference.recorded_N, difference.now_N));
    }
    if (outcome_.ticks != 0) outcome_.missed += recorded.input.tick - lastTick_ - 1;
    if (sample.object != 0) ++outcome_.contactTicks;
    lastTick_ = recorded.input.tick;
    ++outcome_.ticks;
  }

  [[nodiscard]] bool find(std::uint64_t number, const ServoScene*& scene) const {
    const auto at = given_.find(number);
    if (at != given_.end()) scene = at->second.get();
    return at != given_.end();
  }
  [[nodiscard]] static tl::unexpected<Error> unknownScene(const char* field, std::uint64_t number) {
    return refused(field, "names scene " + std::to_string(number) + ", which is not there, or was left behind");
  }

  ReplayOutcome& outcome_;
  bool sameLayout_;
  const OnReplayedTick& onTick_;
  RecordedScenes scenes_;
  std::map<std::uint64_t, std::unique_ptr<const ServoScene>> given_;  // that may still be used, by number
  ServoScene empty_;
  const ServoScene* scene_ = &empty_;
  const ServoScene* next_ = nullptr;
  std::unique_ptr<HapticState> state_;
  MotionState motion_;
  std::uint64_t lastTick_ = 0;
};

}  // namespace

Result<ReplayOutcome> replay(std::string_view recording, const OnReplayedTick& onTick) {
  auto reader = RecordingReader::open(recording);
  if (!reader) return tl::unexpected(std::move(reader.error()));
  ReplayOutcome outcome;
  outcome.facts = reader->facts();
  outcome.sameStep = outcome.facts.stepSources == ownStepSources();
  ReplayedServo servo(outcome, reader->sameLayout(), onTick);
  for (;;) {
    const auto part = reader->next();
    Result<void> taken;
    if (!part) {
      taken = tl::unexpected(part.error());
    } else if (*part == nullptr) {
      outcome.cutOff = reader->cutOff();
      return outcome;
    } else {
      taken = servo.take(**part);
    }
    if (!taken) {
      outcome.refusal = taken.error();
      return outcome;
    }
  }
}

}  // namespace haptics
