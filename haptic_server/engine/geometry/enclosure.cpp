#include "haptic_server/engine/geometry/enclosure.h"

#include <algorithm>
#include <array>

namespace haptics {
namespace {

/// Triangles that a line has passed already, where some are in several cells.
class Passed {
 public:
  explicit Passed(const CollisionMesh& surface) noexcept : canRepeat_(surface.hierarchy().hasCells()) {}

  /// False for one that was there before. Beyond kMax of them all are new.
  [[nodiscard]] bool add(std::uint32_t t) noexcept {
    if (!canRepeat_) return true;
    const auto end = known_.begin() + static_cast<std::ptrdiff_t>(count_);
    if (std::find(known_.begin(), end, t) != end) return false;
    if (count_ < kMax) known_[count_++] = t;
    return true;
  }

 private:
  static constexpr std::size_t kMax = 256;
  bool canRepeat_;
  std::size_t count_ = 0;
  std::array<std::uint32_t, kMax> known_;
};

/// Calls visit(crossing) for every triangle that the segment passes, in no order.
template <class Visit>
void visitCrossings(const CollisionMesh& surface, Vec3 from, Vec3 to, Allowance& allowance, Visit visit) noexcept {
  const Segment segment(from, to);
  Passed passed(surface);
  allowance.spend(Allowance::kQuery);
  surface.hierarchy().visitAlong(from, to, allowance, [&](std::uint32_t begin, std::uint32_t end) noexcept {
    allowance.spend(Allowance::kTriangle * (end - begin));
    for (std::uint32_t t = begin; t < end; ++t) {
      Crossing crossing{t};
      if (segment.enters(surface.triangle(t), true, crossing) && passed.add(t)) visit(crossing);
    }
    return 1.0;
  });
}

/// Outside of the box, beyond the face that is nearest to `at`.
[[nodiscard]] Vec3 outOfBox(const CollisionMesh& surface, Vec3 at) noexcept {
  // Slope of the ray along the other two axes: no direction in which meshes are built.
  constexpr double kAslant = 0.30901699437494742;
  constexpr double kMoreAslant = 0.38196601125010515;
  constexpr double kBeyond = 1.125;
  int axis = 0;
  double nearest = std::numeric_limits<double>::infinity();
  double way = 0;
  for (int d = 0; d < 3; ++d) {
    const double down = at[d] - surface.low()[d];
    const double up = surface.high()[d] - at[d];
    if (std::min(down, up) >= nearest) continue;
    nearest = std::min(down, up);
    axis = d;
    way = down < up ? -1 : 1;
  }
  const double length = kBeyond * nearest + 0x1p-10 * surface.extent_m();
  Vec3 to = at;
  to[axis] += way * length;
  to[nextCorner(axis)] += kAslant * length;
  to[previousCorner(axis)] += kMoreAslant * length;
  return to;
}

}  // namespace

int windingNumber(const CollisionMesh& surface, Vec3 at, Allowance& allowance) noexcept {
  if (glm::any(glm::lessThan(at, surface.low())) || glm::any(glm::greaterThan(at, surface.high()))) return 0;
  int winding = 0;
  visitCrossings(surface, at, outOfBox(surface, at), allowance,
                 [&](const Crossing& crossing) noexcept { winding -= crossing.side; });
  return winding;
}

double leavesAt(const CollisionMesh& surface, int winding, Vec3 from, Vec3 to, Allowance& allowance) noexcept {
  constexpr std::size_t kMaxCrossings = 64;  // beyond them the last one counts
  constexpr double kSame = 0x1p-40;          // of the way: two triangles met on the edge between them
  std::array<Crossing, kMaxCrossings> crossings;
  std::size_t count = 0;
  double last = 0;
  visitCrossings(surface, from, to, allowance, [&](const Crossing& crossing) noexcept {
    last = std::max(last, crossing.time);
    if (count < kMaxCrossings) {  // by time, those at the same one as they come
      const auto end = crossings.begin() + static_cast<std::ptrdiff_t>(count);
      const auto at = std::upper_bound(crossings.begin(), end, crossing.time,
                                       [](double time, const Crossing& other) { return time < other.time; });
      std::move_backward(at, end, end + 1);
      *at = crossing;
    }
    ++count;
  });
  if (count > kMaxCrossings) return last;
  for (std::size_t i = 0; i < count; ++i) {
    const bool again =
        i > 0 && crossings[i].side == crossings[i - 1].side && crossings[i].time - crossings[i - 1].time <= kSame;
    if (!again) winding += crossings[i].side;
    if (winding <= 0) return crossings[i].time;
  }
  return last;
}

}  // namespace haptics
