#include "haptic_server/simplification/simplify.h"

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <future>
#include <sstream>
#include <utility>
#include <vector>

#include "common/interruption/interruption.h"
#include "common/interruption/work_meter.h"
#include "common/maths/perception.h"
#include "common/mesh/decimation.h"
#include "common/mesh/self_intersection_repair.h"
#include "haptic_server/simplification/fit.h"
#include "haptic_server/simplification/probe_strokes.h"

namespace haptics {
namespace {

constexpr double kPress_N = 1;
constexpr std::size_t kStrokes = 1000;
constexpr std::uint64_t kSeed = 1;
/// Vertices of the mesh from which a copy's distance is taken.
constexpr std::size_t kSamples = 60'000;
/// To each vertex of a copy, from which on it is fitted: fewer say too little of where it should be.
constexpr std::size_t kSamplesToFit = 2;
constexpr double kStep = 0.7071;  // two steps are a half
constexpr std::size_t kFewest = 4;
/// For strokes that are not tried.
constexpr double kReserve = 0.75;
/// Times what a press of 1 N tells, as far as a copy may be off anywhere. Larger loses small parts, which few strokes meet.
constexpr double kFarthest = 2;
/// A copy that is farther off than so many times what it may be is not fitted: fitting halves the distance at best.
constexpr double kHopeless = 3;

/// In a thread of its own, which ends when the calling one's work is to end, and counts for its meter.
auto beside(std::invocable auto work) {
  return std::async(std::launch::async, [stop = Interruptible::token(), meter = WorkMeter::current(), work] {
    const Interruptible here(stop);
    const WorkMeter::Counting counting(meter);
    return work();
  });
}

class Judge {
 public:
  Judge(const TriMesh& mesh, const CollisionMesh& surface, double error_jnd, double stiffness_N_per_m)
      : mesh_(mesh),
        surface_(surface),
        error_jnd_(error_jnd),
        stiffness_N_per_m_(stiffness_N_per_m),
        farthest_m_(kFarthest * error_jnd * kForceThreshold_ratio * kPress_N / stiffness_N_per_m),
        probes_(probeStrokes(mesh, surface, stiffness_N_per_m, kStrokes, kSeed)),
        samples_(everyNth(mesh.vertices, kSamples)) {}

  /// A copy fitted to the mesh; none where it is too far off, as far as samples tell.
  [[nodiscard]] std::optional<SimplifiedMesh> judge(TriMesh copy) const {
    auto surface = surfaceOf(copy);
    if (copy.vertices.size() * kSamplesToFit <= samples_.size()) {
      if (deviationOf(samples_, *surface) > kHopeless * farthest_m_) return std::nullopt;
      copy = fitted(std::move(copy), samples_);
      surface = surfaceOf(copy);
    }
    if (deviationOf(samples_, *surface) > farthest_m_) return std::nullopt;
    const auto error_jnd = errorOf(*surface);
    if (!error_jnd) return std::nullopt;
    return SimplifiedMesh{std::move(copy), std::move(surface), *error_jnd};
  }

  /// What was judged as it may be used; none where it may not.
  [[nodiscard]] std::optional<SimplifiedMesh> finish(SimplifiedMesh copy) const {
    auto isNear =
        beside([this, surface = copy.surface] { return deviationOf(mesh_.vertices, *surface) <= farthest_m_; });
    if (copy.surface->anySelfIntersecting() &&
        repairSelfIntersections(copy.mesh, surface_.closed(), farthest_m_).trianglesCut > 0) {
      copy.surface = surfaceOf(copy.mesh);
      const auto error_jnd = errorOf(*copy.surface);
      if (!error_jnd) return std::nullopt;
      copy.error_jnd = *error_jnd;
    }
    if (!isNear.get()) return std::nullopt;
    return copy;
  }

 private:
  const TriMesh& mesh_;
  const CollisionMesh& surface_;
  const double error_jnd_;
  const double stiffness_N_per_m_;
  const double farthest_m_;
  const Probes probes_;
  const std::vector<Vec3f> samples_;

  /// None where it is too large, or where the copy has no inside though the mesh has.
  [[nodiscard]] std::optional<double> errorOf(const CollisionMesh& copy) const {
    if (surface_.closed() && !copy.closed()) return std::nullopt;
    const std::vector<Forces> forces = forcesAlong(probes_.strokes, copy, stiffness_N_per_m_);
    const double error_jnd = differenceOf(forces, probes_.forces).epsilon_p99;
    if (!(error_jnd < kReserve * error_jnd_)) return std::nullopt;
    return error_jnd;
  }

  static std::shared_ptr<const CollisionMesh> surfaceOf(const TriMesh& mesh) {
    return buildCollisionMesh(mesh.vertices, mesh.triangles);
  }
};

}  // namespace

double placesOfStrokes(double longestSide_m, double stiffness_N_per_m) noexcept {
  return static_cast<double>(kStrokes) * placesOfAStroke(longestSide_m, stiffness_N_per_m);
}

Result<void> checkSimplifiable(const CollisionMesh& surface, double stiffness_N_per_m) {
  const Vec3 size = surface.high() - surface.low();
  const double places = placesOfStrokes(std::max({size.x, size.y, size.z}), stiffness_N_per_m);
  if (places <= kMaxPlaces) return {};
  std::ostringstream text;
  text << "takes strokes of " << places << " places, since 1 N presses " << kPress_N / stiffness_N_per_m
       << " m into the object; at most " << kMaxPlaces
       << " are tried: give a stiffer material or a larger mesh, or leave it out";
  return refused("simplify", text.str());
}

std::optional<SimplifiedMesh> simplify(const TriMesh& mesh, const CollisionMesh& surface, double error_jnd,
                                       double stiffness_N_per_m) {
  auto preparing = beside([&] { return Judge(mesh, surface, error_jnd, stiffness_N_per_m); });
  const Decimation decimation(mesh);
  const Judge judge = preparing.get();
  std::vector<std::size_t> counts;  // finest first
  for (double wanted = static_cast<double>(mesh.triangles.size()) * kStep;
       wanted >= static_cast<double>(std::max(kFewest, decimation.fewest())); wanted *= kStep) {
    counts.push_back(static_cast<std::size_t>(wanted));
  }
  // Flat parts alone, where that is all that there is to leave out.
  if (decimation.exact() < mesh.triangles.size()) counts.push_back(decimation.exact());
  std::ranges::sort(counts, std::greater());

  // The finer the better, all but for luck: two at a time, at thirds of what is left.
  const auto judged = [&](std::size_t at) { return judge.judge(decimation.copyOf(counts[at])); };
  std::optional<SimplifiedMesh> best;
  std::size_t good = 0, bad = counts.size();  // those before `good` pass; those from `bad` on do not
  while (good < bad) {
    const std::size_t finer = good + (bad - good) / 3, coarser = good + 2 * (bad - good) / 3;
    auto judging = beside([&] { return coarser > finer ? judged(coarser) : std::nullopt; });
    auto ofFiner = judged(finer);
    auto ofCoarser = judging.get();
    if (ofCoarser) {
      best = std::move(ofCoarser);
      good = coarser + 1;
    } else if (ofFiner) {
      best = std::move(ofFiner);
      good = finer + 1;
      bad = std::max(coarser, good);
    } else {
      bad = finer;
    }
  }
  if (best) best = judge.finish(*std::move(best));
  for (std::size_t at = good; !best && at-- > 1;) {
    best = judged(at - 1);
    if (best) best = judge.finish(*std::move(best));
  }
  if (best && best->mesh.triangles.size() >= mesh.triangles.size()) return std::nullopt;
  return best;
}

}  // namespace haptics
