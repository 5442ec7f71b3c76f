#include "tests/eval/advise/strokes.h"

#include <array>
#include <numbers>

#include "haptic_server/device/exploration_planner.h"

namespace haptics::eval {
namespace {

constexpr double kStrokeStep_m = 1e-4;
constexpr double kStrokeLift_m = 0.003;
const Vec3 kUp(0, 0, 1);

std::vector<Vec3> line(Vec3 from, Vec3 to) {
  std::vector<Vec3> places;
  const int steps = std::max(1, static_cast<int>(std::ceil(glm::distance(from, to) / kStrokeStep_m)));
  for (int i = 0; i < steps; ++i) places.push_back(glm::mix(from, to, static_cast<double>(i) / steps));
  return places;
}

HandStroke along(const std::vector<Vec3>& points, double depth_m) {
  const Vec3 deep = kUp * -depth_m;
  const Vec3 high = kUp * kStrokeLift_m;
  HandStroke hand{
      line(points.front() + high, points.front() + deep), {}, line(points.back() + deep, points.back() + high)};
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const std::vector<Vec3> piece = line(points[i] + deep, points[i + 1] + deep);
    hand.stroke.insert(hand.stroke.end(), piece.begin(), piece.end());
  }
  hand.stroke.push_back(points.back() + deep);
  hand.up.push_back(points.back() + high);
  return hand;
}

}  // namespace

std::vector<Vec3> HandStroke::places() const {
  std::vector<Vec3> all = down;
  all.insert(all.end(), stroke.begin(), stroke.end());
  all.insert(all.end(), up.begin(), up.end());
  return all;
}

std::vector<HandStroke> strokesOver(const LoadedObject& object) {
  constexpr std::array kTurns_rad{0.0, std::numbers::pi / 3, 2 * std::numbers::pi / 3};
  constexpr double kPress_N = 1;
  return strokesOver(object, kTurns_rad, kPress_N);
}

std::vector<HandStroke> strokesOver(const LoadedObject& object, std::span<const double> turns_rad, double press_N) {
  std::vector<HandStroke> strokes;
  for (const double turn_rad : turns_rad) {
    // The planner looks along its own axes: another direction is the same object turned about the vertical.
    const Quat turn = glm::angleAxis(turn_rad, kUp);
    const ExploredObject turned{1, object.surface, {turn * object.pose.rotation, turn * object.pose.position}};
    const ExplorationPlan plan = ExplorationPlanner().plan({&turned, 1});
    for (const Stroke& stroke : plan.strokes) {
      std::vector<Vec3> points;
      for (const Vec3 p : stroke.points) points.push_back(glm::conjugate(turn) * p);
      strokes.push_back(along(points, press_N / object.material.stiffness_N_per_m));
    }
  }
  return strokes;
}

}  // namespace haptics::eval
