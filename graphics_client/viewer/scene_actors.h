#pragma once

#include <vtkRenderer.h>

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/scene/scene.h"
#include "graphics_client/mirror/mirror_view.h"
#include "graphics_client/surface/displayed_surface.h"
#include "graphics_client/viewer/floor.h"
#include "graphics_client/viewer/object_actors.h"
#include "graphics_client/viewer/render_mesh_builder.h"

namespace haptics {

/// An object's name, and the corners of the box around it, world frame; bit k of a corner's number: the higher one along
/// the object's axis k.
struct NamedBox {
  std::string name;
  std::array<Vec3, 8> corners;
};

/// World frame.
struct CutPlane {
  Vec3 point{0}, normal{0, 1, 0};  ///< Unit; towards what is kept.
  bool operator==(const CutPlane&) const = default;
};

/// The objects of the scene, in the world and in the close-up, with their shadows and the floor. An object shows its
/// last render mesh until its next one is built.
class SceneActors {
 public:
  SceneActors(vtkRenderer* world, vtkRenderer* closeUp);

  /// Follows the view. `current`: false greys everything. True when objects came, went, were edited or changed shape;
  /// those that move by themselves do so every frame.
  bool update(const MirrorView& view, bool current);
  /// Follows the view, waiting for all that is being made.
  void settle(const MirrorView& view, bool current);
  /// Render meshes are still being built.
  [[nodiscard]] bool isSettling() const;

  /// For all textured objects together. What is shown stays until it is built anew.
  void setMaxTriangles(std::size_t most) { maxTriangles_ = most; }
  void setWireframe(bool on) { paintWith(&ObjectActors::Paint::wireframe, on); }
  void setEdges(bool on) { paintWith(&ObjectActors::Paint::edges, on); }
  /// Colours soft objects by how far they are displaced.
  void setDisplacement(bool on) { paintWith(&ObjectActors::Paint::displacement, on); }
  /// Objects of these names are not drawn, have no box, and leave the floor where it is.
  void hide(std::set<std::string> names);
  /// Draws in the world only what lies beyond the plane; nothing: all.
  void cut(const std::optional<CutPlane>& plane);
  /// Lights fine surfaces at their vertices (vertex_lighting.h).
  void setVertexLighting(bool on) { paintWith(&ObjectActors::Paint::vertexLighting, on); }

  /// Objects of very many triangles are drawn by coarse copies, from the next showFor() on.
  void setCoarse(bool on);
  /// Some object is drawn so.
  [[nodiscard]] bool isCoarse() const;

  /// Points spread over the objects, world frame; empty when nothing is shown.
  [[nodiscard]] std::vector<Vec3> outline() const;
  /// Distance between the floor's grid lines; 0 without a floor.
  [[nodiscard]] double gridSpacing_m() const { return shown_.empty() ? 0 : floor_.spacing_m(); }
  /// World z of the floor.
  [[nodiscard]] double floor_m() const { return floor_.height_m(); }
  /// Leaves out what the cameras cannot see. Shadows are above the floor: hidden when seen from below.
  void showFor(Vec3 worldCamera, Vec3 closeUpCamera);
  /// Over the surfaces whose friction varies; nothing when there are none.
  [[nodiscard]] std::optional<FrictionRange> frictionRange() const { return paint_.friction; }
  /// Of those that are not hidden.
  [[nodiscard]] std::vector<NamedBox> boxes() const;
  /// The name of the smallest whose box holds the place (world, metres), its bumps and dents included; empty: none does.
  [[nodiscard]] std::string objectAt(Vec3 place) const;
  /// The one that is drawn farthest from what is felt.
  [[nodiscard]] std::optional<CoarseDetail> coarsestDetail() const;
  /// Whether there is one that is drawn with pits that are felt as bumps.
  [[nodiscard]] bool anyPitsFeltAsBumps() const;

 private:
  struct Shown {
    SceneVersion::Object record;           ///< As last seen.
    Pose pose;                             ///< Where the servo has it, as last seen.
    SceneVersion::Object ordered;          ///< The record that the last order was for ...
    std::size_t share = 0;                 ///< ... with so many triangles at most.
    SurfaceRequest request;                ///< The last.
    RenderMeshBuilder::Pending pending;    ///< Its render mesh while it is not shown.
    std::unique_ptr<ObjectActors> actors;  ///< Null before the first render mesh.
    std::vector<Dent> dents;               ///< As shown.
  };

  vtkRenderer* worldRenderer_;
  vtkRenderer* closeUpRenderer_;
  Floor floor_;
  RenderMeshBuilder builder_;
  std::map<ObjectId, Shown> shown_;
  std::size_t maxTriangles_ = 0;
  std::set<std::string> hidden_;  // by name: an object that is removed and added again has another id
  ObjectActors::Paint paint_;     ///< For all objects, but for their colour.
  bool coarse_ = false;

  bool follow(Shown& shown, const SceneVersion::Object& object, const MirrorView& view, std::size_t maxTriangles);
  bool takeRenderMesh(Shown& shown);
  static void dent(Shown& shown, const ObjectRecord& object, const MirrorView& view);
  void updateFrictionRange();
  void paintWith(bool ObjectActors::Paint::*how, bool on);
  void paintAll();
  void paint(const Shown& shown) const;
  void place(const Shown& shown) const;
  void placeFloor();
};

}  // namespace haptics
