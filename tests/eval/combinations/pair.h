#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

/// What an object can have beyond its shape, two at a time in one scene, against references that share no code with the
/// runtime. SI in the code; units as the names say in the results.
namespace haptics::eval {

enum class Feature : std::uint8_t {
  kTexture,
  kShading,
  kFriction,
  kSoftness,
  kPlastic,
  kLattice,
  kMotion,
  kSeveral,
  kEffects
};
inline constexpr std::array<std::string_view, 9> kFeatureNames{"texture", "shading", "friction", "softness", "plastic",
                                                               "lattice", "motion",  "several",  "effects"};
inline constexpr std::size_t kFeatures = kFeatureNames.size();

[[nodiscard]] constexpr std::string_view nameOf(Feature feature) {
  return kFeatureNames[static_cast<std::size_t>(feature)];
}

/// What is switched off.
enum class Ablation : std::uint8_t {
  kNone,
  kFieldsAtDisplacedPoints,  ///< Texture and friction are looked up at the displaced IHIP, not at the material point.
  kFacets,                   ///< Soft bodies have no shading normals.
  kMuAtIhip,                 ///< Friction's coefficients are the IHIP's also while it sticks.
  kFirstNormal,              ///< Friction in a groove: the first body's coefficient times the whole force.
};

enum class Measure : std::uint8_t {
  kBadTicks,       ///< Not finite, or without the contact that the reference has.
  kStep_N,         ///< Largest change from tick to tick of the force's deviation from the reference.
  kFalseForce_N,   ///< RMS of that deviation above 100 Hz.
  kForce,          ///< RMS of that deviation over the RMS of the reference.
  kDirection_deg,  ///< RMS angle of the force, without friction, to the reference.
  kHeight,         ///< Felt height less that of the material point, the largest, over the highest bump.
  kFriction,       ///< Friction's force over the reference, less 1; the largest while sliding.
  kLoop_J,         ///< Given to the hand round a closed loop.
  kTrajectory,  ///< The body's way less that by Newton's law under the felt force, the largest, over the longest way.
};
inline constexpr std::array<std::string_view, 9> kMeasureNames{"bad_ticks",      "step_N",        "false_force_N",
                                                               "force_ratio",    "direction_deg", "height_ratio",
                                                               "friction_ratio", "loop_J",        "trajectory_ratio"};

[[nodiscard]] constexpr std::string_view nameOf(Measure measure) {
  return kMeasureNames[static_cast<std::size_t>(measure)];
}

/// What one seed came to.
struct PairResult {
  std::map<Measure, double> measures;
  std::string plotted;                           ///< Quantity and unit of the curves.
  std::vector<std::pair<double, double>> felt;   ///< Over seconds.
  std::vector<std::pair<double, double>> right;  ///< Of the reference.

  /// Keeps the larger.
  void worst(Measure measure, double value) {
    double& kept = measures.try_emplace(measure, 0).first->second;
    if (value > kept || std::isnan(value)) kept = value;
  }
};

}  // namespace haptics::eval
