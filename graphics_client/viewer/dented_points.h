#pragma once

#include <vtkFloatArray.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>
#include <vtkUnsignedCharArray.h>

#include <cstddef>
#include <span>
#include <vector>

#include "common/deform/dent.h"
#include "common/scene/motion_properties.h"
#include "graphics_client/viewer/palette.h"

namespace haptics {

/// Stores how far a texture raises each point above the geometric surface, which the dents move; none: all are on it.
void addRises(vtkPolyData* data, std::span<const Vec3f> rises);

/// The points and normals of a soft object as its dents have them: by the function that the servo uses, on the same
/// numbers. Object frame. Only points that a dent reaches, or did until now, are computed.
class DentedPoints {
 public:
  /// A copy of the data's points, normals and rises, which are those at rest.
  explicit DentedPoints(vtkPolyData* atRest);

  /// Shows these in place of its own.
  void drawIn(vtkPolyData* data) const;
  /// Goes over to other dents of the object. True when that changed something.
  bool follow(std::span<const Dent> dents, const Falloff& falloff);
  /// Turns those of a tool's jaws, which has no dents. True when that changed something.
  bool open(const JawProperties& jaws, double opening_rad);
  /// A colour for each point, by how far it is displaced.
  void colorIn(vtkPolyData* data, palette::Shade own);

 private:
  std::vector<Vec3f> restPoints_, restNormals_, rises_;  // the last: none of a plain object
  vtkSmartPointer<vtkPoints> points_;
  vtkSmartPointer<vtkFloatArray> normals_;  // null for a faceted object
  vtkSmartPointer<vtkUnsignedCharArray> colors_;
  std::vector<Dent> dents_;
  double deepest_m_ = 0;  // that they may be
  double opening_rad_ = 0;

  /// Below what the texture raises, at rest.
  [[nodiscard]] Vec3f onSurface(std::size_t point) const {
    return rises_.empty() ? restPoints_[point] : restPoints_[point] - rises_[point];
  }
  void move(std::size_t point, const Falloff& falloff);
  void noteChange();
};

}  // namespace haptics
