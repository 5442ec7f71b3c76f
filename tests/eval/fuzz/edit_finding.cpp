#include "tests/eval/fuzz/edit_finding.h"

#include <algorithm>
#include <array>
#include <set>

#include "tests/eval/fuzz/contact_judge.h"

namespace haptics::eval {
namespace {

/// A run that fails in a way, and what can be left out of it.
class Reduction {
 public:
  Reduction(EditRun run, const EditFinding& finding) : run_(std::move(run)), finding_(finding) {}

  /// The edit itself stays where it comes.
  void dropScenes() {
    for (std::size_t i = run_.scenes.size() - 1; i-- > 0;) {
      if (i == 0 && run_.scenes[1].tick >= run_.windows.front().begin) continue;
      EditRun less = run_;
      if (i == 0) less.scenes[1].tick = less.scenes[0].tick;
      less.scenes.erase(less.scenes.begin() + static_cast<std::ptrdiff_t>(i));
      keep(std::move(less));
    }
  }

  /// Goes straight to where the HIP rests, from beside the IHIP.
  void goStraight() {
    constexpr double kBeside_m = 0.002;
    constexpr std::size_t kOnTheWay = 50;
    constexpr std::size_t kAtRest = 50;
    const std::uint64_t begin = run_.windows.front().begin;
    EditDrive drive(run_);
    for (std::uint64_t tick = 0; tick < begin; ++tick) drive.step(run_.hips[tick]);
    const Vec3 rest = run_.hips[begin];
    const Vec3 back = drive.state().contact.ihip - rest;
    if (drive.sample().object == 0 || back == Vec3(0) || begin < kOnTheWay + kAtRest) return;
    const Vec3 from = rest + back * (1 + kBeside_m / glm::length(back));
    EditRun less = fromTick(begin - kOnTheWay - kAtRest);
    for (std::size_t i = 0; i < kOnTheWay + kAtRest; ++i) {
      less.hips[i] = glm::mix(from, rest, std::min(1.0, static_cast<double>(i) / kOnTheWay));
    }
    if (isOutside(less)) keep(std::move(less));
  }

  /// Begins as late as it can where the HIP is outside of everything.
  void dropFirstTicks() {
    constexpr std::uint64_t kTries = 32;
    constexpr std::uint64_t kAtRest = 20;
    const std::uint64_t begin = run_.windows.front().begin;
    if (begin <= kAtRest) return;
    const std::uint64_t last = begin - kAtRest;
    const std::uint64_t stride = std::max<std::uint64_t>(1, last / kTries);
    for (std::uint64_t first = last; first >= stride; first -= stride) {
      EditRun less = fromTick(first);
      if (isOutside(less) && keep(std::move(less))) return;
    }
  }

  void dropObjects() {
    for (const std::uint64_t id : ids()) {
      EditRun less = run_;
      for (FuzzScene& scene : less.scenes)
        std::erase_if(scene.objects, [id](const FuzzObject& o) { return o.id == id; });
      keep(std::move(less));
    }
  }

  void dropFeatures() {
    EditRun less = run_;
    less.stabiliser = false;
    keep(less);
    less.device.clear();
    keep(std::move(less));
    constexpr std::array<void (*)(FuzzObject&), 6> kOff{
        [](FuzzObject& o) { o.tissue.reset(); },         [](FuzzObject& o) { o.mass_kg = 0; },
        [](FuzzObject& o) { o.textureAmplitude_m = 0; }, [](FuzzObject& o) { o.friction = 0; },
        [](FuzzObject& o) { o.crease_rad = 0; },         [](FuzzObject& o) { o.damping_Ns_per_m = 0; }};
    for (const auto off : kOff) {
      for (const std::uint64_t id : ids()) {
        EditRun plainer = run_;
        for (FuzzScene& scene : plainer.scenes) {
          for (FuzzObject& object : scene.objects) {
            if (object.id == id) off(object);
          }
        }
        keep(std::move(plainer));
      }
    }
  }

  [[nodiscard]] const EditRun& run() const { return run_; }

 private:
  bool keep(EditRun less) {
    constexpr double kAlike = 0.5;  // of the step: a much smaller one is another matter
    const auto finding = findFailure(less, finding_.failure);
    if (!finding || finding->verdict.excess_N < kAlike * finding_.verdict.excess_N) return false;
    run_ = std::move(less);
    return true;
  }

  [[nodiscard]] std::set<std::uint64_t> ids() const {
    std::set<std::uint64_t> all;
    for (const FuzzScene& scene : run_.scenes) {
      for (const FuzzObject& object : scene.objects) all.insert(object.id);
    }
    return all;
  }

  [[nodiscard]] EditRun fromTick(std::uint64_t first) const {
    EditRun less = run_;
    less.hips.erase(less.hips.begin(), less.hips.begin() + static_cast<std::ptrdiff_t>(first));
    while (less.scenes.size() > 1 && less.scenes[1].tick < first) less.scenes.erase(less.scenes.begin());
    for (FuzzScene& scene : less.scenes) scene.tick = scene.tick > first ? scene.tick - first : 0;
    for (EditWindow& window : less.windows) {
      window.begin -= first;
      window.settled -= first;
      window.end -= first;
    }
    return less;
  }

  [[nodiscard]] static bool isOutside(const EditRun& run) {
    std::vector<FuzzMesh> meshes;
    ContactFrame frame{run.hips.front(), {}};
    for (const FuzzObject& object : run.scenes.front().objects) {
      meshes.push_back(run.meshes[object.mesh].mesh);
      frame.poses.push_back(object.pose);
    }
    return ContactJudge::isOutside(meshes, frame);
  }

  EditRun run_;
  EditFinding finding_;
};

}  // namespace

EditRun reduced(EditRun run, const EditFinding& finding) {
  run.windows = {run.windows[finding.window]};
  run.hips.resize(run.windows.front().end);
  std::erase_if(run.scenes, [&](const FuzzScene& scene) { return scene.tick >= run.windows.front().end; });
  Reduction reduction(std::move(run), finding);
  reduction.dropScenes();
  reduction.dropObjects();
  reduction.goStraight();
  reduction.dropFirstTicks();
  reduction.dropFeatures();
  reduction.dropObjects();
  return reduction.run();
}

}  // namespace haptics::eval
