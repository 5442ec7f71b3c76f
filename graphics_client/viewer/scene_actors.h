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

/// The objects of the scene, in the world and in the close-up, with their shadows and the floor. A mesh is prepared once
/// for its hash, whatever happens to the objects that show it.
class SceneActors {
 public:
  SceneActors(vtkRenderer* world, vtkRenderer* closeUp);

  /// Follows the view. `current`: false greys everything. True when objects came, went, moved or changed shape.
  bool update(const MirrorView& view, bool current);

  void setWireframe(bool on);
  void setEdges(bool on);

  /// Corners of the objects' boxes, world frame; empty when nothing is shown.
  [[nodiscard]] std::vector<Vec3> corners() const;
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

  vtkRenderer* worldRenderer_;
  vtkRenderer* closeUpRenderer_;
  Floor floor_;
  std::map<ContentHash, vtkSmartPointer<vtkPolyData>> prepared_;
  std::map<ObjectId, Shown> shown_;
  bool current_ = true, wireframe_ = false, edges_ = false;

  [[nodiscard]] Shown make(const ObjectRecord& object, vtkPolyData* data);
  void remove(const Shown& shown);
  void paint(Shown& shown) const;
  void place(Shown& shown) const;
  void placeFloor();
};

}  // namespace haptics
