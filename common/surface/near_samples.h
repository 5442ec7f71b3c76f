#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/error/error.h"
#include "common/maths/vec.h"

namespace haptics {

/// A value at a point of a surface.
struct PointSample {
  Vec3f point{0};   ///< Object frame, m.
  float value = 0;  ///< Dimensionless.
  bool operator==(const PointSample&) const = default;
};
static_assert(sizeof(PointSample) == 4 * sizeof(float));

/// Which samples lie near a place: for each cube of a lattice, whose side is the reach, those that lie within reach of any
/// of it. The cubes are found by hashing, so that memory follows the samples and not the space that they are in.
/// Immutable; lookUp() takes bounded time and neither allocates nor locks.
class NearSamples {
 public:
  static constexpr std::size_t kMaxNear = 512;  ///< Of one cube: bounds the time that a field takes.
  static constexpr std::size_t kMaxCubes = std::size_t{1} << 19;
  static constexpr double kMaxCubesAlong = 1 << 20;  ///< So that a cube's number has 64 bits.

  /// Refused, naming "samples": more than kMaxNear of them in a cube's list, more cubes than kMaxCubes (samples that
  /// are no neighbours of each other), an extent of more than kMaxCubesAlong.
  [[nodiscard]] static Result<NearSamples> make(double reach_m, std::span<const PointSample> samples);

  /// Numbers of the samples that may be within reach of the point, ascending.
  [[nodiscard]] std::span<const std::uint32_t> lookUp(Vec3 point) const noexcept {
    const Vec3 at = (point - low_) * perReach_;
    const bool inside = at.x >= 0 && at.y >= 0 && at.z >= 0 && at.x < cubes_.x && at.y < cubes_.y && at.z < cubes_.z;
    if (!inside) return {};
    const std::size_t slot = slotOf(numberOf(
        {static_cast<std::uint64_t>(at.x), static_cast<std::uint64_t>(at.y), static_cast<std::uint64_t>(at.z)}));
    if (slot == kNoSlot) return {};
    return std::span(lists_).subspan(table_[slot].first, table_[slot].count);
  }

 private:
  struct Cube {
    std::uint64_t number = kNone;
    std::uint32_t first = 0, count = 0;
  };
  using Place = std::array<std::uint64_t, 3>;
  static constexpr std::uint64_t kNone = ~std::uint64_t{0};
  static constexpr std::size_t kNoSlot = ~std::size_t{0};
  static constexpr std::size_t kMaxSteps = 32;  ///< From where a cube should be in the table to where it is.

  Vec3 low_{0}, cubes_{0};
  double perReach_ = 0;
  std::vector<Cube> table_;  // its size is a power of two
  std::vector<std::uint32_t> lists_;

  NearSamples() = default;
  [[nodiscard]] static std::uint64_t numberOf(const Place& place) noexcept {
    return place[0] | place[1] << 21 | place[2] << 42;
  }
  [[nodiscard]] std::size_t slotOf(std::uint64_t number) const noexcept;
  [[nodiscard]] Place placeOf(Vec3f point) const noexcept;
  [[nodiscard]] std::vector<std::uint64_t> cubesNear(std::span<const PointSample> samples) const;
  [[nodiscard]] bool enter(std::span<const std::uint64_t> numbers);
  template <class Visit>
  void visitCubes(Vec3f point, Visit visit);
};

}  // namespace haptics
