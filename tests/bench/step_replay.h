#pragma once

#include <memory>
#include <string_view>

#include "haptic_server/engine/step/haptic_step.h"
#include "tests/bench/scenes.h"

namespace haptics::bench {

/// What the surface of the one object feels like beyond its shape.
struct SurfaceCase {
  const char* name;
  bool shading = false;
  bool friction = false;
  /// Of a grating of 3 mm (Fourier), or of gradient noise of 2 mm in one octave.
  enum class Texture { kNone, kGrating, kNoise } texture = Texture::kNone;
  bool stabilised = false;  ///< Nothing of the surface: with the server's observer in front, a period's delay known.
  bool soft = false;        ///< With dents of 5 mm radius.
};

inline constexpr SurfaceCase kPlain{"plain"};
inline constexpr SurfaceCase kShading{"shading", true};
inline constexpr SurfaceCase kFriction{"friction", false, true};
inline constexpr SurfaceCase kGrating{"texture_grating", false, false, SurfaceCase::Texture::kGrating};
inline constexpr SurfaceCase kNoise{"texture_noise", false, false, SurfaceCase::Texture::kNoise};
inline constexpr SurfaceCase kStabilised{"stabilised", false, false, SurfaceCase::Texture::kNone, true};
inline constexpr SurfaceCase kSoft{.name = "soft_5mm", .soft = true};
inline constexpr SurfaceCase kAllFeatures{"shading_friction_texture_noise", true, true, SurfaceCase::Texture::kNoise};
inline constexpr SurfaceCase kSoftWithAll{.name = "soft_5mm_shading_friction_texture_noise",
                                          .shading = true,
                                          .friction = true,
                                          .texture = SurfaceCase::Texture::kNoise,
                                          .soft = true};

/// The production step, from the device's position to the force (paper 3.2), driven around a closed path.
class StepReplay {
 public:
  /// Leads the HIP to the path and once around.
  StepReplay(ServoScene scene, const StepConfig& config, const std::vector<Vec3>& approach, std::vector<Vec3> path);
  /// The first body of the scene is the only object.
  StepReplay(const Scene& scene, std::uint32_t segments, const SurfaceCase& surface);

  TelemetrySample tick() noexcept { return hapticStep(scene_, *state_, config_, next()); }

  /// The same in the parts in which the server's loop runs it, of which the device waits for the second.
  void read() noexcept {
    felt_ = {};
    input_ = next();
  }
  void feel() noexcept { computeForce(scene_, *state_, config_, input_, felt_); }
  TelemetrySample finish() noexcept { return finishStep(scene_, *state_, config_, input_, felt_); }

 private:
  StepInput next() noexcept {
    const Vec3 hip = path_[next_];
    if (++next_ == path_.size()) next_ = 0;
    return inputAt(hip);
  }
  StepInput inputAt(Vec3 hip) noexcept { return {++ticks_, 0, {hip, DeviceState::kReady}}; }

  ServoScene scene_;
  std::vector<Vec3> path_;
  StepConfig config_;
  std::unique_ptr<HapticState> state_;
  std::uint64_t ticks_ = 0;
  std::size_t next_ = 0;
  StepInput input_;
  ForceResult felt_;
};

/// A bar of 40 mm that the hand holds, pressed on a table with a face of 47 points and stroked over it in circles.
[[nodiscard]] StepReplay heldTool();
/// A brick rests on a brick that slides over a heavy board, which a spring swings to and fro; the hand is away.
[[nodiscard]] StepReplay slidingBodies();
/// In the open, with one effect in an object's frame: a spring to a point, one to the nearest place of a path of 1,000 points
/// that goes round three times, and a guide along it.
[[nodiscard]] StepReplay inTheOpen();  ///< The same without.
[[nodiscard]] StepReplay springToPoint();
[[nodiscard]] StepReplay springToPath();
[[nodiscard]] StepReplay guide();

}  // namespace haptics::bench
