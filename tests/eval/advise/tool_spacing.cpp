#include "tests/eval/advise/tool_spacing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <memory>
#include <numbers>

#include "common/maths/perception.h"
#include "common/maths/rotation.h"
#include "haptic_server/device/device_rotation.h"
#include "haptic_server/engine/geometry/spaced_points.h"
#include "haptic_server/engine/tool/tool_contact.h"
#include "tests/eval/advise/strokes.h"
#include "tests/eval/random.h"
#include "tests/eval/timing.h"

namespace haptics::eval {
namespace {

/// Times the scene's own spacing.
constexpr std::array kCoarser{1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0};
/// How far the hand tilts the tool on a stroke, about x and y, and how often: as the exploring hand sways.
constexpr double kTilt_rad = 0.25;
constexpr double kTiltsAboutX = 1, kTiltsAboutY = 1.6;

/// Over a rim a spacing tells for a few ticks of some strokes: 99 % of the ticks of few strokes is chance. The advice takes so
/// many besides the usual ones, and as many others try it.
constexpr std::uint64_t kDrawn = 32;

/// Poses of the device on a stroke, one to each tick.
using ToolStroke = std::vector<Pose>;

struct FeltTool {
  std::vector<Forces> forces_N;
  std::vector<Forces> torques_N;  ///< On a lever of kUsualGyration_m.
  double hot_ns = 0;
};

/// The tool among the scene's objects, at one spacing.
class ToolInScene {
 public:
  ToolInScene(const LoadedObject& tool, ToolShell shell, double spacing_m, const std::vector<LoadedObject>& scene)
      : coupling_{tool.material.stiffness_N_per_m, tool.motion->tool->torsion_Nm_per_rad},
        tool_{tool.surface, std::move(shell)},
        bodies_(scene.size()) {
    std::vector<ToolContact::Obstacle> obstacles;
    sharp_.reserve(scene.size());
    for (std::size_t i = 0; i < scene.size(); ++i) {
      bodies_[i].surface = scene[i].surface.get();
      bodies_[i].previous = bodies_[i].current = scene[i].pose;
      bodies_[i].update();
      sharp_.push_back(sharpPoints(*scene[i].surface, spacing_m, kMaxToolPoints));
      obstacles.push_back({scene[i].pose, sharp_[i], -1});
    }
    contact_->hold(tool_);
    contact_->adopt(obstacles);
  }

  FeltTool feel(const std::vector<ToolStroke>& strokes) {
    FeltTool felt;
    Stopwatch watch;
    for (const ToolStroke& stroke : strokes) {
      Forces& forces_N = felt.forces_N.emplace_back();
      Forces& torques_N = felt.torques_N.emplace_back();
      contact_->reset(stroke.front(), bodies_);
      for (const Pose& device : stroke) {
        ToolResult result;
        watch.time([&] { result = contact_->follow(bodies_, device, coupling_); });
        forces_N.push_back(contact_->touching() > 0 ? result.force_N : Vec3(0));
        torques_N.push_back(result.torque_Nm / kUsualGyration_m);
      }
    }
    felt.hot_ns = watch.durations_ns().quantile(0.5);
    return felt;
  }

 private:
  ToolCoupling coupling_;
  Tool tool_;
  std::vector<Body> bodies_;
  std::vector<std::vector<Vec3>> sharp_;
  std::unique_ptr<StandaloneTool> contact_ = std::make_unique<StandaloneTool>();
};

/// How far the tool reaches below its origin, turned as the scene has it.
double reachDown_m(const LoadedObject& tool, const ToolShell& shell) {
  double down_m = 0;
  for (const Vec3& point : shell.points) down_m = std::max(down_m, -(tool.pose.rotation * point).z);
  return down_m;
}

/// @param strokesOf  Of a hand without a tool, over one object.
template <class StrokesOf>
std::vector<ToolStroke> toolStrokes(const LoadedObject& tool, double down_m, const std::vector<LoadedObject>& scene,
                                    StrokesOf strokesOf) {
  constexpr double kTurn = 2 * std::numbers::pi;
  std::vector<ToolStroke> strokes;
  for (LoadedObject object : scene) {
    object.material.stiffness_N_per_m = tool.material.stiffness_N_per_m;  // the tool's springs are pressed, not its own
    for (const HandStroke& hand : strokesOf(object)) {
      const std::vector<Vec3> places = hand.places();
      ToolStroke& stroke = strokes.emplace_back();
      for (std::size_t i = 0; i < places.size(); ++i) {
        const double part = kTurn * static_cast<double>(i) / static_cast<double>(places.size());
        const Vec3 tilt(std::sin(kTiltsAboutX * part), std::sin(kTiltsAboutY * part), 0);
        stroke.push_back({rotationBy(kTilt_rad * tilt) * tool.pose.rotation, places[i] + Vec3(0, 0, down_m)});
      }
    }
  }
  return strokes;
}

ToolShell shellOf(const LoadedObject& tool, double spacing_m) {
  return makeToolShell(*tool.surface, spacing_m).value();  // the scene's own spacing was taken: wider ones are smaller
}

/// In 99 % of the ticks. A torque counts as the force on its lever; a difference that is too small to be noticed by itself
/// is not noticed, whichever way a small torque points.
double torqueError_p99(const std::vector<Forces>& felt, const std::vector<Forces>& truth) {
  Statistics errors;
  for (std::size_t stroke = 0; stroke < felt.size(); ++stroke) {
    for (std::size_t i = 0; i < felt[stroke].size(); ++i) {
      const Vec3 is = felt[stroke][i], shouldBe = truth[stroke][i];
      if (is == Vec3(0) && shouldBe == Vec3(0)) continue;
      errors.add(std::min(forceError_jnd(is, shouldBe), glm::distance(is, shouldBe) / kMinForceThreshold_N));
    }
  }
  return errors.quantile(0.99);
}

SpacingCandidate judged(double spacing_m, std::size_t points, const FeltTool& felt, const FeltTool& truth) {
  return {.spacing_m = spacing_m,
          .points = points,
          .difference = differenceOf(felt.forces_N, truth.forces_N),
          .torque_p99 = torqueError_p99(felt.torques_N, truth.torques_N),
          .hot_ns = felt.hot_ns};
}

/// Strokes in directions and with presses that are drawn at random, by kDrawn seeds from one on.
std::vector<ToolStroke> drawnStrokes(const LoadedObject& tool, double down_m, const std::vector<LoadedObject>& scene,
                                     std::uint64_t seed) {
  std::vector<ToolStroke> strokes;
  for (std::uint64_t i = 0; i < kDrawn; ++i) {
    Random random(seed + i);
    const auto drawn = [&](const LoadedObject& object) {
      const std::array turns_rad{random.between(0, std::numbers::pi), random.between(0, std::numbers::pi)};
      return strokesOver(object, turns_rad, random.between(0.7, 1.3));
    };
    std::ranges::move(toolStrokes(tool, down_m, scene, drawn), std::back_inserter(strokes));
  }
  return strokes;
}

}  // namespace

ToolAdvice toolAdviceFor(const LoadedObject& tool, const std::vector<LoadedObject>& scene) {
  ToolAdvice advice{.name = tool.name, .candidates = {}};
  std::vector<ToolStroke> strokes;
  FeltTool truth;
  for (const double times : kCoarser) {
    const double spacing_m = times * tool.motion->tool->spacing_m;
    ToolShell shell = shellOf(tool, spacing_m);
    const std::size_t points = shell.points.size();
    if (!advice.candidates.empty() && points >= advice.candidates.back().points) break;
    if (advice.candidates.empty()) {
      const auto usual = [](const LoadedObject& object) { return strokesOver(object); };
      const double down_m = reachDown_m(tool, shell);
      strokes = toolStrokes(tool, down_m, scene, usual);
      if (strokes.empty()) return advice;
      std::ranges::move(drawnStrokes(tool, down_m, scene, 1), std::back_inserter(strokes));
    }
    FeltTool felt = ToolInScene(tool, std::move(shell), spacing_m, scene).feel(strokes);
    if (advice.candidates.empty()) truth = felt;
    advice.candidates.push_back(judged(spacing_m, points, felt, truth));
    const std::size_t count = advice.candidates.size();
    if (count > 2 && !advice.candidates[count - 1].good() && !advice.candidates[count - 2].good()) break;
  }
  const auto bad = std::ranges::find_if(advice.candidates, [](const SpacingCandidate& c) { return !c.good(); });
  advice.advised = static_cast<std::size_t>(std::max<std::ptrdiff_t>(1, bad - advice.candidates.begin())) - 1;
  return advice;
}

SpacingCandidate checkedSpacing(const LoadedObject& tool, double spacing_m, const std::vector<LoadedObject>& scene,
                                std::uint64_t seed) {
  const double own_m = tool.motion->tool->spacing_m;
  ToolShell own = shellOf(tool, own_m), written = shellOf(tool, spacing_m);
  const std::vector<ToolStroke> strokes = drawnStrokes(tool, reachDown_m(tool, own), scene, seed);
  const std::size_t points = written.points.size();
  const FeltTool truth = ToolInScene(tool, std::move(own), own_m, scene).feel(strokes);
  return judged(spacing_m, points, ToolInScene(tool, std::move(written), spacing_m, scene).feel(strokes), truth);
}

}  // namespace haptics::eval
