#include "tests/e2e/recorded_rest.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "haptic_server/engine/step/haptic_step.h"
#include "haptic_server/engine/step/held_springs.h"
#include "haptic_server/recording/recorded_run.h"
#include "tests/eval/fuzz/edit_judge.h"
#include "tests/eval/or_throw.h"

namespace haptics::e2e {
namespace {

constexpr double kRest_s = 0.1;  // after the device has come to rest, as in the fuzzer
constexpr double kSame_N = 0.03;
constexpr double kSamePart = 0.01;

class RestJudge {
 public:
  RestJudge(const RecordingFacts& facts, const std::vector<SentWindow>& windows)
      : config_(facts.config),
        restTicks_(static_cast<std::uint64_t>(kRest_s * facts.rate_Hz)),
        riseTicks_(static_cast<std::uint64_t>((kRest_s + facts.config.rise_s) * facts.rate_Hz)),
        maxStep_N_(eval::EditJudge::kMaxStep_N_per_s / facts.rate_Hz),
        windows_(windows) {}

  void observe(const TelemetrySample& sample, const ServoScene& scene, const HapticState& state) {
    ++verdict_.ticks;
    if (sample.fault != Fault::kNone) {
      ++verdict_.faults;
      faultUntil_ = sample.tick + riseTicks_;
      attachedInside_ = true;
    }
    if (!isFinite(sample.force.written)) fail(sample, "the force is no number");
    if (verdict_.ticks > 1) observeStep(sample);
    if (next_ < windows_.size() && sample.time_ns >= windows_[next_].settled_ns) {
      settle(windows_[next_], sample, scene, state);
      ++next_;
    }
    last_ = sample;
  }

  [[nodiscard]] const RestVerdict& verdict() const noexcept { return verdict_; }
  void differs() { ++verdict_.differing; }

 private:
  void observeStep(const TelemetrySample& sample) {
    constexpr double kRounding_N = 1e-6;
    const std::uint64_t periods = sample.tick - last_.tick;
    verdict_.missed += periods - 1;
    if (sample.hip != last_.hip) restingSince_ = sample.tick;
    if (sample.tick - restingSince_ <= restTicks_ || sample.tick <= faultUntil_) return;
    ++verdict_.resting;
    const double step_N = glm::distance(sample.force.written, last_.force.written);
    const double perPeriod_N = step_N / static_cast<double>(periods);
    verdict_.largestStep_N = std::max(verdict_.largestStep_N, perPeriod_N);
    if (perPeriod_N > maxStep_N_ + kRounding_N && kicked_ != next_) {
      kicked_ = next_;  // once for each window
      fail(sample, "the force changes by " + std::to_string(step_N) + " N in " + std::to_string(periods) + " ticks");
    }
  }

  void settle(const SentWindow& sent, const TelemetrySample& sample, const ServoScene& scene,
              const HapticState& state) {
    if (sample.tick <= faultUntil_) return;
    ++verdict_.settled;
    if (sample.tick - restingSince_ <= restTicks_) fail(sample, "the HIP does not rest");
    if (sample.sceneRevision < sent.revision) {
      fail(sample,
           "revision " + std::to_string(sample.sceneRevision) + " is felt instead of " + std::to_string(sent.revision));
    }
    if (sample.object != 0) ++verdict_.inContact;
    const Vec3 expected_N = limitMagnitude(expectedForce_N(sample, scene, state), config_.maxForce_N);
    const double difference_N = glm::distance(sample.force.written, expected_N);
    if (difference_N > kSame_N + kSamePart * glm::length(expected_N)) {
      fail(sample, "the force is " + std::to_string(difference_N) + " N off what the scene says");
    }
    const double depth_m = deepest_m(sent, sample, state);
    if (depth_m == 0) attachedInside_ = false;
    if (depth_m > 0 && !attachedInside_) {
      fail(sample, "the IHIP is " + std::to_string(1e3 * depth_m) + " mm inside a body");
    }
  }

  /// Nothing is left of the edit, and the spring is as stiff as the object that is touched, or as each that holds. Where shading or a texture may
  /// reach the HIP, only the first is known.
  [[nodiscard]] Vec3 expectedForce_N(const TelemetrySample& sample, const ServoScene& scene, const HapticState& state) {
    const auto touched = std::ranges::find(scene.objects, sample.object, &ServoObject::id);
    if (touched == scene.objects.end() || state.features.bumps) return sample.force.contact;
    ++verdict_.exact;
    if (severalBodiesHold(state)) {
      GrooveSprings own, felt;
      const auto holding = state.contact.surfaces();
      for (std::size_t k = 0; k < holding.size(); ++k) {
        const auto body = static_cast<std::size_t>(holding[k].body);
        own.add(heldNormal(state, k), scene.objects[body].pendingRemoval ? 0 : scene.objects[body].stiffness_N_per_m);
        felt.add(heldNormal(state, k), state.objects[body].stiffness.mean().spring_N_per_m);
      }
      const Vec3 penetration_m = sample.ihip - sample.predictedHip;
      return sample.force.contact + own.force_N(penetration_m) - felt.force_N(penetration_m);
    }
    const double stiffness_N_per_m = touched->pendingRemoval ? 0 : touched->stiffness_N_per_m;
    return sample.force.contact + stiffness_N_per_m * (sample.ihip - sample.predictedHip) - sample.force.spring;
  }

  /// Of the IHIP in closed bodies, which are as they are at rest but for a soft one that is touched.
  [[nodiscard]] static double deepest_m(const SentWindow& sent, const TelemetrySample& sample,
                                        const HapticState& state) {
    const Vec3 ihip = sample.object == 0 ? state.contact.hip : state.contact.ihip;
    double deepest_m = 0;
    for (const eval::FuzzObject& object : sent.from->windows()[sent.window].objects) {
      const eval::FuzzMesh& mesh = sent.from->mesh(object.mesh);
      if (object.pendingRemoval || !mesh.closed()) continue;
      const eval::SolidOracle oracle(mesh.vertices, mesh.triangles);
      deepest_m = std::max(deepest_m, oracle.depth_m(toLocal(object.pose, ihip)));
    }
    return deepest_m;
  }

  void fail(const TelemetrySample& sample, const std::string& what) {
    std::string where = "tick " + std::to_string(sample.tick);
    if (next_ < windows_.size()) {
      const SentWindow& sent = windows_[next_];
      where += ", edit \"" + sent.from->windows()[sent.window].kind + "\" of revision " + std::to_string(sent.revision);
    }
    verdict_.failures.push_back(where + ": " + what);
  }

  const StepConfig config_;
  const std::uint64_t restTicks_;
  const std::uint64_t riseTicks_;  // after a fault
  const double maxStep_N_;
  const std::vector<SentWindow>& windows_;
  std::size_t next_ = 0;
  std::optional<std::size_t> kicked_;
  TelemetrySample last_;
  std::uint64_t restingSince_ = 0;
  std::uint64_t faultUntil_ = 0;
  bool attachedInside_ = false;  // may be: after a fault the IHIP begins at the HIP
  RestVerdict verdict_;
};

}  // namespace

RestVerdict judgeRest(const RecordingBytes& recording, const std::vector<SentWindow>& windows) {
  AssetStore store;
  const auto run = eval::orThrow(RecordedRun::open(recording, store));
  RestJudge judge(run->facts(), windows);
  const auto state = std::make_unique<HapticState>(run->facts().config);
  const ServoScene empty;
  const ServoScene* scene = &empty;
  const ServoScene* next = nullptr;
  for (;;) {
    const auto tick = eval::orThrow(run->next());
    if (!tick) return judge.verdict();
    const StepInput& input = tick->recorded[0].input;
    if (tick->given != nullptr) next = tick->given->scene.get();
    if (next != nullptr && adoptScene(*next, *state, input.tick)) {
      scene = std::exchange(next, nullptr);
      run->releaseBefore(scene->number);
    }
    const TelemetrySample sample = hapticStep(*scene, *state, run->facts().config, input);
    if (!sameBits(tick->recorded[0].force_N, sample.force.written)) judge.differs();
    judge.observe(sample, *scene, *state);
  }
}

}  // namespace haptics::e2e
