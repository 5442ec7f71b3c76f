#include "common/mesh/hole_filling.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace haptics {
namespace {

/// How good a filling is; smaller is better.
struct Cost {
  double fold = -1;  // largest of -cos(angle between neighbours): -1 flat, 1 back to back
  double area = 0;   // twice, m^2

  [[nodiscard]] bool isBetterThan(const Cost& other) const {
    return fold != other.fold ? fold < other.fold : area < other.area;
  }
};
constexpr Cost kNoWay{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};

double fold(Vec3 a, Vec3 b) { return -glm::dot(a, b) / std::sqrt(squaredLength(a) * squaredLength(b)); }

/// Units of work that the folds of a triangle are. Most triangles need no look at them.
constexpr std::size_t kFolds = 12;

/// The best filling of every part of the rim from a corner to another, shorter parts first.
class Filling {
 public:
  Filling(const std::vector<Vec3f>& vertices, const Rim& rim)
      : vertices_(vertices), rim_(rim), count_(rim.corners.size()), parts_(count_ * count_) {}

  template <class IsTaken>
  [[nodiscard]] bool find(const IsTaken& isTaken, Work& work) {
    for (std::size_t i = 0; i + 1 < count_; ++i) part(i, i + 1).normal = rim_.beside[i];
    for (std::size_t length = 2; length < count_; ++length) {
      for (std::size_t i = 0; i + length < count_; ++i) {
        const std::size_t k = i + length;
        Part& best = part(i, k);
        best.cost = kNoWay;
        const bool last = length + 1 == count_;  // the line from k to i is the rim's own
        if (!last && isTaken(rim_.corners[i], rim_.corners[k])) continue;
        for (std::size_t j = i + 1; j < k; ++j) consider(i, j, k, last, best);
        if (!work.spend(length + kFolds * std::exchange(folded_, 0))) return false;
      }
    }
    return part(0, count_ - 1).cost.isBetterThan(kNoWay);
  }

  void collect(std::size_t i, std::size_t k, std::vector<TriangleIndices>& triangles) {
    if (k - i < 2) return;
    const std::size_t j = part(i, k).middle;
    triangles.push_back({rim_.corners[i], rim_.corners[j], rim_.corners[k]});
    collect(i, j, triangles);
    collect(j, k, triangles);
  }

 private:
  struct Part {
    Cost cost;
    Vec3 normal{0};  // of the triangle at its chord
    std::size_t middle = 0;
  };
  [[nodiscard]] Part& part(std::size_t i, std::size_t k) { return parts_[i * count_ + k]; }
  [[nodiscard]] Vec3 at(std::size_t i) const { return Vec3(vertices_[rim_.corners[i]]); }

  void consider(std::size_t i, std::size_t j, std::size_t k, bool last, Part& best) {
    const Part& a = part(i, j);
    const Part& b = part(j, k);
    const double sharper = std::max(a.cost.fold, b.cost.fold);
    if (sharper > best.cost.fold || std::isinf(sharper)) return;
    ++folded_;
    const Vec3 normal = glm::cross(at(j) - at(i), at(k) - at(i));
    const double area = glm::length(normal);
    if (!(area > 0)) return;
    Cost cost{sharper, a.cost.area + b.cost.area + area};
    cost.fold = std::max({cost.fold, fold(a.normal, normal), fold(b.normal, normal)});
    if (last) cost.fold = std::max(cost.fold, fold(rim_.beside[k], normal));
    if (cost.isBetterThan(best.cost)) best = {cost, normal, j};
  }

  const std::vector<Vec3f>& vertices_;
  const Rim& rim_;
  std::size_t count_;
  std::vector<Part> parts_;
  std::size_t folded_ = 0;
};

}  // namespace

std::optional<std::vector<TriangleIndices>> fillHole(const std::vector<Vec3f>& vertices, const Rim& rim,
                                                     const std::function<bool(std::uint32_t, std::uint32_t)>& isTaken,
                                                     Work& work) {
  const std::size_t count = rim.corners.size();
  if (count < 3 || count > kMaxCorners) return std::nullopt;
  Filling filling(vertices, rim);
  if (!filling.find(isTaken, work)) return std::nullopt;
  std::vector<TriangleIndices> triangles;
  filling.collect(0, count - 1, triangles);
  return triangles;
}

}  // namespace haptics
