#include "graphics_client/viewer/patches.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace haptics {
namespace {

/// Which of the object's axes a normal is nearest to: 0 to 5.
std::size_t nearestAxis(Vec3 normal) {
  std::size_t axis = 0;
  for (const int k : {1, 2}) {
    if (std::abs(normal[k]) > std::abs(normal[static_cast<int>(axis)])) axis = static_cast<std::size_t>(k);
  }
  return 2 * axis + (normal[static_cast<int>(axis)] < 0 ? 1 : 0);
}

class Cutter {
 public:
  Cutter(std::span<const Vec3f> points, std::span<const TriangleIndices> triangles, std::size_t most)
      : points_(points), triangles_(triangles), most_(most), local_(points.size()) {}

  std::vector<Patch> run() {
    std::array<std::vector<std::uint32_t>, 6> sides;
    for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
      sides[triangles_.size() > most_ ? nearestAxis(across(t)) : 0].push_back(t);
    }
    for (std::vector<std::uint32_t>& side : sides) {
      if (!side.empty()) cut(side);
    }
    return std::move(patches_);
  }

 private:
  [[nodiscard]] Vec3 corner(std::uint32_t triangle, std::size_t k) const {
    return Vec3(points_[triangles_[triangle][k]]);
  }
  [[nodiscard]] Vec3 across(std::uint32_t t) const {
    return glm::cross(corner(t, 1) - corner(t, 0), corner(t, 2) - corner(t, 0));
  }

  /// In two at the middle of its longest extent, until the parts are small enough.
  void cut(std::span<std::uint32_t> members) {
    if (members.size() <= most_) return keep(members);
    const auto middle = [&](std::uint32_t t) { return corner(t, 0) + corner(t, 1) + corner(t, 2); };
    Vec3 low = middle(members.front()), high = low;
    for (const std::uint32_t t : members) {
      low = glm::min(low, middle(t));
      high = glm::max(high, middle(t));
    }
    const Vec3 extent = high - low;
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    const auto half = members.begin() + static_cast<std::ptrdiff_t>(members.size() / 2);
    std::ranges::nth_element(members, half, {}, [&](std::uint32_t t) { return middle(t)[axis]; });
    cut({members.begin(), half});
    cut({half, members.end()});
  }

  void keep(std::span<std::uint32_t> members) {
    std::ranges::sort(members);
    Patch& patch = patches_.emplace_back();
    Vec3 sum(0);
    for (const std::uint32_t t : members) {
      patch.points.insert(patch.points.end(), triangles_[t].begin(), triangles_[t].end());
      sum += across(t);
    }
    std::ranges::sort(patch.points);
    patch.points.erase(std::unique(patch.points.begin(), patch.points.end()), patch.points.end());
    for (std::uint32_t i = 0; i < patch.points.size(); ++i) local_[patch.points[i]] = i;
    if (const double length = glm::length(sum); length > 0) patch.axis = sum / length;
    patch.triangles.reserve(members.size());
    for (const std::uint32_t t : members) {
      const auto& [a, b, c] = triangles_[t];
      patch.triangles.push_back({local_[a], local_[b], local_[c]});
      const Vec3 normal = across(t);
      const double length = std::max(glm::length(normal), std::numeric_limits<double>::min());
      const double cosine = std::clamp(glm::dot(patch.axis, normal) / length, -1.0, 1.0);
      patch.spread_rad = std::max(patch.spread_rad, std::acos(cosine));
    }
    enclose(patch);
  }

  void enclose(Patch& patch) const {
    Vec3 low(points_[patch.points.front()]), high = low;
    for (const std::uint32_t p : patch.points) {
      low = glm::min(low, Vec3(points_[p]));
      high = glm::max(high, Vec3(points_[p]));
    }
    patch.centre = (low + high) / 2.0;
    for (const std::uint32_t p : patch.points) {
      patch.radius_m = std::max(patch.radius_m, glm::distance(patch.centre, Vec3(points_[p])));
    }
  }

  std::span<const Vec3f> points_;
  std::span<const TriangleIndices> triangles_;
  std::size_t most_;
  std::vector<std::uint32_t> local_;  // number of each of the surface's points in the patch that is being made
  std::vector<Patch> patches_;
};

}  // namespace

std::vector<Patch> cutIntoPatches(std::span<const Vec3f> points, std::span<const TriangleIndices> triangles,
                                  std::size_t most) {
  return Cutter(points, triangles, most).run();
}

bool facesAway(const Patch& patch, Vec3 eye) {
  /// Bumps rise a little over a patch's horizon (radians).
  constexpr double kMargin_rad = 0.1;
  const Vec3 towards = patch.centre - eye;
  const double distance = glm::length(towards);
  if (!(distance > patch.radius_m)) return false;
  const double angle = std::acos(std::clamp(glm::dot(patch.axis, towards) / distance, -1.0, 1.0));
  return angle + std::asin(patch.radius_m / distance) + patch.spread_rad + kMargin_rad < std::numbers::pi / 2;
}

}  // namespace haptics
