#pragma once

#include <array>
#include <optional>

#include "common/maths/vec.h"
#include "haptic_server/engine/contact/contact.h"

namespace haptics {

/// A half space that the IHIP must not leave: normal . x >= offset. World frame, metres; the normal is unit.
struct ConstraintPlane {
  Vec3 normal;
  double offset;
  ContactSurface surface;

  /// The fraction of a path from above to below the plane at which it reaches the plane, 0 when it starts there.
  [[nodiscard]] double reachedAt(Vec3 from, Vec3 to) const noexcept {
    const double above = glm::dot(normal, from) - offset;
    const double below = glm::dot(normal, to) - offset;
    return above > 0 ? above / (above - below) : 0;
  }
};

/// The planes that the IHIP has met in a tick.
class PlaneSet {
 public:
  /// Planes met before the search gives up. With 8 there are 29 systems of at most 3 x 3 to try.
  static constexpr int kMaxPlanes = 8;

  struct Nearest {
    Vec3 point{0};
    int tightCount = 0;
    std::array<int, ContactState::kMaxHolding> tight;  ///< Planes that push, the strongest first.
  };

  [[nodiscard]] bool full() const noexcept { return count_ == kMaxPlanes; }
  void add(const ConstraintPlane& plane) noexcept { planes_[static_cast<std::size_t>(count_++)] = plane; }
  [[nodiscard]] const ConstraintPlane& operator[](int i) const noexcept { return planes_[static_cast<std::size_t>(i)]; }

  /// The point nearest to h above all planes, to within `slack` (m): a set of up to three planes with multipliers >= 0
  /// (Kuhn-Tucker; Zilles and Salisbury 1995 solve the same with Lagrange multipliers). Call it after an add() that
  /// cut off the previous answer: only sets that hold the newest plane are tried. Empty when there is no such point.
  [[nodiscard]] std::optional<Nearest> nearest(Vec3 h, double slack) const noexcept;

 private:
  [[nodiscard]] bool holds(Vec3 x, double slack) const noexcept;
  [[nodiscard]] bool solve(Vec3 h, Nearest& candidate) const noexcept;

  std::array<ConstraintPlane, kMaxPlanes> planes_;
  int count_ = 0;
};

}  // namespace haptics
