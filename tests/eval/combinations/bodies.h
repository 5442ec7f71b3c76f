#pragma once

#include <memory>
#include <vector>

#include "common/mesh/tri_mesh.h"
#include "common/scene/deformation_properties.h"
#include "haptic_server/engine/geometry/collision_mesh.h"
#include "haptic_server/engine/motion/rigid_body.h"
#include "tests/eval/combinations/bench.h"

namespace haptics::eval {

inline constexpr double kPadSide_m = 0.1;
inline constexpr double kBallRadius_m = 0.05;

[[nodiscard]] const TriMesh& coarsePad();  ///< A cube about the origin; 12.5 mm edges.
[[nodiscard]] const TriMesh& finePad();    ///< The same with 2 mm edges: it dents.
[[nodiscard]] const TriMesh& clayPad();    ///< The same with 1.25 mm edges: it shows the dents that stay in it.
[[nodiscard]] const TriMesh& ball();       ///< 1,728 triangles.
[[nodiscard]] const TriMesh& fineBall();   ///< 27,648, for dents that stay.
/// One of these, built once.
[[nodiscard]] std::shared_ptr<const CollisionMesh> atRest(const TriMesh& mesh);

/// Three control points along each axis of a box about such a body, each moved by up to 3 mm.
[[nodiscard]] Lattice randomLattice(double side_m, Random& random);

/// Draws what both could need; has what they name.
[[nodiscard]] Skin randomSkin(Feature a, Feature b, Random& random);

/// A body that slides along an axis against a spring.
struct Slider {
  Vec3 axis{0, 0, 1};
  double mass_kg = 0;
  double spring_N_per_m = 0;
  double damping_Ns_per_m = 0;

  [[nodiscard]] std::shared_ptr<const RigidBody> body(const TriMesh& mesh) const;
};
[[nodiscard]] Slider randomSlider(Random& random);

/// Springs to a point and to a line, in the body's frame, and their law.
struct Pulls {
  Vec3 point_m{0}, line_m{0}, along{0, 0, 1};
  double toPoint_N_per_m = 0, toLine_N_per_m = 0;

  [[nodiscard]] std::vector<Effect> effects() const;
  /// @param hip  Body frame, and so is what comes back.
  [[nodiscard]] Vec3 force_N(Vec3 hip) const;
};
[[nodiscard]] Pulls randomPulls(Random& random);

/// Newton's law for a slider under a force that goes straight from what it is in each tick to what it is in the next: held for a tick,
/// it would come half a tick late.
class SliderReference {
 public:
  explicit SliderReference(const Slider& slider) : slider_(slider) {}

  /// @param pose  In this tick. @param onHand_N  What the body is given is the opposite. @param isJudged  By deviation().
  void follow(const Pose& pose, Vec3 onHand_N, bool isJudged = true);
  /// Largest difference from the poses, over the largest displacement.
  [[nodiscard]] double deviation() const { return longest_m_ > 0 ? farthest_m_ / longest_m_ : 0; }

 private:
  Slider slider_;
  bool begun_ = false;
  Pose start_;
  double place_m_ = 0, speed_m_per_s_ = 0, push_N_ = 0;
  double farthest_m_ = 0, longest_m_ = 0;
};

}  // namespace haptics::eval
