#pragma once

#include <cstdint>

namespace haptics::eval {

/// Of the ticks of streamed worlds (runFuzzStream()).
struct StreamCount {
  std::uint64_t ticks = 0, touching = 0, inside = 0, crossed = 0, notFinite = 0, otherForce = 0;
  std::uint64_t rests = 0;          ///< Ticks in which it was looked whether the IHIP is in equilibrium,
  std::uint64_t late = 0;           ///< those in which it is not, by more than a force may differ,
  std::uint64_t notAtRest = 0;      ///< and those in which it was not in the tick before either.
  std::uint64_t insideWaiting = 0;  ///< In ticks that say that their allowance was spent; no failure.
  double deepest_m = 0;

  [[nodiscard]] std::uint64_t wrong() const noexcept { return inside + crossed + notFinite + otherForce + notAtRest; }
  StreamCount& operator+=(const StreamCount& o) noexcept;
};

inline constexpr int kStreamedTicks = 4000;  ///< Of a world,
inline constexpr int kRiseTicks = 600;       ///< after those in which the World's force comes.
inline constexpr double kStreamStiffness_N_per_m = 800;
/// By which a force may differ: a part of it, and so much.
inline constexpr double kForcePart = 0.05, kForceBeside_N = 0.05;

/// What a streamed world made of its ticks.
struct StreamRun {
  StreamCount counted;
  int period = 1;  ///< Ticks between samples.
};
/// A World of a body whose vertices World::moveVerticesKinematic() moves, by waves, a lattice or growth, in every tick or by
/// samples that come less often, up to `speed_m_per_s`; a hand near it rests or wanders. In some worlds the body's pose is driven,
/// too, or another body stands by. Judged in every tick, in double and by triangles alone, on the shape between the samples:
/// winding numbers, stiffness times the IHIP's distance, and whether small steps over the surface lead from there nearer to the HIP.
/// @param inScene  A SceneWorld instead, whose object goes by lattices of 2 to 8 points a side that set_deformation streams, 20 to
/// 200 a second.
[[nodiscard]] StreamRun runReshapedWorld(std::uint64_t seed, double speed_m_per_s, bool inScene);

}  // namespace haptics::eval
