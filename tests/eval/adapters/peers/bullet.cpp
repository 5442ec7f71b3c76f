// Bullet's collision world: a sphere is swept towards the hand and slides along what it meets, as its character controller does.

#include <btBulletCollisionCommon.h>

#include <memory>

#include "tests/eval/adapters/peers/peer_scene.h"

namespace haptics::eval::peers {
namespace {

// Its tolerances are absolute, made for bodies of 0.05 to 10 of its units.
constexpr double kUnits_per_m = 100;

btVector3 toBullet(Vec3 v) {
  v *= kUnits_per_m;
  return {static_cast<btScalar>(v.x), static_cast<btScalar>(v.y), static_cast<btScalar>(v.z)};
}
Vec3 fromBullet(const btVector3& v) { return Vec3(v.x(), v.y(), v.z()) / kUnits_per_m; }
btTransform toBullet(const haptics_pose& pose) {
  const double* const q = pose.rotation;
  return btTransform(btQuaternion(static_cast<btScalar>(q[1]), static_cast<btScalar>(q[2]), static_cast<btScalar>(q[3]),
                                  static_cast<btScalar>(q[0])),
                     toBullet(toVec3(pose.position)));
}
btTransform unturned(const btVector3& place) { return btTransform(btQuaternion::getIdentity(), place); }

class World {
 public:
  explicit World(const haptics_scene& scene) : proxy_(toBullet(toVec3(scene.hip_m))) {
    for (std::uint32_t i = 0; i < scene.body_count; ++i) add(scene.bodies[i]);
  }
  ~World() {
    for (const auto& body : bodies_) world_.removeCollisionObject(&body->object);
  }

  void place(Vec3 hip) { proxy_ = toBullet(hip); }

  void tick(const haptics_pose* poses, Vec3 hip, haptics_answer& answer) {
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      bodies_[i]->object.setWorldTransform(toBullet(poses[i]));
      world_.updateSingleAabb(&bodies_[i]->object);
    }
    if (follow(toBullet(hip))) {
      answerSphere(answer, fromBullet(proxy_), hip, stiffness_N_per_m_);
    } else {
      answerPlace(answer, hip);
    }
  }

 private:
  struct Body {
    std::vector<btScalar> vertices;
    std::vector<int> triangles;
    std::unique_ptr<btTriangleIndexVertexArray> arrays;
    std::unique_ptr<btBvhTriangleMeshShape> shape;
    btCollisionObject object;
  };

  void add(const haptics_body& of) {
    auto body = std::make_unique<Body>();
    for (std::uint32_t i = 0; i < 3 * of.vertex_count; ++i)
      body->vertices.push_back(static_cast<btScalar>(of.vertices[i] * kUnits_per_m));
    body->triangles.assign(of.triangles, of.triangles + 3 * of.triangle_count);
    body->arrays = std::make_unique<btTriangleIndexVertexArray>(
        static_cast<int>(of.triangle_count), body->triangles.data(), 3 * sizeof(int), static_cast<int>(of.vertex_count),
        body->vertices.data(), 3 * sizeof(btScalar));
    body->shape = std::make_unique<btBvhTriangleMeshShape>(body->arrays.get(), true);
    body->shape->setMargin(0);
    body->object.setCollisionShape(body->shape.get());
    body->object.setWorldTransform(toBullet(of.pose));
    world_.addCollisionObject(&body->object);
    stiffness_N_per_m_ = of.stiffness_N_per_m;
    bodies_.push_back(std::move(body));
  }

  /// @return Whether something was in the way.
  bool follow(btVector3 target) {
    constexpr int kSlides = 4;
    bool met = false;
    btVector3 lastNormal(0, 0, 0);
    for (int i = 0; i < kSlides && (target - proxy_).length2() > 0; ++i) {
      btCollisionWorld::ClosestConvexResultCallback hit(proxy_, target);
      world_.convexSweepTest(&sphere_, unturned(proxy_), unturned(target), hit);
      if (!hit.hasHit()) {
        proxy_ = target;
        return met;
      }
      proxy_.setInterpolate3(proxy_, target, hit.m_closestHitFraction);
      const btVector3 normal = hit.m_hitNormalWorld;
      btVector3 way = target - proxy_;
      way -= normal * normal.dot(way);
      if (met && way.dot(lastNormal) < 0) {  // along both
        const btVector3 along = normal.cross(lastNormal);
        way = along.length2() > 0 ? along * (along.dot(way) / along.length2()) : btVector3(0, 0, 0);
      }
      target = proxy_ + way;
      lastNormal = normal;
      met = true;
    }
    return met;
  }

  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btCollisionWorld world_{&dispatcher_, &broadphase_, &configuration_};
  btSphereShape sphere_{static_cast<btScalar>(kProxyRadius_m * kUnits_per_m)};
  std::vector<std::unique_ptr<Body>> bodies_;
  btVector3 proxy_;
  double stiffness_N_per_m_ = 0;
};

}  // namespace
}  // namespace haptics::eval::peers

const haptics_method_functions* haptics_method() {
  using namespace haptics::eval::peers;
  static const std::string version = "Bullet " + std::to_string(btGetVersion() / 100) + '.' +
                                     std::to_string(btGetVersion() % 100) + ", swept sphere of 1 mm, 1 cm a unit";
  return functionsOf<World>(HAPTICS_MOVING_BODIES | HAPTICS_OPEN_MESHES | HAPTICS_EDITS, "bullet", version.c_str());
}
