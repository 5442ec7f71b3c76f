#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <utility>

#include "haptic_server/contact/contact.h"
#include "haptic_server/contact/plane_set.h"
#include "haptic_server/contact/tolerances.h"

namespace haptics {

/// Where the solver came to.
struct SolverStep {
  bool done = false;   ///< The way was clear.
  bool whole = false;  ///< It led to the optimum, over what carries the IHIP there.
  bool rests = false;  ///< All that push there are known to be under the IHIP.
  Vec3 to{0};          ///< World.
  int count = 0;       ///< Surfaces that push there, the strongest first.
  int others = 0;      ///< Surfaces that the IHIP touches besides.
  std::array<ContactSurface, ContactState::kMaxHolding + 1> pushing;  ///< The others after those that push.

  /// From one of those that push to its neighbour.
  void switchToNeighbour(std::size_t from, const ContactSurface& next) noexcept {
    pushing[static_cast<std::size_t>(count)] = std::exchange(pushing[from], next);
    others = 1;
  }
  [[nodiscard]] std::span<const ContactSurface> allPushing() const noexcept {
    return std::span(pushing).first(static_cast<std::size_t>(count));
  }
  [[nodiscard]] std::span<const ContactSurface> touched() const noexcept {
    return std::span(pushing).first(static_cast<std::size_t>(count) + static_cast<std::size_t>(others));
  }
};

/// A triangle of each body that holds.
struct ActiveSet {
  std::array<ContactSurface, ContactState::kMaxHolding> at;
  std::size_t count = 0;

  [[nodiscard]] std::span<ContactSurface> surfaces() noexcept { return std::span(at).first(count); }
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

/// What carries the IHIP on a way.
struct SupportLimit {
  bool ends = false;        ///< A triangle does, before the way does.
  bool over = true;         ///< The optimum is well within all of them.
  double time = 1;          ///< Fraction of the way to clear of the first one that does.
  std::size_t surface = 0;  ///< Which one.
  int edge = 0;             ///< Over which of its edges.
};

/// The planes met so far, and where they let the IHIP come.
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
    return std::find(optimum.tight.begin(), optimum.tight.begin() + optimum.tightCount, static_cast<int>(plane)) !=
           optimum.tight.begin() + optimum.tightCount;
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

  /// To the optimum.
  [[nodiscard]] SolverStep move(bool over = false) const noexcept {
    SolverStep move{true, true, over, optimum.point, optimum.tightCount, 0, {}};
    for (std::size_t i = 0; i < static_cast<std::size_t>(move.count); ++i) {
      move.pushing[i] = planes[optimum.tight[i]].surface;
    }
    return move;
  }

 private:
  Vec3 hip_;                    // world
  double skin_;                 // m
  double constraintTolerance_;  // m
};

}  // namespace haptics
