#include "graphics_client/viewer/floor.h"

#include <vtkMatrix4x4.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "graphics_client/viewer/palette.h"
#include "graphics_client/viewer/poly_data.h"
#include "graphics_client/viewer/render_window.h"

namespace haptics {
namespace {

/// The plate goes this far beyond the objects, as a share of their larger side.
constexpr double kMarginShare = 0.12;
/// The grid's spacing is the smallest power of ten in metres that gives at most this many lines along the longer side.
constexpr double kMaxLines = 80;
/// Every tenth line is bold; where the plate has fewer than this many of them, every fifth.
constexpr double kFewBoldLines = 4;
/// Lift of shadow and grid as a share of the plate: enough for the depth buffer, too little to see.
constexpr double kLiftShare = 3e-4;
/// Shadows keep this share of their height, so that their matrix can be inverted.
constexpr double kShadowFlatness = 1e-4;

void setFlat(vtkActor* actor, palette::Shade shade) {
  actor->GetProperty()->LightingOff();
  actor->GetProperty()->SetColor(shade.red, shade.green, shade.blue);
}

void setData(vtkActor* actor, vtkPolyData* data) {
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(data);
  actor->SetMapper(mapper);
  actor->SetVisibility(true);
}

}  // namespace

Floor::Floor(vtkRenderer* renderer) {
  setFlat(plate_, palette::kFloor);
  setFlat(lines_, palette::kFloorLine);
  setFlat(boldLines_, palette::kFloorBoldLine);
  plate_->GetProperty()->BackfaceCullingOn();  // seen from below, the plate is glass
  for (vtkActor* actor : {plate_.Get(), lines_.Get(), boldLines_.Get()}) {
    actor->SetPickable(false);
    actor->SetVisibility(false);
    renderer->AddActor(actor);
  }
}

void Floor::hide() {
  for (vtkActor* actor : {plate_.Get(), lines_.Get(), boldLines_.Get()}) actor->SetVisibility(false);
}

void Floor::placeUnder(Vec3 boxMin, Vec3 boxMax) {
  const Vec3 light = keyLightDirection();
  const double drop = boxMax.z - boxMin.z;
  for (int axis = 0; axis < 2; ++axis) {  // room for the shadows
    const double shadow = -light[axis] / light.z * drop;
    (shadow < 0 ? boxMin : boxMax)[axis] += 0.6 * shadow;
  }
  const double side = std::max({boxMax.x - boxMin.x, boxMax.y - boxMin.y, drop});
  const double margin = kMarginShare * side;
  spacing_m_ = std::pow(10, std::ceil(std::log10((side + 2 * margin) / kMaxLines)));
  const double boldEvery = (side + 2 * margin) / (10 * spacing_m_) < kFewBoldLines ? 5 : 10;
  const double step = boldEvery * spacing_m_;
  height_m_ = boxMin.z;
  lift_m_ = kLiftShare * side;
  const double left = std::floor((boxMin.x - margin) / step) * step,
               right = std::ceil((boxMax.x + margin) / step) * step;
  const double front = std::floor((boxMin.y - margin) / step) * step,
               back = std::ceil((boxMax.y + margin) / step) * step;

  const double grid = height_m_ + 2 * lift_m_;
  std::vector<Vec3> fine, bold;
  for (double i = std::round(left / spacing_m_); i <= std::round(right / spacing_m_); ++i) {
    auto& lines = std::fmod(i, boldEvery) == 0 ? bold : fine;
    lines.insert(lines.end(), {{i * spacing_m_, front, grid}, {i * spacing_m_, back, grid}});
  }
  for (double i = std::round(front / spacing_m_); i <= std::round(back / spacing_m_); ++i) {
    auto& lines = std::fmod(i, boldEvery) == 0 ? bold : fine;
    lines.insert(lines.end(), {{left, i * spacing_m_, grid}, {right, i * spacing_m_, grid}});
  }
  const Vec3 corners[] = {
      {left, front, height_m_}, {right, front, height_m_}, {right, back, height_m_}, {left, back, height_m_}};
  setData(plate_, polygon(corners));
  setData(lines_, segments(fine));
  setData(boldLines_, segments(bold));
}

vtkSmartPointer<vtkMatrix4x4> Floor::shadowMatrix() const {
  const Vec3 light = keyLightDirection();
  const double target = height_m_ + lift_m_;
  vtkNew<vtkMatrix4x4> matrix;
  for (int axis = 0; axis < 2; ++axis) {
    const double slope = -light[axis] / light.z;
    matrix->SetElement(axis, 2, slope);
    matrix->SetElement(axis, 3, -slope * target);
  }
  matrix->SetElement(2, 2, kShadowFlatness);
  matrix->SetElement(2, 3, target - kShadowFlatness * height_m_);
  return matrix;
}

vtkSmartPointer<vtkActor> makeShadow(vtkPolyData* mesh) {
  vtkNew<vtkActor> actor;
  setData(actor, mesh);
  setFlat(actor, palette::kShadow);
  actor->GetProperty()->BackfaceCullingOn();  // the side that faces the light casts the same shadow as both
  actor->SetPickable(false);
  return actor;
}

std::string lengthText(double length_m) {
  char text[32];
  if (length_m >= 1) {
    std::snprintf(text, sizeof text, "%g m", length_m);
  } else if (length_m >= 0.01) {
    std::snprintf(text, sizeof text, "%g cm", std::round(length_m * 1e2));
  } else {
    std::snprintf(text, sizeof text, "%g mm", length_m * 1e3);
  }
  return text;
}

}  // namespace haptics
