#include "graphics_client/viewer/gizmo_glyphs.h"

#include <cmath>
#include <numbers>
#include <vector>

#include "graphics_client/viewer/poly_data.h"

namespace haptics {
namespace {

constexpr int kDrawnPieces = 64;
constexpr float kRingLine_px = 3;
constexpr double kShaft_px = 2, kTipLength_px = 20, kTipRadius_px = 7;

/// About the x axis, radius 1.
vtkSmartPointer<vtkPolyData> unitRing() {
  std::vector<Vec3> ends;
  for (int i = 0; i < kDrawnPieces; ++i) {
    for (const int end : {i, i + 1}) {
      const double angle = 2 * std::numbers::pi * end / kDrawnPieces;
      ends.emplace_back(0, std::cos(angle), std::sin(angle));
    }
  }
  return segments(ends);
}

}  // namespace

GizmoGlyphs::Axis::Axis(ScenePane& pane)
    : ring(pane, unitRing(), Glyph::Kind::kAbove),
      shaft(pane, unitCylinder(), Glyph::Kind::kAbove),
      tip(pane, unitCone(), Glyph::Kind::kAbove) {
  ring.setLineWidth(kRingLine_px);
}

GizmoGlyphs::GizmoGlyphs(ScenePane& pane)
    : axes_{Axis(pane), Axis(pane), Axis(pane)}, direction_(pane, unitCylinder(), Glyph::Kind::kAbove) {
  update(std::nullopt, {});
}

void GizmoGlyphs::update(const std::optional<GizmoPicture>& picture, const PictureCamera& camera) {
  for (Axis& axis : axes_) {
    for (Glyph* glyph : {&axis.ring, &axis.shaft, &axis.tip}) glyph->setVisible(false);
  }
  direction_.setVisible(false);
  if (!picture) return;
  const Gizmo gizmo(camera, picture->centre, picture->handles);
  const double pixel_m = gizmo.metresPerPixel();
  if (picture->direction) {
    const double half_m = Gizmo::kArrow_px * pixel_m;
    direction_.show(palette::kSelected, alongAxis(picture->centre - half_m * *picture->direction, *picture->direction,
                                                  2 * half_m, kShaft_px * pixel_m));
  }
  for (int i = 0; i < 3; ++i) {
    Axis& axis = axes_[static_cast<std::size_t>(i)];
    Vec3 along(0);
    along[i] = 1;
    const GizmoHandle move{GizmoHandle::Kind::kMove, i}, turn{GizmoHandle::Kind::kTurn, i};
    const auto shade = [&](const GizmoHandle& handle) {
      return picture->lit == handle ? palette::kLitHandle : palette::kAxes[static_cast<std::size_t>(i)];
    };
    if (gizmo.isShown(turn)) {
      const double radius = Gizmo::kRing_px * pixel_m;
      axis.ring.show(shade(turn), alongAxis(picture->centre, along, radius, radius));
    }
    if (!gizmo.isShown(move)) continue;
    constexpr double kNeck_px = Gizmo::kArrow_px - kTipLength_px;
    axis.shaft.show(shade(move), alongAxis(picture->centre + along * (Gizmo::kArrowStart_px * pixel_m), along,
                                           (kNeck_px - Gizmo::kArrowStart_px) * pixel_m, kShaft_px * pixel_m));
    axis.tip.show(shade(move), alongAxis(picture->centre + along * (kNeck_px * pixel_m), along, kTipLength_px * pixel_m,
                                         kTipRadius_px * pixel_m));
  }
}

}  // namespace haptics
