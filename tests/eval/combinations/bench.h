#pragma once

#include <algorithm>
#include <memory>
#include <span>
#include <vector>

#include "common/mesh/tri_mesh.h"
#include "common/scene/effect_properties.h"
#include "haptic_server/engine/step/haptic_step.h"
#include "tests/eval/combinations/pair.h"
#include "tests/eval/combinations/waves.h"
#include "tests/eval/methods.h"

namespace haptics::eval {

inline constexpr double kTick_s = 1e-3;
inline constexpr double kApproach_s = 0.25;      ///< In which the hand comes down,
inline constexpr double kBeforeStroke_s = 0.35;  ///< and from the first tick until it moves along.

/// 0 to 1, C1, both ends level.
[[nodiscard]] inline double smoothStep(double part) {
  const double s = std::clamp(part, 0.0, 1.0);
  return s * s * (3 - 2 * s);
}
/// How deep a hand is that comes from above the surface down to a depth.
[[nodiscard]] inline double approach_m(double time_s, double depth_m) {
  constexpr double kClear_m = 1.5e-3;
  return (depth_m + kClear_m) * smoothStep(time_s / kApproach_s) - kClear_m;
}

/// Properties of a surface, and the same as the reference knows them.
struct Skin {
  bool shaded = false;
  double textureHeight_m = 0;  ///< Amplitude; 0: none.
  Waves relief;                ///< One wave.
  double muStatic = 0, muDynamic = 0, variation = 0;
  Waves map;

  static constexpr double kGain = 1.5;  ///< K of Eq. (4).

  [[nodiscard]] bool any() const { return shaded || textureHeight_m > 0 || muStatic > 0; }
  /// Of the material point, m: the lowest is 0.
  [[nodiscard]] double height_m(Vec3 material) const { return textureHeight_m * (relief.value(material) + 1); }
  [[nodiscard]] Vec3 heightGradient(Vec3 material) const { return textureHeight_m * relief.gradient(material); }
  [[nodiscard]] double factor(Vec3 material) const { return std::max(0.0, 1 + variation * map.value(material)); }
};

/// The production step in virtual time over objects that are given in a scene's frame, which stands anywhere in the
/// world.
class Bench {
 public:
  /// @param effects  Of the first object.
  Bench(std::vector<ServoObject> objects, const Pose& frame, const std::vector<Effect>& effects = {});
  /// The same by another method, if there is one: it gets the objects' meshes and poses, all with the first one's stiffness
  /// and with this skin. Throws NotApplicable where the method knows nothing of that.
  Bench(std::vector<ServoObject> objects, const Pose& frame, const Method* guest, const Skin& skin,
        const std::vector<Effect>& effects = {});

  /// The same objects in another shape.
  void adopt(std::vector<ServoObject> objects);
  /// HIP in the scene's frame; so are the forces and the IHIP of what comes back. A guest's friction is within the contact
  /// force: tellFrictionApart().
  TelemetrySample tick(Vec3 hip);

  /// In the scene's frame, as it was in the last tick.
  [[nodiscard]] Pose poseOf(std::size_t body) const;
  [[nodiscard]] HapticState& state() noexcept { return *state_; }

 private:
  TelemetrySample tickOfGuest(Vec3 hip);

  Pose frame_;
  std::unique_ptr<Renderer> guest_;
  std::vector<std::shared_ptr<const CollisionMesh>> surfaces_;  // a guest's,
  std::vector<Pose> poses_;                                     // in the world
  bool begun_ = false;
  StepConfig config_;
  std::unique_ptr<HapticState> state_;
  std::unique_ptr<ServoScene> scene_;
  std::vector<ServoEffect> effects_;
  std::uint64_t ticks_ = 0;
};

/// What there is of a force beside a direction, as friction. Of a guest, whose answer is one force.
void tellFrictionApart(TelemetrySample& felt, Vec3 normal);

/// @param shift  Ablation: fields are looked up so far (object frame) from where the runtime asks; null: there.
/// @param material  As in SurfaceDetail.
[[nodiscard]] std::shared_ptr<const SurfaceDetail> detailOf(const Skin& skin, const CollisionMesh& surface,
                                                            const Vec3* shift,
                                                            std::shared_ptr<const std::vector<Vec3f>> material);

/// Eqs. (4a) and (4b) as printed, over the stiffness, m. @param depth_m  Of the HIP below the surface without texture.
[[nodiscard]] Vec3 printedForce(double depth_m, Vec3 normal, double height_m, Vec3 gradient);

/// What a bench felt beside the reference. Scene frame.
class Comparison {
 public:
  /// What the reference says of a tick.
  struct Right {
    Vec3 normal_N{0};      ///< Without friction.
    Vec3 friction_N{0};    ///< Of sliding.
    double height_m = 0;   ///< Of the texture's material point,
    double highest_m = 0;  ///< and its highest; 0: no texture.
    bool slides = false;   ///< Friction is judged.
    bool judged = false;   ///< The stroke is; before it only steps are.
  };

  void add(const TelemetrySample& felt, const Right& right);
  /// @param friction, texture  Whether there is any to be measured.
  void addTo(PairResult& result, bool friction, bool texture) const;

 private:
  std::vector<Vec3> felt_N_, right_N_, deviation_N_;  // of judged ticks
  std::vector<double> feltHeight_m_, rightHeight_m_, feltFriction_N_, rightFriction_N_;
  double highest_m_ = 0;
  double step_N_ = 0;
  double angle2_ = 0;
  double worstHeight_ = 0;
  double worstFriction_ = 0;
  Vec3 last_N_{0};
  bool lastJudged_ = false, first_ = true;
  int bad_ = 0;
};

/// Work (J) that forces give along the places, both in one frame: trapezoids.
[[nodiscard]] double workAlong(std::span<const Vec3> force_N, std::span<const Vec3> place_m);

}  // namespace haptics::eval
