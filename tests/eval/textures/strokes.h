#pragma once

#include <optional>
#include <vector>

#include "tests/eval/textures/texture_sample.h"

// The texture of an exhibit on a board, felt with positions given: what the force says of the height field.
namespace haptics::eval {

inline constexpr double kStroke_m = 0.064;         ///< Along x, its middle at x = 0.
inline constexpr double kStrokeAcross_m = 0.7e-3;  ///< Its y.
inline constexpr double kPressed_m = 0.8e-3;       ///< Below the board's upper side; more than K h.

/// Along the stroke, at even distances.
struct StrokeSignals {
  std::vector<double> height_m;        ///< h as the step tells it;
  std::vector<double> reference_m;     ///< as the reference has it.
  std::vector<double> normalForce_N;   ///< Felt, upwards.
  std::vector<double> lateralForce_N;  ///< Felt, along x.
};
[[nodiscard]] StrokeSignals strokeOver(const TextureCase& textureCase, const Texture& texture, const Feel& feel);

/// Height over the board along the stroke by the reference, in m.
class ReferenceHeight {
 public:
  ReferenceHeight(const TextureCase& textureCase, const Texture& texture)
      : reference_(textureCase.reference),
        amplitude_m_(texture.amplitude_m),
        zero_(texture.literal ? 0 : textureCase.field->lowest()) {}

  [[nodiscard]] double at(double x_m, double y_m = kStrokeAcross_m) const {
    return amplitude_m_ * (reference_({x_m, y_m, 0}) - zero_);
  }
  /// By differences of fourth order over 0.5 um.
  [[nodiscard]] double slope(double x_m) const;

 private:
  const Reference& reference_;
  double amplitude_m_;
  double zero_;
};

/// Press where the height is one extreme of the stroke's, slide to where it is the other, lift.
struct LoopWork {
  double measured_J = 0;  ///< Given to the hand.
  double derived_J = 0;   ///< k p (h2 - h1) + k (1 - K) (h2^2 - h1^2) / 2; of bump mapping 0.
};
/// @param upwards  From the valley to the crest, which feeds energy; else back.
[[nodiscard]] LoopWork loopOver(const TextureCase& textureCase, const Texture& texture, const Feel& feel, bool upwards);

/// Lateral stiffness along the stroke, by displacements of 2.5 um to either side.
struct LateralStiffness {
  double measuredMax_N_per_m = 0;
  double derivedMax_N_per_m = 0;  ///< k K (h'^2 + h h''), by the reference.
  double error_ratio = 0;         ///< Largest difference anywhere, of the largest stiffness.
};
[[nodiscard]] LateralStiffness lateralStiffnessOf(const TextureCase& textureCase, const Texture& texture,
                                                  const Feel& feel);

/// RMS above 100 Hz of what the felt force has and Eq. (4) at the true place has not, stroked at 50 mm/s with positions
/// that the encoder has rounded. N.
[[nodiscard]] double falseForceAbove100Hz_N(const TextureCase& textureCase, const std::optional<Texture>& texture,
                                            const Feel& feel, double encoder_m);

}  // namespace haptics::eval
