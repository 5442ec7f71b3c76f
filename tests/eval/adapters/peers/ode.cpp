// ODE: a body in the hand, a small sphere on a spring and a damper, which contact joints keep out of the meshes.

#include <ode/ode.h>

#include <array>
#include <cmath>
#include <memory>

#include "tests/eval/adapters/peers/peer_scene.h"

namespace haptics::eval::peers {
namespace {

constexpr int kSteps = 4;  // of a tick
constexpr double kStep_s = 1e-3 / kSteps;
constexpr double kMass_kg = 0.02;

class World {
 public:
  explicit World(const haptics_scene& scene) {
    dWorldSetERP(world_, 0.8);
    dWorldSetCFM(world_, 1e-9);
    for (std::uint32_t i = 0; i < scene.body_count; ++i) add(scene.bodies[i]);
    dMass mass;
    dMassSetSphereTotal(&mass, kMass_kg, kProxyRadius_m);
    dBodySetMass(proxy_, &mass);
    sphere_ = dCreateSphere(space_, kProxyRadius_m);
    dGeomSetBody(sphere_, proxy_);
    place(toVec3(scene.hip_m));
  }
  ~World() {
    dJointGroupDestroy(joints_);
    dSpaceDestroy(space_);
    for (const auto& body : bodies_) dGeomTriMeshDataDestroy(body->data);
    dWorldDestroy(world_);
  }
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  void place(Vec3 hip) {
    dBodySetPosition(proxy_, hip.x, hip.y, hip.z);
    dBodySetLinearVel(proxy_, 0, 0, 0);
    dBodySetAngularVel(proxy_, 0, 0, 0);
    lastHip_ = hip;
  }

  void tick(const haptics_pose* poses, Vec3 hip, haptics_answer& answer) {
    for (std::size_t i = 0; i < bodies_.size(); ++i) setPose(bodies_[i]->geometry, poses[i]);
    const Vec3 velocity = (hip - lastHip_) / (kSteps * kStep_s);
    lastHip_ = hip;
    for (int step = 0; step < kSteps; ++step) {
      const Vec3 force =
          stiffness_N_per_m_ * (hip - position()) + damping_Ns_per_m_ * (velocity - toVec3(dBodyGetLinearVel(proxy_)));
      dBodyAddForce(proxy_, force.x, force.y, force.z);
      contacts_ = 0;
      for (const auto& body : bodies_) collide(body->geometry);
      dWorldQuickStep(world_, kStep_s);
      dJointGroupEmpty(joints_);
    }
    if (contacts_ > 0) {
      answerSphere(answer, position(), hip, stiffness_N_per_m_);
    } else {
      answerPlace(answer, hip);
    }
  }

 private:
  struct Body {
    std::vector<float> vertices;
    std::vector<dTriIndex> triangles;
    dTriMeshDataID data;
    dGeomID geometry;
  };

  [[nodiscard]] Vec3 position() const { return toVec3(dBodyGetPosition(proxy_)); }

  static void setPose(dGeomID geometry, const haptics_pose& pose) {
    const std::array<dReal, 4> q{pose.rotation[0], pose.rotation[1], pose.rotation[2], pose.rotation[3]};
    dGeomSetQuaternion(geometry, q.data());
    dGeomSetPosition(geometry, pose.position[0], pose.position[1], pose.position[2]);
  }

  void add(const haptics_body& of) {
    auto body = std::make_unique<Body>();
    body->vertices.assign(of.vertices, of.vertices + 3 * of.vertex_count);
    body->triangles.assign(of.triangles, of.triangles + 3 * of.triangle_count);
    body->data = dGeomTriMeshDataCreate();
    dGeomTriMeshDataBuildSingle(body->data, body->vertices.data(), 3 * sizeof(float), static_cast<int>(of.vertex_count),
                                body->triangles.data(), static_cast<int>(3 * of.triangle_count), 3 * sizeof(dTriIndex));
    body->geometry = dCreateTriMesh(space_, body->data, nullptr, nullptr, nullptr);
    setPose(body->geometry, of.pose);
    stiffness_N_per_m_ = of.stiffness_N_per_m;
    damping_Ns_per_m_ = 2 * std::sqrt(stiffness_N_per_m_ * kMass_kg);  // critical
    bodies_.push_back(std::move(body));
  }

  void collide(dGeomID body) {
    std::array<dContactGeom, 16> places;
    const int count = dCollide(sphere_, body, static_cast<int>(places.size()), places.data(), sizeof(dContactGeom));
    for (int i = 0; i < count; ++i) {
      dContact contact{};
      contact.surface.mu = 0;
      contact.geom = places[static_cast<std::size_t>(i)];
      dJointAttach(dJointCreateContact(world_, joints_, &contact), proxy_, nullptr);
    }
    contacts_ += count;
  }

  dWorldID world_ = dWorldCreate();
  dSpaceID space_ = dSimpleSpaceCreate(nullptr);
  dJointGroupID joints_ = dJointGroupCreate(0);
  dBodyID proxy_ = dBodyCreate(world_);
  dGeomID sphere_ = nullptr;
  std::vector<std::unique_ptr<Body>> bodies_;
  Vec3 lastHip_{0};
  double stiffness_N_per_m_ = 0;
  double damping_Ns_per_m_ = 0;
  int contacts_ = 0;
};

}  // namespace
}  // namespace haptics::eval::peers

const haptics_method_functions* haptics_method() {
  using namespace haptics::eval::peers;
  static const bool begun = dInitODE2(0) != 0;
  (void)begun;
  return functionsOf<World>(HAPTICS_MOVING_BODIES | HAPTICS_OPEN_MESHES | HAPTICS_EDITS, "ode",
                            "ODE " dODE_VERSION ", sphere of 1 mm and 20 g on a spring, 4 kHz");
}
