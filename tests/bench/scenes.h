#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "common/mesh/tri_mesh.h"
#include "haptic_server/engine/contact/contact.h"
#include "haptic_server/engine/contact/fast_path/contact_cache.h"
#include "haptic_server/engine/contact/fast_path/triangle_walk.h"
#include "haptic_server/engine/contact/hip_following.h"

/// Spheres of 50 mm radius and closed paths of the HIP at 0.1 m/s and 1 kHz, 2 mm deep.
namespace haptics::bench {

inline constexpr double kRadius_m = 0.05;
inline constexpr double kDepth_m = 0.002;
inline constexpr double kStep_m = 1e-4;  ///< Of the HIP in a tick.
inline constexpr double kRubbingRadius_m = 0.0005;
inline constexpr double kGap_m = 0.001;  ///< Between the contacted sphere and a second one that is near.

/// The cube itself, of 12 triangles.
inline constexpr std::uint32_t kCoarsest = 1;
/// Of the cube that the sphere is mapped from: 1,728, 63,948, 1,002,252 and 10,002,828 triangles.
inline constexpr std::array<std::uint32_t, 4> kSegments{12, 73, 289, 913};
[[nodiscard]] constexpr std::uint32_t triangleCount(std::uint32_t segments) noexcept {
  return 12 * segments * segments;
}

[[nodiscard]] TriMesh sphereMesh(std::uint32_t segments);
/// Built once in a run.
[[nodiscard]] std::shared_ptr<const CollisionMesh> sphere(std::uint32_t segments);

/// Bodies at rest, and the places of a HIP that goes round and round.
struct Scene {
  std::vector<Body> bodies;
  std::vector<Vec3> approach;
  std::vector<Vec3> path;
};

struct Trajectory {
  const char* name;
  Scene (*make)(std::uint32_t segments);
};

/// Of a benchmark, in which `what` is measured.
[[nodiscard]] std::string nameOf(const char* what, const Trajectory& trajectory, std::uint32_t segments);

/// Places kStep_m apart, or a little less.
[[nodiscard]] std::vector<Vec3> circle(Vec3 centre, Vec3 axis, double radius_m);
/// Likewise, from outside to just before the place.
[[nodiscard]] std::vector<Vec3> wayTo(Vec3 place, Vec3 outside);

/// Small circles over one place: what the tick reads stays in the first level cache.
[[nodiscard]] Scene rubbing(std::uint32_t segments);
/// Once around the sphere, aslant: a finer mesh has more triangles to cross in a tick.
[[nodiscard]] Scene slide(std::uint32_t segments);
/// As slide(), as far above the surface as slide() is below it; within the sphere's box.
[[nodiscard]] Scene freeSpace(std::uint32_t segments);
/// As rubbing(), with a second sphere 1 mm above the place.
[[nodiscard]] Scene secondBodyNear(std::uint32_t segments);
/// Around the groove between two spheres that overlap, held by both.
[[nodiscard]] Scene lineContact(std::uint32_t segments);

inline constexpr Trajectory kRubbing{"rubbing_0.5mm_circle", rubbing};
inline constexpr Trajectory kSlide{"slide_48mm_circle", slide};
inline constexpr Trajectory kFreeSpace{"free_space_52mm_circle", freeSpace};
inline constexpr Trajectory kSecondBodyNear{"second_body_1mm_above_rubbing_0.5mm_circle", secondBodyNear};
inline constexpr Trajectory kLineContact{"line_contact_of_two_28mm_circle", lineContact};

/// The contact core, driven around a scene's path.
class Replay {
 public:
  /// Leads the HIP to the path and once around.
  explicit Replay(Scene scene);

  ContactResult tick() noexcept {
    const Vec3 hip = scene_.path[next_];
    if (++next_ == scene_.path.size()) next_ = 0;
    return followContact(scene_.bodies, state_, hip, cache_);
  }
  [[nodiscard]] const Scene& scene() const noexcept { return scene_; }
  [[nodiscard]] const ContactState& state() const noexcept { return state_; }

 private:
  Scene scene_;
  ContactState state_;
  ContactCache cache_;
  std::size_t next_ = 0;
};

/// The search of a tick alone: where the neighborhood watch takes the IHIP after the HIP, around the path of a scene
/// whose first body holds it and stands at the origin.
class Search {
 public:
  explicit Search(Scene scene);

  /// Returns the distance of HIP and IHIP, m.
  double tick() noexcept {
    const CollisionMesh& surface = *replay_.scene().bodies.front().surface;
    const HipMotion motion{hip_, replay_.scene().path[next_]};
    if (foot_.feature == Feature::kPolygon && !polygon_.is(surface, foot_.triangle)) {
      polygon_.load(surface, foot_.triangle);
    }
    const Vec3x4 to = broadcast(motion.to);
    Prism::Coordinates end = polygon_.prism.coordinates(to);
    int looked = 1;
    if (foot_.feature == Feature::kPolygon &&
        (end.beyond() == 0 || walkTriangles(surface, polygon_, polygon_, broadcast(motion.from), to, 1, kSearchBudget,
                                            end, looked, nullptr))) {
      foot_.triangle = polygon_.triangle;
      foot_.point = vec3(polygon_.foot(toDouble4(motion.to), end.height()));
    } else {
      searchFurther(motion);
    }
    if (++next_ == replay_.scene().path.size()) next_ = 0;
    hip_ = motion.to;
    return glm::distance(foot_.point, hip_);
  }

 private:
  void searchFurther(const HipMotion& motion) noexcept;

  Replay replay_;
  Vec3 hip_;
  ClosestPoint foot_;
  CachedTriangle polygon_;
  std::size_t next_ = 0;
};

}  // namespace haptics::bench
