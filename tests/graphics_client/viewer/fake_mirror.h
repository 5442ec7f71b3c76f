#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/mesh/mesh_asset.h"
#include "common/mesh/tri_mesh.h"
#include "graphics_client/mirror/mirror_view.h"

namespace haptics {

/// A client's view without a server: objects on a floor, and a contact with one of them.
class FakeMirror {
 public:
  FakeMirror() {
    view_.link = LinkState::kLive;
    view_.serverName = "test server";
    view_.device = "simulated omni, nominal hand";
    view_.maxForce_N = 3.3;
    view_.hashesEqual = true;
  }

  ObjectId add(const std::string& name, const TriMesh& mesh, const Pose& pose, Color color) {
    ObjectRecord record;
    record.id = objects_.size() + 1;
    record.name = name;
    record.revision = 1;
    record.mesh = hashOf(mesh);
    record.pose = pose;
    record.material.color = color;
    view_.meshes[record.mesh] = std::make_shared<const TriMesh>(mesh);
    objects_.push_back(record);
    publish();
    return record.id;
  }

  void setSurface(ObjectId object, const SurfaceProperties& surface) {
    objects_[object - 1].material.surface = surface;
    publish();
  }

  void setMotion(ObjectId object, const MotionProperties& motion) {
    objects_[object - 1].motion = motion;
    publish();
  }

  void setEffects(ObjectId object, const std::vector<Effect>& effects) {
    objects_[object - 1].effects = effects;
    publish();
  }

  void setSoftness(ObjectId object, const Softness& softness) {
    objects_[object - 1].deformation.softness = softness;
    publish();
  }

  /// Presses by `depth_m` on the polygon's centre, with 800 N/m.
  void touch(ObjectId object, std::uint32_t polygon, double depth_m) {
    constexpr double kStiffness_N_per_m = 800;
    const ObjectRecord& record = objects_[object - 1];
    const TriMesh& mesh = *view_.meshes.at(record.mesh);
    const TriangleIndices& t = mesh.triangles[polygon];
    const Vec3 a(mesh.vertices[t[0]]), b(mesh.vertices[t[1]]), c(mesh.vertices[t[2]]);
    const Vec3 normal = record.pose.rotation * glm::normalize(glm::cross(b - a, c - a));
    TelemetrySample sample = view_.sample.value_or(TelemetrySample{});
    ++sample.tick;
    sample.servoRate_Hz = 1000;
    sample.sceneRevision = 1;
    sample.object = object;
    sample.primitive = {.kind = PrimitiveKind::kPolygon, .localIndex = 0, .polygon = polygon};
    sample.ihip = toWorld(record.pose, (a + b + c) / 3.0);
    sample.hip = sample.ihip - normal * depth_m;
    sample.penetration_m = depth_m;
    sample.surfaceNormal = normal;
    sample.force.contact = sample.force.spring = sample.force.written = normal * (kStiffness_N_per_m * depth_m);
    view_.sample = sample;
  }

  [[nodiscard]] MirrorView& view() { return view_; }
  [[nodiscard]] std::shared_ptr<const MirrorView> now() const { return std::make_shared<const MirrorView>(view_); }

 private:
  MirrorView view_;
  std::vector<ObjectRecord> objects_;

  void publish() {
    view_.scene = std::make_shared<const SceneVersion>(SceneVersion::fromSnapshot(1, objects_).value());
    view_.serverRoot = view_.scene->root();
    view_.serverRevision = 1;
  }
};

}  // namespace haptics
