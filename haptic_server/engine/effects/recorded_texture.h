#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/maths/fields.h"
#include "common/maths/vec.h"
#include "common/scene/effect_properties.h"

namespace haptics {

/// Of the longest ladder that a recorded texture is felt by: 32 ms at 2 kHz. Larger follows finer peaks, and takes longer.
inline constexpr std::size_t kLadderOrder = 64;

/// What the recorded texture that is felt remembers from tick to tick; there is one, of the object that is touched.
struct TextureMemory {
  Vec3 velocity{0};                             ///< Of the hand along the surface, smoothed; object frame.
  std::array<double, kLadderOrder> backward{};  ///< The ladder's backward residuals.
  double last = 0, next = 0;                    ///< Its two latest outputs.
  std::uint64_t passed = 0;                     ///< Ticks since it gave `next`.
  std::uint64_t drawn = 0;                      ///< Numbers of its noise so far, of which the next one follows.

  /// All but `drawn`.
  void restart() noexcept {
    const std::uint64_t number = drawn;
    *this = {};
    drawn = number;
  }

  HAPTICS_FIELDS(self.velocity, self.backward, self.last, self.next, self.passed, self.drawn);
};

/// A texture as the autoregressive models that were made of recordings of it, over the speed of the hand and its normal force
/// (README.md; Culbertson, Unwin & Kuchenbecker 2014). noexcept, no allocation once it is made.
class RecordedTexture {
 public:
  using Reflection = std::array<double, kLadderOrder>;
  /// At the rate of the ladder.
  struct Model {
    double deviation = 0;     ///< Of what is felt, as a part of Effect::amplitude_N.
    Reflection reflection{};  ///< Each within -1 and 1, both excluded.
  };

  RecordedTexture() = default;
  RecordedTexture(const Effect& effect, double period_s);

  struct Felt {
    Vec3 force_N{0};
    double byTime_N = 0;  ///< By how much it changed because of the time alone.
  };
  /// All in the object's frame.
  /// @param normal  Unit, outward, where it is touched.
  /// @param normal_N  Force of the surface along it.
  /// @param velocity  Of the HIP relative to the frame, m/s.
  [[nodiscard]] Felt felt(TextureMemory& memory, const Vec3& normal, double normal_N,
                          const Vec3& velocity) const noexcept;

  /// Between the four models about it; no deviation at rest, nor without force.
  [[nodiscard]] Model at(double speed_m_per_s, double normal_N) const noexcept;
  /// The next output, of variance 1 as long as the model stays the same.
  /// @param reflection  kLadderOrder coefficients at most.
  [[nodiscard]] static double step(TextureMemory& memory, std::span<const double> reflection) noexcept;

 private:
  std::vector<double> speeds_m_per_s_, forces_N_;
  std::vector<Model> models_;  // of each speed those of all forces
  double amplitude_N_ = 0;
  double smoothing_ = 1;     // by which the velocity follows in a tick
  std::uint64_t every_ = 1;  // ticks in which the ladder goes on by one step
  std::size_t rungs_ = 0;    // of its coefficients those that are not 0
};

}  // namespace haptics
