#pragma once

#include <iterator>
#include <list>
#include <memory>
#include <utility>
#include <vector>

#include "haptic_server/engine/geometry/spaced_points.h"
#include "haptic_server/engine/tool/tool_contact.h"

namespace haptics {

inline Body bodyOf(const std::shared_ptr<const CollisionMesh>& surface, const Pose& pose = {}) {
  Body body;
  body.surface = surface.get();
  body.previous = body.current = pose;
  body.update();
  return body;
}

inline std::shared_ptr<const CollisionMesh> surfaceOf(const TriMesh& mesh) {
  return buildCollisionMesh(mesh.vertices, mesh.triangles);
}

inline Tool toolOf(const TriMesh& mesh, double spacing_m) {
  auto surface = surfaceOf(mesh);
  ToolShell shell = makeToolShell(*surface, spacing_m).value();
  return {std::move(surface), std::move(shell)};
}

/// A tool among bodies, with what it refers to.
class HeldAmong : public StandaloneTool {
 public:
  HeldAmong(Tool tool, double spacing_m, const std::vector<Body>& bodies) : tool_(std::move(tool)) {
    hold(tool_);
    std::vector<Obstacle> obstacles;
    for (const Body& body : bodies) {
      sharp_.push_back(sharpPoints(*body.surface, spacing_m, kMaxToolPoints));
      obstacles.push_back({body.current, sharp_.back(), -1});
    }
    adopt(obstacles);
  }
  HeldAmong(const TriMesh& mesh, double spacing_m, const std::vector<Body>& bodies)
      : HeldAmong(toolOf(mesh, spacing_m), spacing_m, bodies) {}
  HeldAmong(const HeldAmong&) = delete;
  HeldAmong& operator=(const HeldAmong&) = delete;

  [[nodiscard]] const Tool& tool() const { return tool_; }
  /// Of a body.
  [[nodiscard]] const std::vector<Vec3>& sharp(std::size_t body) const {
    return *std::next(sharp_.begin(), static_cast<std::ptrdiff_t>(body));
  }

 private:
  Tool tool_;
  std::list<std::vector<Vec3>> sharp_;
};

}  // namespace haptics
