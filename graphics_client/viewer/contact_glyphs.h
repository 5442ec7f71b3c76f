#pragma once

#include <vtkActor.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <array>
#include <functional>
#include <vector>

#include "common/telemetry/telemetry_sample.h"
#include "graphics_client/mirror/mirror_view.h"
#include "graphics_client/viewer/palette.h"
#include "graphics_client/viewer/render_window.h"
#include "graphics_client/viewer/trail.h"

namespace haptics {

/// One marker in one pane.
class Glyph {
 public:
  enum class Kind {
    kBody,      ///< Solid among the objects, and pale above them so that they cannot hide it.
    kOnObject,  ///< Among the objects only, blended with what is behind it.
    kAbove,     ///< Above them only.
  };

  Glyph(ScenePane& pane, vtkPolyData* shape, Kind kind);

  /// Draws it after everything that was added to the pane so far.
  void drawLast();
  void setShape(vtkPolyData* shape);
  void show(palette::Shade shade, vtkMatrix4x4* place);
  void setLineWidth(float width_px);
  void setOpacity(double opacity);  ///< Of the blended drawing.
  void setVisible(bool visible);

 private:
  ScenePane& pane_;
  vtkSmartPointer<vtkActor> solid_, ghost_;  // either may be missing

  void forEach(const std::function<void(vtkActor*)>& change);
};

struct GlyphSizes {
  double marker_px = 7;       ///< Radius of the HIP's and IHIP's spheres.
  double arrow_mPerN = 0.01;  ///< Length of the force arrow, world metres per newton.
  double arrowRadius_px = 3;  ///< Of the shaft.
};

/// What is drawn of a hand.
struct ShownHand {
  const TelemetrySample* sample = nullptr;  ///< Null: nothing.
  double maxForce_N = 0;                    ///< Of its device; 0: not known.
  const ToolState* tool = nullptr;          ///< Null: it holds none.
};

/// Of a hand: HIP, IHIP, the line between them, the force at the IHIP, friction's sticking point as a pin with a thread to the IHIP,
/// the contacted primitive and the trail; where a tool is held, the points that hold it with their forces, its torque as an
/// arc, and pale where the device has it. In one pane. Markers keep their size on the screen whatever the zoom.
class ContactGlyphs {
 public:
  ContactGlyphs(ScenePane& pane, const GlyphSizes& sizes);

  /// Draws the markers after the objects, over which some are blended: to be called when objects were added.
  void drawLast();

  /// @param metresPerPixel  at the IHIP, by the pane's camera.
  /// @param current         false: everything grey.
  void update(const MirrorView& view, const ShownHand& hand, const Trail& trail, double metresPerPixel, bool current);

 private:
  GlyphSizes sizes_;
  Glyph trail_, primitive_, primitiveOutline_, hip_, ihip_, spring_, thread_, pin_, pinHead_, shaft_, tip_, toolForces_,
      toolPoints_, torque_, toolAtDevice_;  // in this order
  ContentHash toolShape_;                   // drawn by toolAtDevice_
  double toolOpening_rad_ = 0;              // likewise

  [[nodiscard]] std::array<Glyph*, 15> all() {
    return {&trail_, &primitive_, &primitiveOutline_, &hip_,        &ihip_,   &spring_,      &thread_, &pin_, &pinHead_,
            &shaft_, &tip_,       &toolForces_,       &toolPoints_, &torque_, &toolAtDevice_};
  }

  void updateForce(const ShownHand& hand, double metresPerPixel, bool current);
  void updatePin(const TelemetrySample& sample, double metresPerPixel, bool current);
  void updatePrimitive(const MirrorView& view, const TelemetrySample& sample, double metresPerPixel, bool current);
  void updateTool(const ShownHand& hand, double metresPerPixel, bool current);
  void updateToolAtDevice(const MirrorView& view, const ShownHand& hand, bool current);
  void updateTrail(const Trail& trail, bool current);
};

/// What of a polygon, given by its corners, is the contacted primitive: 3 corners of a polygon, 2 of a line, 1 of a vertex;
/// lifted by `lift_m` along the polygon's normal. Empty when there is none, or no such corner.
[[nodiscard]] std::vector<Vec3> primitiveCorners(const std::array<Vec3, 3>& polygon, const PrimitiveId& primitive,
                                                 double lift_m);

}  // namespace haptics
