#pragma once

#include "haptic_server/engine/geometry/triangle_record.h"
#include "tests/eval/baselines/body_set.h"

namespace haptics::eval {

/// What the printed algorithm leaves open: where a point of a primitive may lie that is nearest to the HIP.
enum class Primitives {
  kClosed,  ///< A polygon holds its lines and vertices, a line its vertices.
  kOpen,    ///< They do not: a HIP that projects outside of a primitive has no distance to it.
};

/// The pseudocode of Ho, Basdogan and Srinivasan, Efficient point-based rendering techniques for haptic display of
/// virtual objects, 1999, section 3.2, as printed and nothing else: the first contact's tick computes no force, the
/// search follows the printed neighbours with the printed comparison, the sign is that of the primitive's normal, and
/// neither other bodies nor the motion of this one are looked at after first contact.
template <Primitives kPrimitives>
class Pseudocode final : public Baseline {
 public:
  void place(Vec3 hip) override;
  Felt tick(std::span<const Pose> poses, Vec3 hip) override;

 private:
  struct Primitive {
    Feature kind = Feature::kPolygon;
    std::uint32_t triangle = kNoTriangle;
    int index = 0;
  };
  struct Distance {
    double squared;
    Vec3 point;
  };
  [[nodiscard]] const CollisionMesh& surface() const { return bodies_.surface(body_); }
  [[nodiscard]] Distance distanceTo(const Primitive& primitive, Vec3 hip) const;
  /// Calls visit(primitive) for each of the neighbours (the paper's Figure 3).
  template <class Visit>
  void forNeighbours(const Primitive& primitive, Visit visit) const;
  [[nodiscard]] Felt firstContact(Vec3 hip);
  [[nodiscard]] Felt search(Vec3 hip);

  bool collision_ = false;
  Vec3 previousHip_{0};
  int body_ = 0;
  Primitive contacted_;
};

extern template class Pseudocode<Primitives::kClosed>;
extern template class Pseudocode<Primitives::kOpen>;

}  // namespace haptics::eval
