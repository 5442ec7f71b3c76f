#pragma once

#include <vtkActor.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>

#include <string>

#include "common/maths/vec.h"

namespace haptics {

/// A plate below the objects with a grid that gives the scale, and on it the shadows of the key light.
class Floor {
 public:
  explicit Floor(vtkRenderer* renderer);

  /// Puts the plate at the bottom of the box (world frame) and makes it large enough for everything in it.
  void placeUnder(Vec3 boxMin, Vec3 boxMax);
  void hide();

  /// World to world: flattens onto the plate, along the key light.
  [[nodiscard]] vtkSmartPointer<vtkMatrix4x4> shadowMatrix() const;
  [[nodiscard]] double height_m() const { return height_m_; }
  /// Distance between the grid's lines; 0 before anything was placed.
  [[nodiscard]] double spacing_m() const { return spacing_m_; }

 private:
  vtkNew<vtkActor> plate_, lines_, boldLines_;
  double height_m_ = 0;
  double spacing_m_ = 0;
  double lift_m_ = 0;  // of the shadow above the plate, and of the grid above the shadow
};

/// A shadow-coloured drawing of the same mesh, to be given Floor::shadowMatrix() * the object's matrix.
[[nodiscard]] vtkSmartPointer<vtkActor> makeShadow(vtkPolyData* mesh);

/// "1 cm", "10 cm", "1 m".
[[nodiscard]] std::string lengthText(double length_m);

}  // namespace haptics
