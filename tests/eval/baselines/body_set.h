#pragma once

#include <memory>
#include <span>
#include <vector>

#include "haptic_server/engine/geometry/collision_mesh.h"
#include "tests/eval/renderer.h"

namespace haptics::eval {

/// How a segment is tested against a triangle.
enum class SegmentTest {
  kWatertight,       ///< The production one (segment.h).
  kMoellerTrumbore,  ///< moeller_trumbore.h.
};

/// The bodies as the published methods see them: where they are at this tick. That a body moved since the last one is
/// nothing that any of them accounts for. Boxes are tested by the production hierarchy.
class BodySet {
 public:
  explicit BodySet(SegmentTest test = SegmentTest::kWatertight) : test_(test) {}

  struct Hit {
    int body = -1;
    Crossing crossing;

    explicit operator bool() const noexcept { return body >= 0; }
  };
  /// The nearest point of a surface, in the world.
  struct Nearest {
    bool inside = false;
    Vec3 point{0};
    Vec3 normal{0};  ///< Of the primitive there.
    double distance_m = 0;
    int triangles = 0;  ///< Looked at.
  };

  void set(std::span<const std::shared_ptr<const CollisionMesh>> surfaces, std::span<const Pose> poses) {
    surfaces_.assign(surfaces.begin(), surfaces.end());
    setPoses(poses);
  }
  void setPoses(std::span<const Pose> poses) { poses_.assign(poses.begin(), poses.end()); }

  [[nodiscard]] int count() const { return static_cast<int>(surfaces_.size()); }
  [[nodiscard]] const CollisionMesh& surface(int body) const { return *surfaces_[static_cast<std::size_t>(body)]; }
  [[nodiscard]] const Pose& pose(int body) const { return poses_[static_cast<std::size_t>(body)]; }
  [[nodiscard]] double extent_m() const;  ///< Largest coordinate that any body reaches.

  /// The first crossing into a body on from -> to (world).
  [[nodiscard]] Hit firstCrossing(Vec3 from, Vec3 to) const;
  /// Of the body that `hip` is deepest in, or nearest to when it is outside of all.
  [[nodiscard]] Nearest nearest(Vec3 hip) const;

 private:
  [[nodiscard]] static Crossing firstByRay(const CollisionMesh& surface, Vec3 from, Vec3 to);

  SegmentTest test_;
  std::vector<std::shared_ptr<const CollisionMesh>> surfaces_;
  std::vector<Pose> poses_;
};

/// A published method.
class Baseline : public Renderer {
 public:
  explicit Baseline(SegmentTest test = SegmentTest::kWatertight) : bodies_(test) {}
  void begin(std::span<const std::shared_ptr<const CollisionMesh>> bodies, std::span<const Pose> poses,
             Vec3 hip) override {
    setSpring();
    bodies_.set(bodies, poses);
    place(hip);
  }

 protected:
  BodySet bodies_;
};

}  // namespace haptics::eval
