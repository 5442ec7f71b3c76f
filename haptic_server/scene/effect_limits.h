#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/scene/scene.h"
#include "haptic_server/scene/surface_warnings.h"

namespace haptics {

/// Of what an effect may have by itself, so much is felt.
struct EffectShare {
  double stiffness = 1, damping = 1;

  bool operator==(const EffectShare&) const = default;
};

/// The places of a scene's effects, of which those that may hold or drag the hand at once share what the device bears.
class EffectZones {
 public:
  /// Those in the frame of an object that moves by itself come anywhere; the others are where its pose has them.
  void add(const ObjectRecord& record);

  /// Of each effect of the object, in order.
  [[nodiscard]] std::vector<EffectShare> sharesOf(ObjectId object, const DeviceLimits& device) const;

 private:
  /// A ball, outside of which the effect is not felt.
  struct Zone {
    ObjectId object = 0;
    bool moves = false;  ///< It is in the frame of the object, else in the world's.
    Vec3 centre_m{0};
    double radius_m = 0;  ///< Infinite: anywhere.
    Vec3 along{0};        ///< It acts along this direction alone; 0: along any.
    Effect::Kind kind;
    double stiffness_N_per_m, damping_Ns_per_m;
  };
  std::vector<Zone> zones_;

  [[nodiscard]] static double together(const Zone& a, const Zone& b) noexcept;
};

/// An object's effects as they are felt: each with no more stiffness and damping than the device bears of a surface (less where no
/// observer looks ahead and it pulls from both sides), all that may act at one place with no more than one of them may have, and those in
/// the frame of a body that moves together with no more than it bears (stableStiffnessShare()). The force of a recorded texture grows by
/// no more for each m/s of the hand than that damping.
/// @param all  Of the scene, this object's among them.
/// @param apparentMass_kg  Of that body; none: it stands still.
[[nodiscard]] std::vector<Effect> stableEffects(const ObjectRecord& record, const EffectZones& all,
                                                std::optional<double> apparentMass_kg, const DeviceLimits& device);

/// What an effect pushes a hand with at most that goes at up to 2 m/s, N; infinite where only the device's limit bounds it.
[[nodiscard]] double strongest_N(const Effect& effect) noexcept;
/// A smaller force is not noticed, by what `advise` and Simplify count as noticed.
inline constexpr double kNoticed_N = 0.05;

/// A warning of each that is felt as another one than asked for, or not noticed, and of a vibration from half the servo's rate on.
/// @param all  Of the scene, this object's among them.
[[nodiscard]] std::vector<std::string> effectWarnings(const ObjectRecord& record, const ObjectAssets& assets,
                                                      const EffectZones& all, const DeviceLimits& device);

}  // namespace haptics
