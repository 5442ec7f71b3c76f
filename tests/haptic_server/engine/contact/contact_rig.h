#pragma once

#include <memory>
#include <vector>

#include "haptic_server/engine/contact/contact.h"
#include "haptic_server/engine/contact/fast_path/contact_cache.h"
#include "tests/haptic_server/engine/geometry/shapes.h"

namespace haptics {

/// Bodies, a contact among them and a HIP led by the test. Poses set between ticks are motion, as in the servo's step.
class ContactRig {
 public:
  ContactRig() = default;
  /// Of one body, to begin with.
  explicit ContactRig(std::shared_ptr<const CollisionMesh> surface) { add(std::move(surface)); }
  explicit ContactRig(const shapes::Shape& shape, Vec3 position = Vec3(0)) { add(shape, position); }
  ContactRig(const shapes::Shape& shape, const Pose& pose) { add(shape, pose); }

  int add(std::shared_ptr<const CollisionMesh> surface, Pose pose = {}) {
    surfaces_.push_back(std::move(surface));
    Body body;
    body.surface = surfaces_.back().get();
    body.previous = body.current = pose;
    body.update();
    bodies_.push_back(body);
    return static_cast<int>(bodies_.size()) - 1;
  }
  int add(const shapes::Shape& shape, Pose pose = {}) { return add(shape.build(), pose); }
  int add(const shapes::Shape& shape, Vec3 position) { return add(shape.build(), Pose{{1, 0, 0, 0}, position}); }

  void place(Vec3 hip) { haptics::resetContact(state_, hip); }
  /// In effect at the next tick.
  void move(int body, const Pose& pose) { bodies_[static_cast<std::size_t>(body)].current = pose; }
  ContactResult tick(Vec3 hip) {
    for (Body& body : bodies_) body.update();
    result_ = {};
    followContact(bodies_, state_, hip, result_, cache_);
    for (Body& body : bodies_) body.previous = body.current;
    return result_;
  }
  /// Ticks of at most `step` metres along a straight line; calls check(result, hip) after each.
  template <class Check>
  void lead(Vec3 from, Vec3 to, double step, Check check) {
    const int ticks = static_cast<int>(std::ceil(glm::distance(from, to) / step));
    for (int i = 1; i <= ticks; ++i) {
      const Vec3 hip = glm::mix(from, to, static_cast<double>(i) / ticks);
      check(tick(hip), hip);
    }
  }

  /// How deep a point is inside the deepest closed body (m), judged by all of its triangles; 0 when outside of all.
  [[nodiscard]] double depthInside(Vec3 world) const {
    double depth = 0;
    for (const Body& body : bodies_) {
      if (!body.surface->closed()) continue;
      const Vec3 local = toLocal(body.current, world);
      int spent = 0;
      const ClosestPoint foot =
          body.surface->closestFoot(local, static_cast<int>(body.surface->triangleCount()) + 1, spent);
      if (!body.surface->isOutside(foot, local)) depth = std::max(depth, std::sqrt(foot.squaredDistance));
    }
    return depth;
  }

  [[nodiscard]] std::vector<Body>& bodies() { return bodies_; }
  [[nodiscard]] ContactState& state() { return state_; }
  [[nodiscard]] ContactCache& cache() { return cache_; }
  [[nodiscard]] const ContactResult& result() const { return result_; }

 private:
  std::vector<std::shared_ptr<const CollisionMesh>> surfaces_;
  std::vector<Body> bodies_;
  ContactState state_;
  ContactCache cache_;
  ContactResult result_;
};

}  // namespace haptics
