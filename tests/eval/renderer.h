#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/deform/soft_tissue.h"
#include "common/maths/vec.h"
#include "common/scene/surface_properties.h"
#include "common/surface/scalar_field.h"
#include "haptic_server/device/presets.h"
#include "haptic_server/engine/geometry/collision_mesh.h"

namespace haptics::eval {

/// The spring that every method renders with, contact.md's k: forces compare as depths.
inline constexpr double kSpring_N_per_m = 1000;
/// The servo's period in virtual time.
inline constexpr double kPeriod_s = 1e-3;

/// What a method answers in one tick. World frame.
struct Felt {
  bool touching = false;
  Vec3 ihip{0};          ///< Metres; the HIP when free.
  Vec3 force_N{0};       ///< On the hand, before any limit.
  int triangles = 0;     ///< Looked at one by one by a search, those behind the hierarchy's segment test not counted.
  bool sliding = false;  ///< Of friction.
  /// What the device is given; none: the force as it is.
  std::optional<Vec3> written_N = std::nullopt;
  /// How far the contact has followed the HIP, where the tick's allowance did not last to its end.
  std::optional<Vec3> followed = std::nullopt;

  [[nodiscard]] Vec3 onDevice_N() const { return written_N.value_or(force_N); }
};

/// What the bodies of a scene feel like beyond their shape, and the device under which they do.
struct FeltSurface {
  SurfaceProperties properties;
  std::shared_ptr<const ScalarField> texture;  ///< That the texture names, else null.
  double spring_N_per_m = kSpring_N_per_m;
  DevicePreset device;
  std::optional<SoftTissue> tissue = std::nullopt;  ///< None: rigid.
};

/// A scene as an edit leaves it.
struct EditedScene {
  std::span<const std::uint64_t> ids;  ///< Which body is which: 1, 2, ... in the order of begin(), and new ones.
  std::span<const std::shared_ptr<const CollisionMesh>> bodies;
  std::span<const Pose> poses;
  double spring_N_per_m;
};

/// What a scene is about, and a method made for. Bodies: that meet one another. Streams: of samples that drive bodies.
enum class Concern : std::uint8_t { kContact, kEdits, kSurfaces, kMotion, kSoftness, kBodies, kStreams };

class BodyWorld;

/// A method of rendering contact with a point, in virtual time.
class Renderer {
 public:
  virtual ~Renderer() = default;
  /// Another scene: bodies at these poses, the HIP (world, m) outside of all.
  virtual void begin(std::span<const std::shared_ptr<const CollisionMesh>> bodies, std::span<const Pose> poses,
                     Vec3 hip) = 0;
  /// Of all bodies from the next begin() on. Methods that render nothing but shapes have no part in such scenes.
  virtual void setSurfaceProperties(const FeltSurface& /*surface*/) {}
  /// The same scene, its bodies as they are now, attached anew to a HIP outside of all.
  virtual void place(Vec3 hip) = 0;
  /// From now on a tick does no more than find the contact and its spring force, shaded where it is, and counts no
  /// triangles: what the methods are timed at.
  virtual void contactOnly() {}
  /// The scene becomes another one under the hand, with the HIP wherever it is. Published methods know nothing of that:
  /// they begin anew.
  virtual void edit(const EditedScene& scene, Vec3 hip) {
    begin(scene.bodies, scene.poses, hip);
    setSpring(scene.spring_N_per_m);
  }
  /// One tick. A pose other than the last is motion.
  virtual Felt tick(std::span<const Pose> poses, Vec3 hip) = 0;
  /// The same of bodies that a client drives by samples of their poses, which have come in this tick or not. A method that
  /// knows nothing of samples has the bodies where the last one was.
  virtual Felt drive(std::span<const Pose> samples, bool /*haveCome*/, Vec3 hip) { return tick(samples, hip); }
  /// Of a body, in the order of the poses, in its frame, after the last tick.
  [[nodiscard]] virtual std::vector<Dent> dents(std::size_t /*body*/) const { return {}; }
  /// The smooth surface of force shading is nowhere farther off the body's polygons (m).
  [[nodiscard]] virtual double highestBulge_m(std::size_t /*body*/) const { return 0; }

  /// Of bodies that meet one another: by the production step, where the method has no way of its own.
  [[nodiscard]] virtual std::unique_ptr<BodyWorld> makeBodyWorld() const;
  /// Gets bodies that a lattice mirrors with their faces turned over, as the scene service makes them. The published
  /// methods take the triangles as they are.
  [[nodiscard]] virtual bool turnsMirroredOver() const { return false; }

 protected:
  /// Another scene begins with the usual one: begin() of whatever renders with it says so.
  void setSpring(double spring_N_per_m = kSpring_N_per_m) { spring_N_per_m_ = spring_N_per_m; }
  [[nodiscard]] double spring_N_per_m() const { return spring_N_per_m_; }

 private:
  double spring_N_per_m_ = kSpring_N_per_m;
};

}  // namespace haptics::eval
