#pragma once

#include <string>
#include <vector>

#include "haptic_server/engine/contact/contact.h"
#include "haptic_server/engine/contact/fast_path/contact_cache.h"
#include "haptic_server/engine/step/servo_scene.h"

namespace haptics::eval {

/// What a device is pressed onto, along -z. World frame, metres.
struct TestSurface {
  std::string name;   ///< As in the records.
  std::string title;  ///< For people.
  std::vector<std::shared_ptr<const CollisionMesh>> surfaces;
  std::vector<Pose> poses;
  Vec3 place{0};  ///< On the surface; the way down to it is free.
  // Felt by ours only:
  bool friction = false;  ///< 0.6 static, 0.4 dynamic.
  std::shared_ptr<const RigidBody> motion = nullptr;
  std::shared_ptr<const SoftTissue> tissue = nullptr;
};

[[nodiscard]] TestSurface makeWall();       ///< The plane z = 0.
[[nodiscard]] TestSurface makeOuterEdge();  ///< Of a cube: its upper side, 0.3 mm beside the edge.
[[nodiscard]] TestSurface makeGroove();  ///< Between two cubes, 90 degrees: the IHIP is held by two surfaces at once.
[[nodiscard]] TestSurface makeRoughWall();      ///< With friction.
[[nodiscard]] TestSurface makePushedBody();     ///< A block of 0.1 kg that slides down against a spring of 500 N/m.
[[nodiscard]] TestSurface makeElasticTissue();  ///< Of 500 N/m.
[[nodiscard]] TestSurface makeViscousTissue();  ///< The same, that takes 50 ms to go back.
[[nodiscard]] TestSurface makeBall();           ///< A sphere of 50 mm radius, pressed on its top.

/// The contact core on a ground, for those that bring a force law of their own.
class GroundContact {
 public:
  explicit GroundContact(const TestSurface& ground);
  void place(Vec3 hip) noexcept { haptics::resetContact(state_, hip); }
  [[nodiscard]] ContactResult follow(Vec3 hip) noexcept { return followContact(bodies_, state_, hip, cache_); }

 private:
  std::vector<std::shared_ptr<const CollisionMesh>> surfaces_;
  std::vector<Body> bodies_;
  ContactState state_;
  ContactCache cache_;
};

/// As the server's scenes hold it.
[[nodiscard]] ServoScene sceneOf(const TestSurface& ground, double stiffness_N_per_m, double damping_Ns_per_m);

}  // namespace haptics::eval
