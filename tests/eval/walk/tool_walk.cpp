#include "tests/eval/walk/tool_walk.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "common/maths/rotation.h"
#include "common/mesh/generators.h"
#include "haptic_server/engine/geometry/spaced_points.h"
#include "haptic_server/engine/step/haptic_step.h"
#include "haptic_server/engine/step/tool_step.h"
#include "tests/eval/methods.h"
#include "tests/eval/report.h"
#include "tests/eval/stage.h"
#include "tests/eval/timing.h"
#include "tests/eval/walk/tool_walker.h"
#include "tests/eval/walk/walk_scenes.h"

namespace haptics::eval {
namespace {

// Of the device: what the maker gives for a sigma.7; and of the tool.
constexpr double kMaxForce_N = 20, kMaxTorque_Nm = 0.4;
constexpr ToolCoupling kCoupling{.stiffness_N_per_m = 800, .torsion_Nm_per_rad = 0.5};
/// Of what an edit may change the force by: a change of the torque that is less is no step.
constexpr double kStep_Nm = 30 * RotationConfig{}.radius_m * kPeriod_s;
/// Parts of the tick by which a step is judged, and how much of it they have to make too.
constexpr int kParts = 64;
constexpr double kSameStep = 0.75;
/// For so many ticks in a row a tool may be where it was, without coming to where it is to be.
constexpr std::int64_t kMaxStuck = 100;
/// More than there are: no two walks of two seeds share their random numbers.
constexpr std::uint64_t kMaxWalks = 64;

struct ToolShape {
  const char* name;
  TriMesh mesh;
  double spacing_m;  ///< Of about 1,000 points.
};

[[nodiscard]] std::array<ToolShape, 2> toolShapes() {
  TriMesh ellipsoid = makeSphere(1, 32).value();
  for (Vec3f& v : ellipsoid.vertices) v = Vec3f(Vec3(v) * Vec3(0.010, 0.010, 0.022));
  return {{{"ellipsoid", std::move(ellipsoid), 0.00121}, {"bar", makeBox({0.05, 0.014, 0.014}, 2).value(), 0.00145}}};
}

struct Counts {
  std::int64_t ticks = 0, touching = 0, waiting = 0;
  std::int64_t stuck = 0, longestStuck = 0;       ///< Ticks in a row in which it waits and does not move.
  std::int64_t judged = 0, inside = 0;            ///< Points of the tool.
  std::int64_t sharpJudged = 0, sharpInside = 0;  ///< Of bodies.
  std::int64_t notFinite = 0, overspent = 0, gained = 0;
  std::int64_t steps = 0, wrongSteps = 0;
  double largestPart = 0;     ///< Of the allowance that a tick spent.
  double largestStep_Nm = 0;  ///< Of the torque, in a tick.
  double largestGain_Nm = 0;  ///< What the springs' energy grew by, beyond the hand's motion, as their torque at most.

  [[nodiscard]] bool pass() const {
    return inside + sharpInside + notFinite + overspent + gained + wrongSteps == 0 && longestStuck <= kMaxStuck;
  }
};

class ToolWalk {
 public:
  ToolWalk(const WalkScene& scene, const ToolShape& shape, Random random)
      : scene_(scene), walker_(scene.soup, random), device_(walker_.device()) {
    auto surface = buildCollisionMesh(shape.mesh.vertices, shape.mesh.triangles);
    tool_ = std::make_shared<const Tool>(Tool{surface, makeToolShell(*surface, shape.spacing_m).value()});
    toolSoup_.add(shape.mesh.vertices, shape.mesh.triangles, {});
    toolSoup_.finish();
    std::uint64_t id = 0;
    for (std::size_t i = 0; i < scene.surfaces.size(); ++i) {
      ServoObject& body = servoScene_.objects.emplace_back(ServoObject{++id, scene.surfaces[i], scene.poses[i]});
      body.stiffness_N_per_m = kCoupling.stiffness_N_per_m;
      body.sharp =
          std::make_shared<const std::vector<Vec3>>(sharpPoints(*scene.surfaces[i], shape.spacing_m, kMaxToolPoints));
      for (const Vec3& point : *body.sharp) sharp_.push_back(toWorld(body.pose, point));
    }
    ServoObject& tool = servoScene_.objects.emplace_back(ServoObject{++id, surface, Pose{}});
    tool.stiffness_N_per_m = kCoupling.stiffness_N_per_m;
    tool.torsion_Nm_per_rad = kCoupling.torsion_Nm_per_rad;
    tool.tool = tool_;
    servoScene_.revision = 1;
    if (!adoptScene(servoScene_, *state_, 0)) throw std::logic_error("a fresh state adopts every scene");
    step();
  }

  void tick() {
    before_->copyInUse(state_->tool.memory, state_->toolScratch);
    const Pose deviceBefore = device_;
    const Vec3 torqueBefore = writtenTorque_Nm(*state_);
    const double stretchBefore = stretch();
    device_ = walker_.next(state_->tool.memory.proxy);
    const ForceResult result = step();
    const ToolResult& felt = state_->toolFelt;
    ++counts_.ticks;
    counts_.touching += felt.heldCount > 0 ? 1 : 0;
    counts_.waiting += felt.waits ? 1 : 0;
    counts_.stuck = felt.waits && felt.proxy == before_->proxy() ? counts_.stuck + 1 : 0;
    counts_.longestStuck = std::max(counts_.longestStuck, counts_.stuck);
    const Vec3 torque = writtenTorque_Nm(*state_);
    if (!isFinite(result.force.written) || !isFinite(torque) || !isFinite(felt.proxy.position) ||
        !isRotation(felt.proxy.rotation)) {
      ++counts_.notFinite;
    }
    spent(result);
    const double moved = distance(device_, deviceBefore);
    const double gained_Nm = std::sqrt(kCoupling.torsion_Nm_per_rad) * (stretch() - stretchBefore - moved);
    counts_.largestGain_Nm = std::max(counts_.largestGain_Nm, gained_Nm);
    counts_.gained += gained_Nm > kStep_Nm ? 1 : 0;
    judgeTorque(torqueBefore, moved, deviceBefore);
    if (counts_.ticks % kToolJudgedEvery == 0) judgeSides();
  }

  [[nodiscard]] Counts& counts() { return counts_; }
  [[nodiscard]] Statistics& tick_us() { return tick_us_; }
  [[nodiscard]] std::size_t points() const { return tool_->shell.points.size(); }

 private:
  /// In sqrt(J), as the two springs measure it: the square is twice their energy.
  [[nodiscard]] static double distance(const Pose& a, const Pose& b) {
    const Vec3 turn = rotationVector(a.rotation * glm::conjugate(b.rotation));
    return std::sqrt(kCoupling.stiffness_N_per_m * squaredLength(a.position - b.position) +
                     kCoupling.torsion_Nm_per_rad * squaredLength(turn));
  }
  [[nodiscard]] double stretch() const { return distance(state_->tool.memory.proxy, device_); }

  ForceResult step() {
    const StepInput input{tick_++, 0, {device_.position, DeviceState::kReady, {}, device_.rotation}};
    ForceResult result;
    const double begun_s = threadTime_s();
    computeForce(servoScene_, *state_, config_, input, result);
    static_cast<void>(finishStep(servoScene_, *state_, config_, input, result));
    tick_us_.add(1e6 * (threadTime_s() - begun_s));
    return result;
  }

  void spent(const ForceResult& result) {
    const auto whole = static_cast<double>(config_.allowance().left());
    const double part = 1 - static_cast<double>(result.contact.work.allowance.left()) / whole;
    counts_.largestPart = std::max(counts_.largestPart, part);
    // A query ends with the leaves of the node in which it passes it.
    constexpr std::int64_t kLast = Allowance::kQuery + Allowance::kNode +
                                   Allowance::kTriangle * BoundingHierarchy::kWidth * BoundingHierarchy::kLeafTriangles;
    counts_.overspent += part > 1 + kLast / whole ? 1 : 0;
  }

  /// On planes that hold it the proxy moves no farther than the device does, measured by the coupling's energy: the torque
  /// changes by no more than `own_Nm` / 2. Where a surface is curved it may be more, and where something lets go the proxy
  /// slides at once to where it is held next: then the hand in smaller parts of the tick feels as large a step.
  void judgeTorque(Vec3 before_Nm, double moved, const Pose& deviceBefore) {
    const double own_Nm = 2 * std::sqrt(kCoupling.torsion_Nm_per_rad) * moved;
    const double change_Nm = glm::distance(writtenTorque_Nm(*state_), before_Nm);
    counts_.largestStep_Nm = std::max(counts_.largestStep_Nm, change_Nm);
    if (change_Nm <= own_Nm + kStep_Nm) return;
    ++counts_.steps;
    const std::span<const Body> bodies(state_->bodies.data(), state_->objects.count);
    double finer_Nm = 0;
    for (int i = 1; i <= kParts; ++i) {
      const Pose device = interpolate(deviceBefore, device_, static_cast<double>(i) / kParts);
      const Vec3 felt_Nm = limitMagnitude(before_->follow(bodies, device, kCoupling).torque_Nm, kMaxTorque_Nm);
      finer_Nm = std::max(finer_Nm, glm::distance(felt_Nm, before_Nm));
    }
    counts_.wrongSteps += finer_Nm < kSameStep * change_Nm ? 1 : 0;
  }

  void judgeSides() {
    const Pose& proxy = state_->tool.memory.proxy;
    for (const Vec3& point : tool_->shell.points)
      counts_.inside += scene_.soup.isInside(toWorld(proxy, point), kInside_m) ? 1 : 0;
    counts_.judged += static_cast<std::int64_t>(points());
    for (const Vec3& point : sharp_) {
      if (glm::distance(point, proxy.position) > tool_->shell.radius_m) continue;
      ++counts_.sharpJudged;
      counts_.sharpInside += toolSoup_.isInside(toLocal(proxy, point), kInside_m) ? 1 : 0;
    }
  }

  const WalkScene& scene_;
  ToolWalker walker_;
  Pose device_;
  StepConfig config_{.period_s = kPeriod_s, .maxForce_N = kMaxForce_N, .rotation = {.maxTorque_Nm = kMaxTorque_Nm}};
  std::shared_ptr<const Tool> tool_;
  TriangleSoup toolSoup_;
  std::vector<Vec3> sharp_;  // of all bodies, world
  ServoScene servoScene_;
  std::unique_ptr<HapticState> state_ = std::make_unique<HapticState>(config_);
  std::unique_ptr<StandaloneTool> before_ = std::make_unique<StandaloneTool>();
  std::uint64_t tick_ = 0;
  Statistics tick_us_;  // of the thread
  Counts counts_;
};

Record recordOf(const std::string& scene, const ToolShape& shape, std::uint64_t seed, ToolWalk& walk) {
  const Counts& c = walk.counts();
  Statistics& us = walk.tick_us();
  return {{"method", kOurs},
          {"scene", scene},
          {"tool", shape.name},
          {"points", walk.points()},
          {"seed", seed},
          {"ticks", c.ticks},
          {"contact_ticks", c.touching},
          {"waiting_ticks", c.waiting},
          {"longest_stuck_ticks", c.longestStuck},
          {"judged_points", c.judged},
          {"inside_points", c.inside},
          {"judged_sharp_points", c.sharpJudged},
          {"inside_sharp_points", c.sharpInside},
          {"not_finite_ticks", c.notFinite},
          {"largest_part_of_allowance", c.largestPart},
          {"overspent_ticks", c.overspent},
          {"gained_ticks", c.gained},
          {"largest_gain_mNm", c.largestGain_Nm * 1e3},
          {"torque_steps", c.steps},
          {"wrong_torque_steps", c.wrongSteps},
          {"largest_torque_change_mNm", c.largestStep_Nm * 1e3},
          {"tick_p50_us", us.quantile(0.5)},
          {"tick_p99_us", us.quantile(0.99)},
          {"tick_max_us", us.max()},
          {"pass", c.pass()}};
}

void printHead() {
  std::printf("%-19s %-10s %8s %8s %7s %11s %6s %9s %6s %4s %6s %6s %6s %6s %6s %7s %6s %6s\n", "scene", "tool",
              "ticks", "contact", "waiting", "points", "inside", "sharp", "inside", "NaN", "spent", "over-", "gained",
              "torque", "wrong", "largest", "p50", "p99");
  std::printf("%-19s %-10s %8s %8s %7s %11s %6s %9s %6s %4s %6s %6s %6s %6s %6s %7s %6s %6s\n", "", "", "", "", "",
              "judged", "", "judged", "", "", "%", "spent", "", "steps", "ones", "mNm", "us", "us");
}

void printRow(const Record& r) {
  const auto n = [&](const char* key) { return static_cast<long long>(r[key].get<std::int64_t>()); };
  const auto x = [&](const char* key) { return r[key].get<double>(); };
  std::printf(
      "%-19s %-10s %8lld %8lld %7lld %11lld %6lld %9lld %6lld %4lld %6.1f %6lld %6lld %6lld %6lld %7.1f %6.1f %6.1f  "
      "%s\n",
      r["scene"].get<std::string>().c_str(), r["tool"].get<std::string>().c_str(), n("ticks"), n("contact_ticks"),
      n("waiting_ticks"), n("judged_points"), n("inside_points"), n("judged_sharp_points"), n("inside_sharp_points"),
      n("not_finite_ticks"), 100 * x("largest_part_of_allowance"), n("overspent_ticks"), n("gained_ticks"),
      n("torque_steps"), n("wrong_torque_steps"), x("largest_torque_change_mNm"), x("tick_p50_us"), x("tick_p99_us"),
      r["pass"].get<bool>() ? "pass" : "FAIL");
  std::fflush(stdout);
}

/// A part is a tool in a scene.
class ToolWalkSweep : public Sweep {
 public:
  ToolWalkSweep(const WalkOptions& options, std::filesystem::path out)
      : options_(options), out_(std::move(out)), sources_(chosenWalkScenes(options.models, options.scene)) {
    std::erase_if(sources_, &WalkSceneSource::winding);
    if (sources_.empty()) throw std::invalid_argument("--scene: no tool walks over " + options.scene);
    if (options.ticks < static_cast<std::int64_t>(size()))
      throw std::invalid_argument("--ticks: give at least " + std::to_string(size()) + ", one for each scene and tool");
  }

  [[nodiscard]] std::size_t size() const override { return sources_.size() * shapes_.size(); }

  [[nodiscard]] Record run(std::size_t part) override {
    const WalkSceneSource& source = sources_[part / shapes_.size()];
    const std::size_t shape = part % shapes_.size();
    Random random(options_.seed * kMaxWalks + source.number);
    const WalkScene scene = makeWalkScene(source, random, true);
    for (std::size_t i = 0; i < shape; ++i) static_cast<void>(random.below(kWalkSeeds));
    ToolWalk walk(scene, shapes_[shape], Random(static_cast<std::uint64_t>(random.below(kWalkSeeds))));
    const std::int64_t ticks = options_.ticks / static_cast<std::int64_t>(size());
    for (std::int64_t tick = 0; tick < ticks; ++tick) walk.tick();
    return recordOf(source.name, shapes_[shape], options_.seed, walk);
  }

  void print(std::size_t part, const Record& record) override {
    if (part == 0) printHead();
    printRow(record);
  }

  [[nodiscard]] bool finish(const std::vector<Record>& records) override {
    writeRecords(out_, "walk", records);
    return std::ranges::all_of(records, [](const Record& record) { return record.at("pass").get<bool>(); });
  }

 private:
  static constexpr int kWalkSeeds = 1 << 30;

  WalkOptions options_;
  std::filesystem::path out_;
  std::vector<WalkSceneSource> sources_;
  std::array<ToolShape, 2> shapes_ = toolShapes();
};

}  // namespace

std::unique_ptr<Sweep> makeToolWalkSweep(const WalkOptions& options, const std::filesystem::path& out) {
  return std::make_unique<ToolWalkSweep>(options, out);
}

}  // namespace haptics::eval
