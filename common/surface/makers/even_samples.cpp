#include "common/surface/makers/even_samples.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <queue>
#include <string>
#include <unordered_map>
#include <utility>

#include "common/interruption/interruption.h"
#include "common/surface/lattice.h"

namespace haptics {
namespace {

constexpr std::size_t kCandidates = 5;          ///< For each sample that stays.
constexpr std::size_t kMaxNeighbors = 200;      ///< On average; some twenty of a single sheet.
constexpr std::size_t kAnyNeighbors = 200'000;  ///< In sum, before the average counts.

/// Normal of a triangle, as long as twice its area.
Vec3 areaVector(const TriMesh& mesh, const TriangleIndices& t) noexcept {
  const Vec3 a(mesh.vertices[t[0]]), b(mesh.vertices[t[1]]), c(mesh.vertices[t[2]]);
  return glm::cross(b - a, c - a);
}

/// One in each of as many equal parts of the area as there are to be.
std::vector<MeshSample> scattered(const TriMesh& mesh, std::size_t count, std::uint32_t seed) {
  Random random(seed);
  const double part_m2 = areaOf_m2(mesh) / static_cast<double>(count);
  std::vector<MeshSample> samples;
  double passed_m2 = 0, next_m2 = part_m2 * random.uniform();
  for (const TriangleIndices& t : mesh.triangles) {
    const Vec3 across = areaVector(mesh, t);
    passed_m2 += 0.5 * glm::length(across);
    while (next_m2 < passed_m2 && samples.size() < count) {
      const double root = std::sqrt(random.uniform()), along = random.uniform();
      const Vec3 point = (1 - root) * Vec3(mesh.vertices[t[0]]) + root * (1 - along) * Vec3(mesh.vertices[t[1]]) +
                         root * along * Vec3(mesh.vertices[t[2]]);
      samples.push_back({point, glm::normalize(across)});
      next_m2 = part_m2 * (static_cast<double>(samples.size()) + random.uniform());
    }
  }
  return samples;
}

/// Samples by cubes, whose side is the farthest at which they are neighbours.
class Cubes {
 public:
  Cubes(const std::vector<MeshSample>& samples, double side_m) : samples_(samples), side_m_(side_m) {
    for (std::uint32_t i = 0; i < samples.size(); ++i) cubes_[keyOf(placeOf(i))].push_back(i);
  }

  /// Calls visit(sample, distance_m) for the neighbours of a sample, in an order that is the same everywhere.
  template <class Visit>
  void visitNeighbors(std::uint32_t of, Visit visit) const {
    const Vec3 place = placeOf(of);
    for (int corner = 0; corner < 27; ++corner) {
      const auto cube = cubes_.find(keyOf(place + Vec3(corner % 3 - 1, corner / 3 % 3 - 1, corner / 9 - 1)));
      if (cube == cubes_.end()) continue;
      for (const std::uint32_t other : cube->second) {
        const double distance_m = glm::distance(samples_[of].point, samples_[other].point);
        if (distance_m >= side_m_ || other == of || !areOnOneSide(samples_[of], samples_[other])) continue;
        visit(other, distance_m);
      }
    }
  }

 private:
  const std::vector<MeshSample>& samples_;
  double side_m_;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cubes_;

  [[nodiscard]] Vec3 placeOf(std::uint32_t i) const { return glm::floor(samples_[i].point / side_m_); }
  /// Cubes that share a key are far from each other: their samples are no neighbours.
  [[nodiscard]] static std::uint64_t keyOf(Vec3 place) {
    const auto toInteger = [](double x) { return static_cast<std::uint64_t>(static_cast<std::int64_t>(x)) & 0x1fffff; };
    return toInteger(place.x) | toInteger(place.y) << 21 | toInteger(place.z) << 42;
  }
};

tl::unexpected<Error> tooManySheets() {
  return refused("", "the mesh has too many sheets above each other, within the distance between samples");
}

}  // namespace

double areaOf_m2(const TriMesh& mesh) noexcept {
  double area_m2 = 0;
  for (const TriangleIndices& t : mesh.triangles) area_m2 += 0.5 * glm::length(areaVector(mesh, t));
  return area_m2;
}

double evenSpacing_m(double area_m2, std::size_t count) noexcept {
  return std::sqrt(2 * area_m2 / (std::numbers::sqrt3 * static_cast<double>(count)));
}

Result<Neighborhoods> neighborhoodsOf(const std::vector<MeshSample>& samples, double radius_m) {
  const Cubes cubes(samples, radius_m);
  Neighborhoods result{{0}, {}};
  for (std::uint32_t i = 0; i < samples.size(); ++i) {
    interruptionPoint();
    cubes.visitNeighbors(i, [&](std::uint32_t other, double distance_m) {
      result.all.push_back({other, static_cast<float>(distance_m)});
    });
    result.first.push_back(result.all.size());
    if (result.all.size() > kAnyNeighbors + kMaxNeighbors * i) return tooManySheets();
  }
  return result;
}

Result<std::vector<MeshSample>> evenSamples(const TriMesh& mesh, std::size_t count, std::uint32_t seed) {
  const std::vector<MeshSample> all = scattered(mesh, kCandidates * count, seed);
  const double reach_m = evenSpacing_m(areaOf_m2(mesh), count);
  const auto near = neighborhoodsOf(all, reach_m);
  if (!near) return tl::unexpected<Error>(near.error());
  const auto weightAt = [reach_m](float distance_m) {
    const double w = 1 - static_cast<double>(distance_m) / reach_m;
    const double squared = w * w, fourth = squared * squared;
    return fourth * fourth;
  };

  std::vector<double> weights(all.size(), 0);
  std::priority_queue<std::pair<double, std::uint32_t>> heaviest;
  const auto visit = [&](std::uint32_t i, auto each) {
    for (std::size_t n = near->first[i]; n < near->first[i + 1]; ++n) each(near->all[n]);
  };
  for (std::uint32_t i = 0; i < all.size(); ++i) {
    interruptionPoint();
    visit(i, [&](const auto& neighbor) { weights[i] += weightAt(neighbor.distance_m); });
    heaviest.emplace(weights[i], i);
  }
  std::vector<bool> gone(all.size(), false);
  for (std::size_t left = all.size(); left > count;) {
    interruptionPoint();
    const auto [weight, sample] = heaviest.top();
    heaviest.pop();
    if (weight != weights[sample]) {  // less now: neighbours have gone since
      heaviest.emplace(weights[sample], sample);
      continue;
    }
    gone[sample] = true;
    --left;
    visit(sample, [&](const auto& neighbor) {
      weights[neighbor.sample] = std::max(0.0, weights[neighbor.sample] - weightAt(neighbor.distance_m));
    });
  }
  std::vector<MeshSample> kept;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (!gone[i]) kept.push_back(all[i]);
  }
  return kept;
}

}  // namespace haptics
