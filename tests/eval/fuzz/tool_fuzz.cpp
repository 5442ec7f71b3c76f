#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "common/maths/rotation.h"
#include "haptic_server/world/stepped_scene.h"
#include "tests/eval/fuzz/contact_scene.h"
#include "tests/eval/fuzz/fuzz.h"
#include "tests/eval/fuzz/solid_oracle.h"
#include "tests/eval/fuzz/streamed_path.h"
#include "tests/eval/report.h"
#include "tests/eval/stage.h"
#include "tests/eval/table1/interruption.h"

namespace haptics::eval {
namespace {

constexpr int kLedTicks = 1500;  // of a tool
constexpr int kJudgedEach = 7;   // ticks
constexpr double kDeepestVertex_m = 1e-5;
constexpr double kApart_m = 1.2;  // of the tool, at the beginning: no body reaches so far
constexpr std::uint64_t kToolsToALine = 100;

struct VertexCounts {
  std::uint64_t ticks = 0, touching = 0, waiting = 0, judged = 0, inside = 0, notFinite = 0;
  std::uint64_t insideWaiting = 0;  ///< Among bodies that move, in ticks that say that they wait; no failure.
  double deepest_m = 0;             ///< But for those.

  [[nodiscard]] std::uint64_t wrong() const noexcept { return inside + notFinite; }
  VertexCounts& operator+=(const VertexCounts& o) noexcept {
    ticks += o.ticks, touching += o.touching, waiting += o.waiting, judged += o.judged, inside += o.inside;
    notFinite += o.notFinite, insideWaiting += o.insideWaiting;
    deepest_m = std::max(deepest_m, o.deepest_m);
    return *this;
  }
};

[[nodiscard]] Pose poseFrom(const World::Pose& pose) {
  const auto& [w, x, y, z] = pose.rotation;
  return {Quat(w, x, y, z), vec(pose.position_m)};
}

[[nodiscard]] World::Mesh viewOf(const FuzzMesh& mesh, std::vector<std::array<float, 3>>& vertices) {
  vertices.clear();
  for (const Vec3f& v : mesh.vertices) vertices.push_back({v.x, v.y, v.z});
  return {vertices, mesh.triangles};
}

/// A random closed tool in a hand that leads it to, along and into random bodies, and turns it to and fro.
class LedTool {
 public:
  LedTool(std::uint64_t seed, bool moving, double speed_m_per_s)
      : random_(seed), moving_(moving), speed_m_per_s_(speed_m_per_s), scene_(seed, {moving, speed_m_per_s}) {
    std::vector<std::array<float, 3>> vertices;
    for (std::size_t i = 0; i < scene_.meshes().size(); ++i) {
      const FuzzMesh& mesh = scene_.meshes()[i];
      bodies_.push_back(
          world_.add("body" + std::to_string(i), viewOf(mesh, vertices), {}, worldPose(scene_.frame().poses[i])));
      solids_.emplace_back(mesh.vertices, mesh.triangles);
    }
    constexpr std::array kClosed{MeshKind::kBox, MeshKind::kBlob, MeshKind::kSpiky, MeshKind::kFolded};
    constexpr double kSmallest = 0.3, kFinest_m = 0.0007, kRatio = 8;
    tool_ = makeMesh(kClosed[static_cast<std::size_t>(random_.below(static_cast<int>(kClosed.size())))], random_);
    const auto scale = static_cast<float>(random_.between(kSmallest, 1));
    for (Vec3f& v : tool_.vertices) v *= scale;
    World::Tool held;
    held.spacing_m = kFinest_m * std::pow(kRatio, random_.between(0, 1));
    held.torsion_Nm_per_rad = 0.1 * std::pow(10, random_.between(0, 1));
    for (;; held.spacing_m *= 2) {
      try {
        points_ = world_.hold(viewOf(tool_, vertices), held);
        break;
      } catch (const InvalidInput&) {  // more points than there may be
      }
    }
    spacing_m_ = held.spacing_m;
    device_ = {random_.rotation(), kApart_m * random_.direction()};
    turnTo_ = device_.rotation;
  }

  [[nodiscard]] VertexCounts run() {
    VertexCounts counts;
    Vec3 middle = device_.position;
    const int way = static_cast<int>(kApart_m / (speed_m_per_s_ * kPeriod_s));
    for (int tick = 0; tick < way + kLedTicks; ++tick) {
      const ContactFrame& now = scene_.next(middle);
      if (moving_) {
        for (std::size_t i = 0; i < bodies_.size(); ++i) world_.moveKinematic(bodies_[i], worldPose(now.poses[i]));
      }
      lead(now.hip, poseFrom(proxy_));
      const World::ToolSample sample = world_.stepTool(worldPose(device_));
      proxy_ = sample.proxy;
      middle = vec(sample.proxy.position_m);
      ++counts.ticks;
      counts.touching += sample.touching > 0 ? 1 : 0;
      counts.waiting += sample.waits ? 1 : 0;
      if (!isFinite(middle) || !isFinite(vec(sample.force_N)) || !isFinite(vec(sample.torque_Nm))) {
        ++counts.notFinite;
        break;
      }
      if (sample.touching > 0 && tick % kJudgedEach == 0) judge(now, poseFrom(sample.proxy), sample.waits, counts);
    }
    return counts;
  }
  [[nodiscard]] std::size_t points() const noexcept { return points_; }
  [[nodiscard]] std::size_t vertices() const noexcept { return tool_.vertices.size(); }
  [[nodiscard]] double spacing_m() const noexcept { return spacing_m_; }

 private:
  /// Towards where the scene's HIP is, no faster than it.
  void lead(Vec3 hip, const Pose& tool) {
    constexpr double kFarthest_rad = 0.7, kSlowest_rad_per_s = 0.1, kRatio = 100;
    const Vec3 way = hip - device_.position;
    const double most_m = speed_m_per_s_ * kPeriod_s, far_m = glm::length(way);
    device_.position += way * (far_m > most_m ? most_m / far_m : 1);
    if (ticksToTurn_-- <= 0) {
      turnTo_ = glm::normalize(rotationBy(random_.direction() * random_.between(0, kFarthest_rad)) * tool.rotation);
      spin_rad_per_s_ = kSlowest_rad_per_s * std::pow(kRatio, random_.between(0, 1));
      ticksToTurn_ = 20 + random_.below(200);
    }
    const Vec3 turn = rotationVector(turnTo_ * glm::conjugate(device_.rotation));
    const double most_rad = spin_rad_per_s_ * kPeriod_s, turn_rad = glm::length(turn);
    device_.rotation =
        glm::normalize(rotationBy(turn * (turn_rad > most_rad ? most_rad / turn_rad : 1)) * device_.rotation);
  }

  /// All vertices of the tool's mesh against all bodies that are closed.
  void judge(const ContactFrame& now, const Pose& tool, bool waits, VertexCounts& counts) const {
    const bool excused = moving_ && waits;  // the tool is not yet where the bodies are
    for (std::size_t b = 0; b < solids_.size(); ++b) {
      if (!scene_.meshes()[b].closed()) continue;
      for (const Vec3f& vertex : tool_.vertices) {
        ++counts.judged;
        const double depth_m = solids_[b].depth_m(toLocal(now.poses[b], toWorld(tool, Vec3(vertex))));
        if (!excused) counts.deepest_m = std::max(counts.deepest_m, depth_m);
        if (depth_m > kDeepestVertex_m) ++(excused ? counts.insideWaiting : counts.inside);
      }
    }
  }

  Random random_;
  bool moving_;
  double speed_m_per_s_;
  ContactScene scene_;
  World world_;
  std::vector<std::uint64_t> bodies_;
  std::vector<SolidOracle> solids_;
  FuzzMesh tool_;
  std::size_t points_ = 0;
  double spacing_m_ = 0;
  Pose device_;
  World::Pose proxy_;
  Quat turnTo_{1, 0, 0, 0};
  double spin_rad_per_s_ = 0;
  int ticksToTurn_ = 0;
};

}  // namespace

bool runFuzzTools(const FuzzOptions& options, const std::filesystem::path& out) {
  Interruption interruption;
  VertexCounts all;
  std::vector<Record> findings;
  std::uint64_t done = 0;
  for (; done < options.scenes && !interruption.came(); ++done) {
    const std::uint64_t seed = options.seed + done;
    const bool moving = options.moving.value_or(seed % 2 == 0);
    LedTool tool(seed, moving, options.speed_m_per_s.value_or(1));
    const VertexCounts counts = tool.run();
    all += counts;
    if (counts.wrong() > 0) {
      findings.push_back({{"fuzz", "tools"},
                          {"seed", seed},
                          {"moving", moving},
                          {"vertices", tool.vertices()},
                          {"points", tool.points()},
                          {"spacing_mm", tool.spacing_m() * 1e3},
                          {"inside", counts.inside},
                          {"deepest_mm", counts.deepest_m * 1e3},
                          {"not_finite", counts.notFinite},
                          {"pass", false}});
      showFinding(findings.back());
    }
    showProgress(done + 1, options.scenes, kToolsToALine, findings.size());
  }
  std::vector<Record> records{{{"fuzz", "tools"},
                               {"seed", options.seed},
                               {"scenes", done},
                               {"ticks", all.ticks},
                               {"contact_ticks", all.touching},
                               {"waiting_ticks", all.waiting},
                               {"judged_vertices", all.judged},
                               {"inside", all.inside},
                               {"inside_while_waiting", all.insideWaiting},
                               {"deepest_mm", all.deepest_m * 1e3},
                               {"pass", findings.empty()}}};
  std::printf("%s\n", measuresText(records.front()).c_str());
  records.insert(records.end(), findings.begin(), findings.end());
  writeRecords(out, "fuzz", records);
  if (interruption.came()) std::printf("interrupted: this is what was found by then\n");
  std::printf("%llu scenes, %zu failed\n", static_cast<unsigned long long>(done), findings.size());
  return findings.empty();
}

}  // namespace haptics::eval
