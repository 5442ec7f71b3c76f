#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <utility>

#include "haptic_server/engine/contact/contact.h"
#include "haptic_server/engine/contact/plane_set.h"
#include "haptic_server/engine/contact/tolerances.h"

namespace haptics {

/// Result of one solver step.
struct SolverStep {
  bool done = false;            ///< False: the planes leave no place, or the path to it is blocked.
  bool reachedOptimum = false;  ///< Of the planes, with the support of their triangles.
  bool supportKnown = false;    ///< All surfaces that push are known to be under the IHIP.
  Vec3 to{0};                   ///< World.
  int pushingCount = 0;
  int touchedCount = 0;  ///< Surfaces that the IHIP touches besides.
  /// Those that push, the strongest first; then those that are touched.
  std::array<ContactSurface, ContactState::kMaxHolding + 1> surfaces;

  /// From one of those that push to its neighbour.
  void switchToNeighbour(std::size_t from, const ContactSurface& next) noexcept {
    surfaces[static_cast<std::size_t>(pushingCount)] = std::exchange(surfaces[from], next);
    touchedCount = 1;
  }
  [[nodiscard]] std::span<const ContactSurface> pushing() const noexcept {
    return std::span(surfaces).first(static_cast<std::size_t>(pushingCount));
  }
  [[nodiscard]] std::span<const ContactSurface> pushingOrTouched() const noexcept {
    return std::span(surfaces).first(static_cast<std::size_t>(pushingCount) + static_cast<std::size_t>(touchedCount));
  }
};

/// A triangle of each body that holds.
struct ActiveSet {
  std::array<ContactSurface, ContactState::kMaxHolding> at;
  std::size_t count = 0;

  [[nodiscard]] std::span<const ContactSurface> surfaces() const noexcept { return std::span(at).first(count); }
  [[nodiscard]] ActiveSet with(std::size_t i, std::uint32_t triangle) const noexcept {
    ActiveSet other = *this;
    other.at[i].triangle = triangle;
    return other;
  }
  friend bool operator==(const ActiveSet& a, const ActiveSet& b) noexcept {
    return std::ranges::equal(a.surfaces(), b.surfaces(), {}, &ContactSurface::triangle, &ContactSurface::triangle);
  }
};

/// Support limit of a straight move.
struct SupportLimit {
  bool ends = false;          ///< A supporting triangle ends before the move does.
  bool insideSupport = true;  ///< The optimum is well within all supporting triangles.
  double time = 1;            ///< Fraction of the move at which the first one has clearly ended.
  std::size_t surface = 0;    ///< Its index,
  int edge = 0;               ///< and that of the edge.
};

/// The planes met so far, and the point nearest to the HIP above them.
struct Constraints {
  PlaneSet planes;
  PlaneSet::Nearest optimum;

  Constraints(Vec3 hip, double skin) noexcept
      : hip_(hip), skin_(skin), constraintTolerance_(kConstraintTolerance * skin) {
    optimum.point = hip;
  }
  /// False when there is no place above all planes.
  [[nodiscard]] bool add(const ConstraintPlane& plane) noexcept {
    if (planes.full()) return false;
    planes.add(plane);
    if (glm::dot(plane.normal, optimum.point) >= plane.offset) return true;
    const std::optional<PlaneSet::Nearest> nearest = planes.nearest(hip_, constraintTolerance_);
    if (nearest) optimum = *nearest;
    return nearest.has_value();
  }

  /// Does the plane that was added as number `plane`, from 0, push at the optimum?
  [[nodiscard]] bool pushes(std::size_t plane) const noexcept {
    const auto end = optimum.tight.begin() + optimum.tightCount;
    return std::find(optimum.tight.begin(), end, static_cast<int>(plane)) != end;
  }
  [[nodiscard]] bool isCutOffBy(const ConstraintPlane& plane) const noexcept {
    return glm::dot(plane.normal, optimum.point) < plane.offset - constraintTolerance_;
  }
  /// How far planes that are lifted by a skin have moved the optimum.
  [[nodiscard]] Vec3 lift() const noexcept {
    if (optimum.tightCount == 0) return Vec3(0);
    const Vec3 a = planes[optimum.tight[0]].normal;
    if (optimum.tightCount == 1) return a * skin_;
    const Vec3 b = planes[optimum.tight[1]].normal;
    if (optimum.tightCount == 2) return (a + b) * (skin_ / (1 + glm::dot(a, b)));
    const Vec3 c = planes[optimum.tight[2]].normal;
    return (glm::cross(a, b) + glm::cross(b, c) + glm::cross(c, a)) * (skin_ / glm::dot(a, glm::cross(b, c)));
  }

  [[nodiscard]] SolverStep stepToOptimum() const noexcept {
    SolverStep step{
        .done = true, .reachedOptimum = true, .to = optimum.point, .pushingCount = optimum.tightCount, .surfaces = {}};
    for (std::size_t i = 0; i < static_cast<std::size_t>(step.pushingCount); ++i) {
      step.surfaces[i] = planes[optimum.tight[i]].surface;
    }
    return step;
  }

 private:
  Vec3 hip_;                    // world
  double skin_;                 // m
  double constraintTolerance_;  // m
};

}  // namespace haptics
