// Tools of many points: S23, S24, S25. Beside ours a point shell of springs and a point alone, where they are what the scene
// is about.

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "common/mesh/generators.h"
#include "haptic_server/engine/contact/contact.h"
#include "haptic_server/engine/contact/fast_path/contact_cache.h"
#include "haptic_server/engine/geometry/spaced_points.h"
#include "tests/eval/baselines/penalty_shell.h"
#include "tests/eval/scenes/scenes.h"

namespace haptics::eval {
namespace {

constexpr ToolCoupling kCoupling{.stiffness_N_per_m = 800, .torsion_Nm_per_rad = 1};

[[nodiscard]] Pose at(Vec3 position) { return {{1, 0, 0, 0}, position}; }
[[nodiscard]] Quat turnedBy(Vec3 axis, double angle_rad) { return glm::angleAxis(angle_rad, glm::normalize(axis)); }

[[nodiscard]] std::shared_ptr<const CollisionMesh> surfaceOf(const TriMesh& mesh) {
  return buildCollisionMesh(mesh.vertices, mesh.triangles);
}

/// A tool among bodies that stay where they are.
class ToolScene {
 public:
  ToolScene(const TriMesh& tool, double spacing_m) : spacing_m_(spacing_m) {
    tool_.surface = surfaceOf(tool);
    tool_.shell = makeToolShell(*tool_.surface, spacing_m).value();
  }

  void add(const TriMesh& mesh, const Pose& pose) {
    surfaces_.push_back(surfaceOf(mesh));
    sharp_.push_back(sharpPoints(*surfaces_.back(), spacing_m_, kMaxToolPoints));
    Body& body = bodies_.emplace_back();
    body.surface = surfaces_.back().get();
    body.previous = body.current = pose;
    body.update();
  }

  void begin(const Pose& device) {
    std::vector<ToolContact::Obstacle> obstacles;
    for (std::size_t b = 0; b < bodies_.size(); ++b) obstacles.push_back({bodies_[b].current, sharp_[b], -1});
    contact_->hold(tool_);
    contact_->adopt(obstacles);
    contact_->reset(device, bodies_);
  }

  const ToolResult& tick(const Pose& device) {
    result_ = contact_->follow(bodies_, device, kCoupling, kAllowance);
    if (spoilsTool != nullptr) spoilsTool(result_);
    const bool finite = isFinite(result_.force_N) && isFinite(result_.torque_Nm) && isFinite(result_.proxy.position);
    notFinite_ += finite ? 0 : 1;
    for (const Body& body : bodies_) {
      for (const Vec3& point : tool_.shell.points) {
        const Vec3 in = body.frame.toLocal(toWorld(result_.proxy, point));
        if (glm::distance(in, body.surface->centre()) > body.surface->radius_m()) continue;
        int looked = 0;
        const ClosestPoint foot = body.surface->closestFoot(in, 1 << 20, looked);
        if (!body.surface->isOutside(foot, in)) deepest_m_ = std::max(deepest_m_, std::sqrt(foot.squaredDistance));
      }
    }
    return result_;
  }

  [[nodiscard]] const Tool& tool() const { return tool_; }
  [[nodiscard]] std::span<const Body> bodies() const { return bodies_; }
  [[nodiscard]] double deepest_m() const { return deepest_m_; }
  [[nodiscard]] int notFinite() const { return notFinite_; }

 private:
  static constexpr Allowance kAllowance{250'000};  // of a tick at 1 kHz

  double spacing_m_;
  Tool tool_;
  std::vector<std::shared_ptr<const CollisionMesh>> surfaces_;
  std::vector<std::vector<Vec3>> sharp_;
  std::vector<Body> bodies_;
  std::unique_ptr<StandaloneTool> contact_ = std::make_unique<StandaloneTool>();
  ToolResult result_;
  double deepest_m_ = 0;  // of a point in a body, in any tick
  int notFinite_ = 0;
};

/// Rounding of a tool that touches.
constexpr double kRounding_m = 1e-9;

/// A block about the z axis with a hole through it, its top at z = 0.
[[nodiscard]] TriMesh blockWithHole(double hole_m, double outer_m, double height_m) {
  constexpr std::uint32_t kTurns = 96;
  TriMesh mesh;
  const std::array<std::array<double, 2>, 4> line{
      {{hole_m, 0}, {hole_m, -height_m}, {outer_m, -height_m}, {outer_m, 0}}};
  for (const auto& [radius, z] : line) {
    for (std::uint32_t i = 0; i < kTurns; ++i) {
      const double a = 2 * std::numbers::pi * i / kTurns;
      mesh.vertices.emplace_back(Vec3(radius * std::cos(a), radius * std::sin(a), z));
    }
  }
  for (std::uint32_t r = 0; r < 4; ++r) {
    for (std::uint32_t i = 0; i < kTurns; ++i) {
      const std::uint32_t j = (i + 1) % kTurns, next = (r + 1) % 4 * kTurns, own = r * kTurns;
      mesh.triangles.push_back({own + i, next + j, next + i});
      mesh.triangles.push_back({own + i, own + j, next + j});
    }
  }
  return mesh;
}

}  // namespace

/// A tool of a thousand points against a plate of 0.5 mm at 2 m/s and 20 rad/s.
SceneResult throwAgainstPlate(Renderer& /*ours*/, Random& random) {
  constexpr int kTicks = 60;
  constexpr double kSpeed_m_per_s = 2, kTurning_rad_per_s = 20, kHalf_m = 0.00025;
  ToolScene scene(makeSphere(0.02, 24).value(), 0.00175);
  scene.add(makeBox({0.3, 0.3, 2 * kHalf_m}, 6).value(), at({0, 0, 0}));
  const Vec3 axis = random.direction();
  const Vec3 side(random.between(-0.3, 0.3), random.between(-0.3, 0.3), -1);
  const Vec3 from = Vec3(0, 0, 0.03) - 0.01 * side;
  const auto device = [&](int tick) {
    return Pose{turnedBy(axis, kTurning_rad_per_s * 1e-3 * tick), from + kSpeed_m_per_s * 1e-3 * tick * side};
  };
  scene.begin(device(0));
  PenaltyShell springs(scene.tool(), kCoupling);
  springs.reset(device(0));
  double lowest_m = 1, springsLowest_m = 1;
  const auto lowestOf = [&](const Pose& pose) {
    double lowest = 1;
    for (const Vec3& point : scene.tool().shell.points) lowest = std::min(lowest, toWorld(pose, point).z);
    return lowest;
  };
  for (int i = 1; i <= kTicks; ++i) {
    lowest_m = std::min(lowest_m, lowestOf(scene.tick(device(i)).proxy));
    springsLowest_m = std::min(springsLowest_m, lowestOf(springs.follow(scene.bodies(), device(i))));
  }
  SceneResult result;
  result.measures = {{"points", scene.tool().shell.points.size()},
                     {"lowest_above_plate_mm", 1e3 * (lowest_m - kHalf_m)},
                     {"penalty_shell_above_plate_mm", 1e3 * (springsLowest_m - kHalf_m)},
                     {"non_finite_ticks", scene.notFinite()}};
  // The springs are to fall through: else the scene shows nothing.
  result.pass = lowest_m > kHalf_m - kRounding_m && scene.notFinite() == 0 && springsLowest_m < -kHalf_m;
  return result;
}

/// A peg of 10 mm into a hole that is 0.2 mm wider on each side, turned, pushed aside, and pulled out.
SceneResult putPegIntoHole(Renderer& /*ours*/, Random& random) {
  constexpr double kRadius_m = 0.005, kClearance_m = 0.0002, kLength_m = 0.03, kHeight_m = 0.02;
  ToolScene scene(makeCylinder(kRadius_m, kLength_m, 48).value(), 0.0015);
  scene.add(blockWithHole(kRadius_m + kClearance_m, 0.025, kHeight_m), at({0, 0, 0}));
  const Vec3 aside(random.between(-1e-4, 1e-4), random.between(-1e-4, 1e-4), 0);
  const Quat tilted = turnedBy(Vec3(random.between(-1, 1), random.between(-1, 1), 0), random.between(0.001, 0.004));
  const Vec3 direction = turnedBy(Vec3(0, 0, 1), random.between(0, 6)) * Vec3(1, 0, 0);
  const double half = kLength_m / 2;
  Pose device{tilted, aside + Vec3(0, 0, half + 0.003)};
  scene.begin(device);
  const auto run = [&](int ticks, auto&& move) {
    ToolResult last;
    for (int i = 0; i < ticks; ++i) {
      move(1.0 / ticks);
      last = scene.tick(device);
    }
    return last;
  };
  const ToolResult in = run(600, [&](double part) { device.position.z -= 0.018 * part; });
  const double depth_m = half - in.proxy.position.z;
  const ToolResult turned = run(400, [&](double part) {
    device.rotation = glm::normalize(turnedBy(tilted * Vec3(0, 0, 1), 1.5 * part) * device.rotation);
  });
  const double lag_rad = 2 * std::acos(std::min(1.0, std::abs(glm::dot(turned.proxy.rotation, device.rotation))));
  const ToolResult pushed = run(300, [&](double part) { device.position += 0.002 * part * direction; });
  const double sideways_m = glm::length(Vec3(pushed.proxy.position.x, pushed.proxy.position.y, 0));
  static_cast<void>(run(300, [&](double part) { device.position -= 0.002 * part * direction; }));
  const ToolResult out = run(600, [&](double part) { device.position.z += 0.02 * part; });
  SceneResult result;
  result.measures = {{"deepest_in_block_mm", 1e3 * scene.deepest_m()},
                     {"pushed_in_mm", 1e3 * depth_m},
                     {"lag_of_turning_rad", lag_rad},
                     {"pushed_aside_mm", 1e3 * sideways_m},
                     {"pushed_aside_N", glm::length(pushed.force_N)},
                     {"left_when_out_N", glm::length(out.force_N)},
                     {"non_finite_ticks", scene.notFinite()}};
  result.pass = scene.deepest_m() < kRounding_m && depth_m > 0.0145 && lag_rad < 0.02 &&
                sideways_m < 2 * kClearance_m && glm::length(pushed.force_N) > 0.8 && glm::length(out.force_N) < 1e-6 &&
                scene.notFinite() == 0;
  return result;
}

/// A bar lies on a comb whose teeth are thinner than its points are apart, and is drawn along it. A point alone sinks in.
SceneResult dragAlongComb(Renderer& /*ours*/, Random& random) {
  constexpr double kTooth_m = 0.0004, kPitch_m = 0.0016, kSpacing_m = 0.003, kHalf_m = 0.003;
  constexpr int kTeeth = 40, kTicks = 1'000;
  ToolScene scene(makeBox({0.02, 0.012, 2 * kHalf_m}, 1).value(), kSpacing_m);
  for (int i = 0; i < kTeeth; ++i) {
    const double x = kPitch_m * (i - kTeeth / 2.0);
    scene.add(makeBox({kTooth_m, 0.03, 0.01}, 1).value(), at({x, 0, -0.005}));
  }
  const double depth_m = random.between(0.001, 0.004), y = random.between(-0.005, 0.005);
  const Quat turned = turnedBy(Vec3(0, 0, 1), random.between(-0.5, 0.5));
  const auto device = [&](int tick) {
    const double down = std::min(1.0, tick / 200.0), along = std::clamp((tick - 200) / 800.0, 0.0, 1.0);
    return Pose{turned, {-0.015 + 0.03 * along, y, kHalf_m + 0.001 - (depth_m + 0.001) * down}};
  };
  scene.begin(device(0));
  ContactState point;
  ContactCache cache;
  resetContact(point, device(0).position);
  double lowest_m = 1, pointLowest_m = 1, corner_m = 0;
  for (int i = 1; i <= kTicks; ++i) {
    const ToolResult& felt = scene.tick(device(i));
    const Vec3 tip = device(i).position - Vec3(0, 0, kHalf_m);
    pointLowest_m = std::min(pointLowest_m, followContact(scene.bodies(), point, tip, cache).ihip.z);
    if (i > 220) lowest_m = std::min(lowest_m, felt.proxy.position.z - kHalf_m);
    for (const Body& body : scene.bodies()) {  // a tooth's corners in the bar, which has no points there
      for (const double x : {-kTooth_m / 2, kTooth_m / 2}) {
        for (const double end : {-0.015, 0.015}) {
          const Vec3 in = toLocal(felt.proxy, toWorld(body.current, {x, end, 0.005}));
          const Vec3 within = Vec3(0.01, 0.006, kHalf_m) - glm::abs(in);
          corner_m = std::max(corner_m, std::min({within.x, within.y, within.z}));
        }
      }
    }
  }
  SceneResult result;
  result.measures = {{"bar_above_comb_mm", 1e3 * lowest_m},
                     {"point_above_comb_mm", 1e3 * pointLowest_m},
                     {"deepest_in_comb_mm", 1e3 * scene.deepest_m()},
                     {"corner_in_bar_mm", 1e3 * corner_m},
                     {"non_finite_ticks", scene.notFinite()}};
  result.pass = lowest_m > -kRounding_m && scene.deepest_m() < kRounding_m && corner_m < kRounding_m &&
                pointLowest_m < -0.0005 && scene.notFinite() == 0;
  return result;
}

}  // namespace haptics::eval
