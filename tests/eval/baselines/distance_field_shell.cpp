#include "tests/eval/baselines/distance_field_shell.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/maths/rotation.h"
#include "haptic_server/engine/contact/frame.h"

namespace haptics::eval {
namespace {

constexpr std::size_t kFreedom = 6;
using Wrench = std::array<double, kFreedom>;

/// A spring's force and stiffness, in the six coordinates of a small move and turn.
struct Balance {
  Wrench force{};
  std::array<Wrench, kFreedom> stiffness{};

  void add(const Wrench& along, double pull_N, double spring_N_per_m) noexcept {
    for (std::size_t i = 0; i < kFreedom; ++i) {
      force[i] += pull_N * along[i];
      for (std::size_t j = 0; j <= i; ++j) stiffness[i][j] += spring_N_per_m * along[i] * along[j];
    }
  }

  /// The move and turn at which the forces balance (Cholesky).
  [[nodiscard]] Wrench solve() noexcept {
    for (std::size_t i = 0; i < kFreedom; ++i) {
      for (std::size_t j = 0; j <= i; ++j) {
        double sum = stiffness[i][j];
        for (std::size_t k = 0; k < j; ++k) sum -= stiffness[i][k] * stiffness[j][k];
        stiffness[i][j] = i == j ? std::sqrt(sum) : sum / stiffness[j][j];
      }
    }
    Wrench x = force;
    for (std::size_t i = 0; i < kFreedom; ++i) {
      for (std::size_t k = 0; k < i; ++k) x[i] -= stiffness[i][k] * x[k];
      x[i] /= stiffness[i][i];
    }
    for (std::size_t i = kFreedom; i-- > 0;) {
      for (std::size_t k = i + 1; k < kFreedom; ++k) x[i] -= stiffness[k][i] * x[k];
      x[i] /= stiffness[i][i];
    }
    return x;
  }
};

/// Signed; nothing that is farther than `farthest` is looked for.
[[nodiscard]] double signedDistance(const CollisionMesh& surface, Vec3 at, double farthest) {
  ClosestPoint nearest;
  nearest.squaredDistance = farthest * farthest;
  Allowance endless;
  surface.hierarchy().visitNear(
      at, endless,
      [&](std::uint32_t begin, std::uint32_t end) noexcept {
        for (std::uint32_t t = begin; t < end; ++t) {
          const ClosestPoint foot = closestOn(surface.triangle(t), t, at);
          if (foot.squaredDistance < nearest.squaredDistance) nearest = foot;
        }
        return nearest.squaredDistance;
      },
      nearest.squaredDistance);
  const double distance = std::sqrt(nearest.squaredDistance);
  return surface.isOutside(nearest, at) ? distance : -distance;
}

}  // namespace

DistanceField::DistanceField(const CollisionMesh& surface, int cells, double margin_m)
    : low_(Vec3(surface.low()) - margin_m) {
  const Vec3 size = Vec3(surface.high()) + margin_m - low_;
  cell_ = std::max({size.x, size.y, size.z}) / cells;
  const auto corners = [&](double length) { return static_cast<std::size_t>(std::ceil(length / cell_)) + 1; };
  nx_ = corners(size.x);
  ny_ = corners(size.y);
  nz_ = corners(size.z);
  high_ = low_ + cell_ * Vec3(static_cast<double>(nx_ - 1), static_cast<double>(ny_ - 1), static_cast<double>(nz_ - 1));
  value_.resize(nx_ * ny_ * nz_);
  for (std::size_t z = 0, i = 0; z < nz_; ++z) {
    for (std::size_t y = 0; y < ny_; ++y) {
      double last_m = 2 * glm::length(size);
      for (std::size_t x = 0; x < nx_; ++x, ++i) {
        const Vec3 at = low_ + cell_ * Vec3(static_cast<double>(x), static_cast<double>(y), static_cast<double>(z));
        last_m = signedDistance(surface, at, 1.001 * (std::abs(last_m) + cell_));  // no farther than from the last one
        value_[i] = static_cast<float>(last_m);
      }
    }
  }
}

std::optional<DistanceField::Sample> DistanceField::at(Vec3 place) const noexcept {
  if (glm::any(glm::lessThan(place, low_)) || !glm::all(glm::lessThan(place, high_))) return std::nullopt;
  const Vec3 in = (place - low_) / cell_;
  const auto x = static_cast<std::size_t>(in.x), y = static_cast<std::size_t>(in.y), z = static_cast<std::size_t>(in.z);
  const double u = in.x - static_cast<double>(x), v = in.y - static_cast<double>(y), w = in.z - static_cast<double>(z);
  const std::array rows{corner(x, y, z), corner(x, y + 1, z), corner(x, y, z + 1), corner(x, y + 1, z + 1)};
  std::array<double, 4> value, slope;  // along x
  for (std::size_t i = 0; i < rows.size(); ++i) {
    slope[i] = static_cast<double>(rows[i][1]) - static_cast<double>(rows[i][0]);
    value[i] = static_cast<double>(rows[i][0]) + u * slope[i];
  }
  const double low = value[0] + v * (value[1] - value[0]), high = value[2] + v * (value[3] - value[2]);
  const double alongX = (1 - w) * (slope[0] + v * (slope[1] - slope[0])) + w * (slope[2] + v * (slope[3] - slope[2]));
  const double alongY = (1 - w) * (value[1] - value[0]) + w * (value[3] - value[2]);
  return Sample{low + w * (high - low), Vec3(alongX, alongY, high - low) / cell_};
}

double DistanceField::distanceToGrid(Vec3 place) const noexcept {
  return glm::length(glm::max(glm::max(low_ - place, place - high_), Vec3(0)));
}

const Pose& DistanceFieldShell::follow(const Pose& device) noexcept {
  const Frame frame(pose_);
  const Vec3 move = device.position - pose_.position;
  const Vec3 turn = rotationVector(device.rotation * glm::conjugate(pose_.rotation));
  Balance balance;
  for (std::size_t i = 0; i < kFreedom; ++i) {
    const bool moves = i < 3;
    const auto axis = static_cast<glm::length_t>(i % 3);
    balance.stiffness[i][i] = moves ? coupling_.stiffness_N_per_m : coupling_.torsion_Nm_per_rad;
    balance.force[i] = balance.stiffness[i][i] * (moves ? move[axis] : turn[axis]);
  }
  touching_ = 0;
  for (std::size_t i = 0; i < shell_.points.size(); ++i) {
    if (travelled_ < clearTo_[i]) continue;
    const Vec3 place = frame.toWorld(shell_.points[i]);
    const auto sample = field_.at(place);
    if (!sample || sample->distance_m >= 0) {
      clearTo_[i] = travelled_ + (sample ? sample->distance_m : field_.distanceToGrid(place));
      continue;
    }
    ++touching_;
    const Vec3 n = glm::normalize(sample->gradient);
    const Vec3 lever = glm::cross(place - pose_.position, n);
    balance.add({n.x, n.y, n.z, lever.x, lever.y, lever.z}, -kPoint_N_per_m * sample->distance_m, kPoint_N_per_m);
  }
  const Wrench by = balance.solve();
  const Vec3 shift(by[0], by[1], by[2]), angle(by[3], by[4], by[5]);
  pose_ = {glm::normalize(rotationBy(angle) * pose_.rotation), pose_.position + shift};
  travelled_ += glm::length(shift) + glm::length(angle) * shell_.radius_m;
  return pose_;
}

}  // namespace haptics::eval
