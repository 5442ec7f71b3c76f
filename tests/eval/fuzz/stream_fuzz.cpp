#include <algorithm>
#include <array>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "haptic_server/world/stepped_scene.h"
#include "tests/eval/fuzz/contact_judge.h"
#include "tests/eval/fuzz/contact_scene.h"
#include "tests/eval/fuzz/fuzz.h"
#include "tests/eval/fuzz/reshaped_world.h"
#include "tests/eval/fuzz/streamed_path.h"
#include "tests/eval/report.h"
#include "tests/eval/table1/interruption.h"

namespace haptics::eval {
namespace {

constexpr std::array kSamplePeriods{1, 1, 1, 8, 16, 33};  // ticks between samples
constexpr int kTicksToARest = 20;                         // of contact, from one in which it is looked for to the next
constexpr std::uint64_t kWorldsToALine = 100;
constexpr std::uint64_t kReshapedEvery = 4;  // world, vertices are moved,
constexpr std::uint64_t kInSceneEvery = 8;   // those of a scene's object by its edits

class StreamedWorld {
 public:
  StreamedWorld(std::uint64_t seed, double speed_m_per_s)
      : random_(seed),
        period_(kSamplePeriods[static_cast<std::size_t>(random_.below(static_cast<int>(kSamplePeriods.size())))]),
        scene_(seed, kindOf(seed, speed_m_per_s)),
        world_(device()),
        frame_(scene_.frame()),
        judge_(scene_.meshes(), frame_) {
    for (std::size_t i = 0; i < scene_.meshes().size(); ++i) {
      const FuzzMesh& mesh = scene_.meshes()[i];
      std::vector<std::array<float, 3>> vertices;
      for (const Vec3f& v : mesh.vertices) vertices.push_back({v.x, v.y, v.z});
      bodies_.push_back(world_.add("body" + std::to_string(i), {vertices, mesh.triangles},
                                   {.stiffness_N_per_m = kStreamStiffness_N_per_m, .damping_Ns_per_m = 0},
                                   worldPose(frame_.poses[i])));
      paths_.emplace_back(frame_.poses[i]);
    }
    for (int i = 0; i < kRiseTicks; ++i) {
      stream(i, frame_.poses);
      static_cast<void>(world_.step(vectorOf(frame_.hip)));
    }
  }

  [[nodiscard]] StreamRun run() {
    StreamCount counted;
    Vec3 ihip = frame_.hip;
    for (int tick = kRiseTicks; tick < kRiseTicks + kStreamedTicks; ++tick) {
      const ContactFrame& now = scene_.next(ihip);
      stream(tick, now.poses);
      frame_.hip = now.hip;
      const World::Sample sample = world_.step(vectorOf(now.hip));
      ihip = vec(sample.ihip_m);
      count(sample, ihip, counted);
      if (counted.notFinite > 0) break;
    }
    return {counted, period_};
  }

 private:
  /// A third are of thin plates; in every other one bodies are as fast as the hand.
  [[nodiscard]] static ContactSceneKind kindOf(std::uint64_t seed, double speed_m_per_s) {
    constexpr double kFast = 4;
    return {true, speed_m_per_s, seed % 3 == 2 ? ContactWorld::kThin : ContactWorld::kWild, seed % 2 == 0 ? 1 : kFast};
  }
  [[nodiscard]] static World::Device device() {
    World::Device device;
    device.maxForce_N = 1000;
    return device;
  }

  /// Samples come a little early or late, of all bodies at once.
  void stream(int tick, const std::vector<Pose>& poses) {
    if (tick >= due_) {
      for (std::size_t i = 0; i < bodies_.size(); ++i) {
        world_.moveKinematic(bodies_[i], worldPose(poses[i]));
        paths_[i].sample(poses[i], last_ < 0 ? 1 : tick - last_);
      }
      last_ = tick;
      due_ = tick + (period_ == 1 ? 1 : period_ + random_.below(period_ / 2) - period_ / 4);
    }
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      paths_[i].tick();
      frame_.poses[i] = paths_[i].at();
    }
  }

  void count(const World::Sample& sample, Vec3 ihip, StreamCount& counted) {
    const bool waits = sample.allowanceSpent || waited_;  // the contact is not yet where the bodies are, or was not
    waited_ = sample.allowanceSpent;
    const ContactVerdict verdict = judge_.judge(frame_, ihip, sample.depenetrated || waits);
    ++counted.ticks;
    counted.touching += sample.body != 0 ? 1 : 0;
    const bool isInside = verdict.inside_m > 0 && !(sample.depenetrated && !wasInside_);
    wasInside_ = verdict.inside_m > 0;
    (waits ? counted.insideWaiting : counted.inside) += isInside ? 1 : 0;
    counted.crossed += verdict.crossed && !sample.depenetrated && !waits ? 1 : 0;
    counted.notFinite += verdict.finite ? 0 : 1;
    counted.deepest_m = std::max(counted.deepest_m, verdict.inside_m);
    hasJumped_ = hasJumped_ || sample.allowanceSpent || sample.depenetrated;
    if (hasJumped_) return;  // that is let in at 30 N/s, and with it what moves meanwhile
    const Vec3 expected_N = kStreamStiffness_N_per_m * (ihip - frame_.hip);
    const double off_N = glm::distance(vec(sample.force_N), expected_N);
    const double allowed_N = kForcePart * glm::length(expected_N) + kForceBeside_N;
    counted.otherForce += off_N > allowed_N ? 1 : 0;
    countRest(sample, allowed_N / kStreamStiffness_N_per_m, counted);
  }

  /// Where a minimum ends the contact may need a tick more.
  void countRest(const World::Sample& sample, double off_m, StreamCount& counted) {
    const bool wasLate = std::exchange(late_, false);
    if (sample.body == 0 || (!wasLate && ++sinceRest_ < kTicksToARest)) return;
    sinceRest_ = 0;
    ++counted.rests;
    if (judge_.isAtRest(frame_, off_m, random_)) return;
    ++(wasLate ? counted.notAtRest : counted.late);
    late_ = true;
  }

  Random random_;
  int period_;
  ContactScene scene_;
  World world_;
  ContactFrame frame_;  // as the bodies are
  ContactJudge judge_;
  std::vector<std::uint64_t> bodies_;
  std::vector<StreamedPath> paths_;
  int due_ = 0, last_ = -1, sinceRest_ = 0;
  bool wasInside_ = false, waited_ = false, hasJumped_ = false, late_ = false;  // the IHIP
};

}  // namespace

bool runFuzzStream(const FuzzOptions& options, const std::filesystem::path& out) {
  Interruption interruption;
  StreamCount all, reshaped;
  std::vector<Record> findings;
  std::uint64_t done = 0;
  for (; done < options.scenes && !interruption.came(); ++done) {
    const std::uint64_t seed = options.seed + done;
    const double speed_m_per_s = options.speed_m_per_s.value_or(1);
    const bool isReshaped = seed % kReshapedEvery == kReshapedEvery - 1;
    const auto [counted, period] =
        isReshaped ? runReshapedWorld(seed, speed_m_per_s, seed % kInSceneEvery == kInSceneEvery - 1)
                   : StreamedWorld(seed, speed_m_per_s).run();
    all += counted;
    reshaped += isReshaped ? counted : StreamCount{};
    if (counted.wrong() > 0) {
      findings.push_back({{"fuzz", "stream"},
                          {"seed", seed},
                          {"shape", isReshaped},
                          {"ticks_a_sample", period},
                          {"inside", counted.inside},
                          {"deepest_mm", counted.deepest_m * 1e3},
                          {"crossed", counted.crossed},
                          {"not_finite", counted.notFinite},
                          {"other_force", counted.otherForce},
                          {"not_at_rest", counted.notAtRest},
                          {"pass", false}});
      showFinding(findings.back());
    }
    showProgress(done + 1, options.scenes, kWorldsToALine, findings.size());
  }
  std::vector<Record> records{{{"fuzz", "stream"},
                               {"seed", options.seed},
                               {"worlds", done},
                               {"ticks", all.ticks},
                               {"contact_ticks", all.touching},
                               {"reshaped_ticks", reshaped.ticks},
                               {"reshaped_contact_ticks", reshaped.touching},
                               {"inside", all.inside},
                               {"inside_while_waiting", all.insideWaiting},
                               {"crossed", all.crossed},
                               {"other_force", all.otherForce},
                               {"rests", all.rests},
                               {"late", all.late},
                               {"not_at_rest", all.notAtRest},
                               {"pass", findings.empty()}}};
  records.insert(records.end(), findings.begin(), findings.end());
  writeRecords(out, "fuzz", records);
  if (interruption.came()) std::printf("interrupted: this is what was found by then\n");
  const auto number = [](std::uint64_t n) { return std::to_string(n); };
  std::printf(
      "%s worlds, %s ticks, %s of them in contact; ticks inside: %s (%s more that say their allowance was spent), on a "
      "sheet's other side: %s, with another force: %s, of %s not where it rests: %s (%s a tick late); %zu worlds "
      "failed\n",
      number(done).c_str(), number(all.ticks).c_str(), number(all.touching).c_str(), number(all.inside).c_str(),
      number(all.insideWaiting).c_str(), number(all.crossed).c_str(), number(all.otherForce).c_str(),
      number(all.rests).c_str(), number(all.notAtRest).c_str(), number(all.late).c_str(), findings.size());
  return findings.empty();
}

}  // namespace haptics::eval
