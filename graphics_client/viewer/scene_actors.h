#pragma once

#include <vtkActor.h>
#include <vtkPolyData.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>

#include <map>
#include <vector>

#include "common/scene/scene.h"
#include "graphics_client/mirror/mirror_view.h"
#include "graphics_client/viewer/floor.h"

namespace haptics {

/// The objects of the scene, in the world and in the close-up, with their shadows and the floor. A mesh is prepared
/// once for its hash, whatever happens to the objects that show it.
class SceneActors {
 public:
  SceneActors(vtkRenderer* world, vtkRenderer* closeUp);

  /// Follows the view. `current`: false greys everything. True when objects came, went, moved or changed shape.
  bool update(const MirrorView& view, bool current);

  void setWireframe(bool on);
  void setEdges(bool on);

  /// Points spread over the objects, world frame; empty when nothing is shown.
  [[nodiscard]] std::vector<Vec3> outline() const;
  /// Distance between the floor's grid lines; 0 without a floor.
  [[nodiscard]] double gridSpacing_m() const { return shown_.empty() ? 0 : floor_.spacing_m(); }
  /// Shadows are above the floor: hidden when seen from below.
  void setSeenFromAbove(const Vec3& camera);

 private:
  struct Shown {
    ContentHash mesh;
    Pose pose;
    Color color;
    vtkSmartPointer<vtkActor> world, closeUp, shadow;
  };

  struct Prepared {
    vtkSmartPointer<vtkPolyData> data;
    bool closed = false;
    std::vector<Vec3> outline;  ///< Some of the vertices, the extreme ones among them; object frame.
  };

  vtkRenderer* worldRenderer_;
  vtkRenderer* closeUpRenderer_;
  Floor floor_;
  std::map<ContentHash, Prepared> prepared_;
  std::map<ObjectId, Shown> shown_;
  bool current_ = true, wireframe_ = false, edges_ = false;

  [[nodiscard]] static Prepared prepare(const TriMesh& mesh);
  [[nodiscard]] Shown make(const ObjectRecord& object, const Prepared& prepared);
  void remove(const Shown& shown);
  void paint(Shown& shown) const;
  void place(Shown& shown) const;
  void placeFloor();
};

}  // namespace haptics
