#pragma once

#include <type_traits>

#include "common/maths/vec.h"
#include "common/telemetry/telemetry_sample.h"

namespace haptics {

/// At a place of the surface; 0 <= slide <= stick.
struct FrictionCoefficients {
  double stick = 0;
  double slide = 0;

  HAPTICS_FIELDS(self.stick, self.slide);
};

/// Where and how hard a surface is pressed, object frame.
struct PressedPoint {
  Vec3 place{0};          ///< IHIP, m.
  Vec3 normal{0};         ///< N_s, unit.
  double pressing_N = 0;  ///< The felt force along N_s, not negative.
};

/// What friction needs to know beside that; the same for all of an object.
struct FrictionScale {
  /// c: k_s = c mu_s and k_d = c mu_d (paper 4.2: "proportional to"), N/m. Both laws then reach their limits, mu N, at
  /// the same stretch N / c.
  double stiffness_N_per_m = 0;
  /// Metres that the IHIP must come back for sliding to end: more than tremor and encoder move it.
  double hysteresis_m = 0;
};

/// Stick and slide (paper 4.2) on one object. A value: kept, copied and replayed.
///
/// Deviations from the paper:
///  - Sliding ends not when the force falls below the dynamic friction force, which a tremor of one encoder step does
///    hundreds of times in a second, each with a jump of the force, but when the IHIP has come back by the hysteresis, or
///    has pulled the sticking point nowhere for a while.
///  - Then the sticking point is moved so that k_s gives the force that k_d gave. Left where it is, the force would
///    jump up, and (k_s - k_d) x^2 / 2 of energy come from nowhere.
///  - While it sticks, the coefficients are those of where it began to: were they the IHIP's, a map of them would give the
///    spring's field a curl, and a loop that sticks all the way would give energy. While it slides they are the IHIP's.
class StickSlip {
 public:
  /// Seconds without a pull on the sticking point after which the hand counts as at rest. Shorter sticks between the
  /// encoder's steps of a slow slide; longer forgets the static friction of a hand that has stopped.
  static constexpr double kRest_s = 0.1;

  /// One tick. @param mu  At the IHIP; where the static one is 0, nothing begins to stick.
  /// @return Force on the hand, object frame, N: along the surface, towards the sticking point.
  [[nodiscard]] Vec3 follow(const PressedPoint& at, FrictionCoefficients mu, const FrictionScale& scale,
                            double period_s) noexcept;
  /// Contact is lost.
  void release() noexcept { *this = {}; }
  /// Into the frame of another object, on to which the IHIP slides.
  void carry(Vec3 stickingPoint) noexcept { point_ = stickingPoint; }
  /// The surface's coefficients were edited, or are another object's: also while it sticks.
  void edit(FrictionCoefficients mu) noexcept { mu_ = mu; }

  [[nodiscard]] FrictionState state() const noexcept { return state_; }
  [[nodiscard]] Vec3 stickingPoint() const noexcept { return point_; }  ///< Object frame, m.

  HAPTICS_FIELDS(self.state_, self.mu_, self.point_, self.rested_s_);

 private:
  Word<FrictionState> state_ = FrictionState::kNone;
  FrictionCoefficients mu_;
  Vec3 point_{0};
  double rested_s_ = 0;
};
static_assert(std::is_trivially_copyable_v<StickSlip>);

}  // namespace haptics
