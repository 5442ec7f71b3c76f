#pragma once

#include <vtkActor.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkPlane.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/scene/scene.h"
#include "graphics_client/viewer/dented_points.h"
#include "graphics_client/viewer/render_mesh.h"

namespace haptics {

/// Friction coefficients that the colours run over.
struct FrictionRange {
  double least = 0, most = 0;
  bool operator==(const FrictionRange&) const = default;
};

/// One object in the world, with its shadow, and in the close-up, with its polygons' edges where they are few.
class ObjectActors {
 public:
  struct Paint {
    Color color;
    bool current = true;  ///< False: grey.
    bool wireframe = false, edges = false;
    std::optional<FrictionRange> friction;  ///< Of all objects.
    bool displacement = false;              ///< Of a soft object: coloured by how far its points are displaced.
    bool vertexLighting = false;            ///< Where the triangles are fine.
    bool hidden = false;                    ///< From the next showFor() on.
    vtkSmartPointer<vtkPlane> cut = {};     ///< World frame: only what its normal points to is drawn; null: all.
  };

  ObjectActors(vtkRenderer* world, vtkRenderer* closeUp, std::shared_ptr<const RenderMesh> renderMesh);
  ~ObjectActors();
  ObjectActors(const ObjectActors&) = delete;
  ObjectActors& operator=(const ObjectActors&) = delete;

  void paint(const Paint& paint);
  void place(vtkMatrix4x4* object, vtkMatrix4x4* shadow);
  void setShadowVisible(bool visible) { shadow_->SetVisibility(visible && !hidden_); }
  /// Shows a soft object with these dents. Its shadow stays that of the shape at rest: it would have to be drawn anew in every
  /// frame, for a few pixels of its outline.
  void dent(std::span<const Dent> dents, const Falloff& falloff);
  /// Shows a tool's jaws open so far: the mesh, not its shadow, nor the coarse copy.
  void open(const JawProperties& jaws, double opening_rad);
  /// The coarse copy in place of the mesh in the world, where there is one; from the next showFor() on.
  void setCoarse(bool on) { isCoarse_ = on && coarse_; }
  /// Leaves out what cannot be seen by the world's and the close-up's camera; object frame.
  void showFor(Vec3 worldEye, Vec3 closeUpEye);
  [[nodiscard]] const RenderMesh& renderMesh() const { return *renderMesh_; }

 private:
  vtkRenderer* worldRenderer_;
  vtkRenderer* closeUpRenderer_;
  std::shared_ptr<const RenderMesh> renderMesh_;
  /// Actors of one piece of the render mesh.
  struct Part {
    vtkNew<vtkPolyData> drawn;  // the render mesh's, with colours of its own
    vtkNew<vtkActor> world, closeUp;
    std::unique_ptr<DentedPoints> dented;  // null until a dent reaches it
    bool isDented = false;                 // now
  };
  std::vector<Part> parts_;
  vtkNew<vtkActor> rims_;
  vtkSmartPointer<vtkActor> shadow_, coarse_;  // there may be no coarse one
  bool hidden_ = false, cut_ = false, isCoarse_ = false;
  std::unique_ptr<DentedPoints> dentedRims_;      // likewise
  std::optional<palette::Shade> displacementOn_;  // coloured by displacement, over this
  std::optional<Color> colored_;                  // what the points' colours were made of
  std::optional<FrictionRange> coloredRange_;

  void colorPoints(const Paint& paint);
  void dentRims(std::span<const Dent> dents, const Falloff& falloff);
  [[nodiscard]] vtkPolyData* ownRims();
  void giveOwnPoints(Part& part);
  void dent(Part& part, std::span<const Dent> dents, const Falloff& falloff);
  void colorDisplacement(Part& part) const { part.dented->colorIn(part.drawn, *displacementOn_); }
};

}  // namespace haptics
