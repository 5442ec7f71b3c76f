#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/hash/content_hash.h"
#include "common/maths/fields.h"
#include "common/maths/vec.h"

namespace haptics {

/// A field of force that an object carries (Effect of scene.proto): members are named, ordered and numbered as there, and what is
/// absent there is 0. SI units, radians.
struct Effect {
  enum class Kind : std::uint8_t {
    kConstant = 1,
    kSpringToPoint,
    kSpringToLine,
    kSpringToPlane,
    kSpringToPath,
    kGuide,
    kForbiddenSide,
    kViscosity,
    kVibration,
    kTube,
    kInertia,
    kMagnet,
    kSpringToVertex,
    kSpringToEdge,
    kSamples,
    kRecordedTexture
  };
  enum class Frame : std::uint8_t { kObject = 1, kWorld };
  enum class Region : std::uint8_t { kEverywhere = 1, kBox, kSphere, kInside };
  enum class Trigger : std::uint8_t { kAlways = 1, kTouch, kButton };

  Kind kind = Kind::kConstant;
  Frame frame = Frame::kObject;
  Vec3 point_m{0};
  Vec3 direction{0};  ///< Unit, where the kind has one.
  std::vector<Vec3> path_m = {};
  double stiffness_N_per_m = 0;
  double damping_Ns_per_m = 0;
  double amplitude_N = 0;
  double frequency_Hz = 0;
  double phase_rad = 0;
  double limit_N = 0;    ///< 0: none.
  double reach_m = 0;    ///< 0: from anywhere.
  double release_m = 0;  ///< 0: reach_m.
  double fade_m = 0;
  Region region = Region::kEverywhere;
  Vec3 size_m{0};
  Trigger trigger = Trigger::kAlways;
  double mass_kg = 0;
  std::vector<float> samples = {};
  double sample_rate_Hz = 0;
  std::vector<double> speeds_m_per_s = {};
  std::vector<double> forces_N = {};
  std::vector<double> models = {};  ///< Of each speed those of all forces: deviation, reflection coefficients.

  bool operator==(const Effect&) const = default;
  HAPTICS_FIELDS(self.kind, self.frame, self.point_m, self.direction, self.path_m, self.stiffness_N_per_m,
                 self.damping_Ns_per_m, self.amplitude_N, self.frequency_Hz, self.phase_rad, self.limit_N, self.reach_m,
                 self.release_m, self.fade_m, self.region, self.size_m, self.trigger, self.mass_kg, self.samples,
                 self.sample_rate_Hz, self.speeds_m_per_s, self.forces_N, self.models);
};

/// Of all objects of a scene together.
inline constexpr std::size_t kMaxEffects = 32;
/// Of one path. The nearest place of one that lies on a sphere round the HIP takes a look at each point: 20 us.
inline constexpr std::size_t kMaxPathPoints = 4096;
/// Of one effect: eight seconds at 8 kHz.
inline constexpr std::size_t kMaxSamples = 65'536;
/// Of one recorded texture. More take longer to make ready for the servo: 1.3 ms each.
inline constexpr std::size_t kMaxTextureModels = 64;
/// Reflection coefficients of each of them.
inline constexpr std::size_t kMaxTextureOrder = 32;

/// In canonical form: the members of each before `trigger`, in order; then the triggers where one is not kAlways; then each later
/// member that is not absent. Nothing for no effects.
void addTo(Hasher& hasher, const std::vector<Effect>& effects);

}  // namespace haptics
