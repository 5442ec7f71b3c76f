#pragma once

#include <cstdint>

#include "common/maths/vec.h"
#include "common/surface/fade.h"

// Random numbers at the points of a lattice, the same on every machine (the standard library's distributions are not).
namespace haptics {

/// Mixes every bit of the state into every bit of the result (Steele, Lea & Flood 2014, SplitMix64's finaliser).
[[nodiscard]] constexpr std::uint64_t mixed(std::uint64_t z) noexcept {
  z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9;
  z = (z ^ z >> 27) * 0x94d049bb133111eb;
  return z ^ z >> 31;
}

/// SplitMix64: a sequence of random numbers.
class Random {
 public:
  explicit constexpr Random(std::uint64_t seed) noexcept : state_(seed) {}

  [[nodiscard]] constexpr std::uint64_t bits() noexcept { return mixed(state_ += kStep); }
  /// Uniform in [0, 1).
  [[nodiscard]] constexpr double uniform() noexcept { return static_cast<double>(bits() >> 11) * 0x1p-53; }

 private:
  static constexpr std::uint64_t kStep = 0x9e3779b97f4a7c15;
  std::uint64_t state_;
};

/// A lattice of side 1 in coordinates that are turned against the object's, so that no face of an object lies in one of
/// its planes: there gradient noise is 0 at every lattice point, which shows as a grid.
class CellLattice {
 public:
  /// Where a point lies: the cell's lowest corner, hashed, and the place within the cell, [0, 1) each.
  struct Place {
    std::uint64_t key = 0;
    Vec3 within{0};
  };

  /// \param offset lattice coordinates of the object's origin.
  CellLattice(double side_m, std::uint64_t seed, Vec3 offset = Vec3(0)) noexcept;

  /// \param point object frame, less than 2^62 sides from the origin.
  [[nodiscard]] Place place(Vec3 point) const noexcept {
    const Vec3 coordinates = toLattice_ * point + offset_;
    const Vec3 corner = glm::floor(coordinates);
    return {seed_ + kAlong[0] * toInteger(corner.x) + kAlong[1] * toInteger(corner.y) + kAlong[2] * toInteger(corner.z),
            coordinates - corner};
  }
  /// A gradient by lattice coordinates as a gradient by the object's, 1/m.
  [[nodiscard]] Vec3 gradient(Vec3 inLattice) const noexcept { return inLattice * toLattice_; }

  /// Random bits of the corner that lies (x, y, z) steps from a place's.
  [[nodiscard]] static constexpr std::uint64_t bits(std::uint64_t key, std::uint64_t x, std::uint64_t y,
                                                    std::uint64_t z) noexcept {
    return mixed(key + kAlong[0] * x + kAlong[1] * y + kAlong[2] * z);
  }

 private:
  // Odd, of random bits: corners that share a key are 2^20 steps apart and more.
  static constexpr std::uint64_t kAlong[3] = {0x9e3779b97f4a7c15, 0xd1b54a32d192ed03, 0xaef17502108ef2d9};

  glm::dmat3 toLattice_;
  Vec3 offset_;
  std::uint64_t seed_;

  [[nodiscard]] static std::uint64_t toInteger(double x) noexcept {
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(x));
  }
};

}  // namespace haptics
