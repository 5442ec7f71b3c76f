#pragma once

#include <vtkActor.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>

#include <memory>
#include <optional>

#include "common/scene/scene.h"
#include "graphics_client/viewer/look.h"

namespace haptics {

/// Friction coefficients that the colours run over.
struct FrictionRange {
  double least = 0, most = 0;
  bool operator==(const FrictionRange&) const = default;
};

/// One object in the world, with its shadow, and in the close-up, with its polygons' edges.
class ObjectActors {
 public:
  struct Paint {
    Color color;
    bool current = true;  ///< False: grey.
    bool wireframe = false, edges = false;
    std::optional<FrictionRange> friction;  ///< Of all objects.
  };

  ObjectActors(vtkRenderer* world, vtkRenderer* closeUp, std::shared_ptr<const Look> look);
  ~ObjectActors();
  ObjectActors(const ObjectActors&) = delete;
  ObjectActors& operator=(const ObjectActors&) = delete;

  void paint(const Paint& paint);
  void place(vtkMatrix4x4* object, vtkMatrix4x4* shadow);
  void setShadowVisible(bool visible);
  [[nodiscard]] const Look& look() const { return *look_; }

 private:
  vtkRenderer* worldRenderer_;
  vtkRenderer* closeUpRenderer_;
  std::shared_ptr<const Look> look_;
  vtkNew<vtkPolyData> drawn_;  // the look's, with colours of its own
  vtkNew<vtkActor> world_, closeUp_, worldRims_, closeUpRims_;
  vtkSmartPointer<vtkActor> shadow_;
  std::optional<Color> colored_;  // what the points' colours were made of
  std::optional<FrictionRange> coloredRange_;

  void colorPoints(const Paint& paint);
};

}  // namespace haptics
