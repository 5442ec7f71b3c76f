#include "graphics_client/viewer/contact_glyphs.h"

#include <vtkMatrix4x4.h>
#include <vtkPointData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <cmath>

#include "graphics_client/viewer/poly_data.h"

namespace haptics {
namespace {

/// How much of the pale drawing above the objects is seen.
constexpr double kGhostOpacity = 0.65;
/// Opacity of what stands on the surface rather than in the object: hidden only by the object's other side.
constexpr double kOnTopOpacity = 0.9;
/// Opacity of the contacted polygon's face: the surface is seen through it.
constexpr double kPrimitiveOpacity = 0.6;
/// And of the tool where the device has it.
constexpr double kToolAtDeviceOpacity = 0.25;
/// Weaker forces show no arrow (newtons): below what a hand can feel, its direction is noise.
constexpr double kSmallestArrow_N = 0.03;
/// The arrow tip's length and radius in shaft radii. A short arrow is all tip.
constexpr double kTipLength = 6, kTipRadius = 2.6;
/// Full colour when the server told no limit (newtons).
constexpr double kFullScale_N = 5;
constexpr double kPrimitiveLift_px = 1.2;
/// A polygon with a longer side is drawn as its outline: its face would hide the surface (pixels).
constexpr double kLargePolygon_px = 60;
constexpr float kPolygonOutline_px = 2, kPrimitiveLine_px = 5, kVertexPoint_px = 11, kTrailLine_px = 2.5F,
                kSpringLine_px = 2.5F, kToolForce_px = 4, kToolPoint_px = 9, kTorque_px = 4;
/// The arc of a torque: its radius, and how far round it goes (a full turn at most, less its head).
constexpr double kArc_px = 42, kArc_radPerNm = 30, kLongestArc_rad = 5.5;
/// Smaller torques show no arc, Nm.
constexpr double kSmallestArc_Nm = 1e-3;
/// The pin at the sticking point: its length, and the radii of its needle, head and thread (pixels).
constexpr double kPin_px = 26, kNeedle_px = 1.2, kPinHead_px = 4.5, kThread_px = 1;

palette::Shade shadeIf(bool current, palette::Shade shade) { return current ? shade : palette::kFaded; }

/// A cylinder's glyph from one place to another; not where they are one.
void show(Glyph& glyph, Vec3 from, Vec3 to, double radius, palette::Shade shade) {
  const double length = glm::distance(from, to);
  if (length > 0) glyph.show(shade, alongAxis(from, (to - from) / length, length, radius));
}

/// Pairs of ends of an arc about an axis, with a head at its end, as far as the angle.
std::vector<Vec3> arcAround(Vec3 centre, Vec3 axis, double radius, double angle_rad) {
  constexpr int kPieces = 32;
  constexpr double kHead = 0.22;  // of the radius
  const Vec3 beside = std::abs(axis.z) < 0.9 ? Vec3(0, 0, 1) : Vec3(1, 0, 0);
  const Vec3 x = glm::normalize(glm::cross(axis, beside)), y = glm::cross(axis, x);
  const auto at = [&](double angle, double of) { return centre + of * (std::cos(angle) * x + std::sin(angle) * y); };
  std::vector<Vec3> ends;
  for (int i = 0; i < kPieces; ++i)
    ends.insert(ends.end(), {at(angle_rad * i / kPieces, radius), at(angle_rad * (i + 1) / kPieces, radius)});
  const double before = angle_rad - kHead;
  for (const double beyond : {1 - kHead, 1 + kHead})
    ends.insert(ends.end(), {at(angle_rad, radius), at(before, beyond * radius)});
  return ends;
}

vtkSmartPointer<vtkMatrix4x4> ball(Vec3 centre, double radius) { return alongAxis(centre, {1, 0, 0}, radius, radius); }

}  // namespace

Glyph::Glyph(ScenePane& pane, vtkPolyData* shape, Kind kind) : pane_(pane) {
  if (kind != Kind::kAbove) solid_ = vtkSmartPointer<vtkActor>::New();
  if (kind != Kind::kOnObject) ghost_ = vtkSmartPointer<vtkActor>::New();
  forEach([&](vtkActor* actor) {
    actor->SetMapper(vtkNew<vtkPolyDataMapper>());
    actor->SetPickable(false);
    actor->ForceOpaqueOn();  // plain blending: VTK's order-independent pass costs a whole window in software
    actor->GetProperty()->SetLighting(kind == Kind::kBody);
    actor->GetProperty()->SetAmbient(0.45);
    actor->GetProperty()->SetDiffuse(0.65);
  });
  setShape(shape);
  if (kind == Kind::kBody) setOpacity(kGhostOpacity);
  if (ghost_) pane.ghost->AddActor(ghost_);
  drawLast();
}

void Glyph::forEach(const std::function<void(vtkActor*)>& change) {
  for (vtkActor* actor : {solid_.Get(), ghost_.Get()}) {
    if (actor) change(actor);
  }
}

void Glyph::drawLast() {
  if (!solid_) return;
  pane_.solid->RemoveActor(solid_);
  pane_.solid->AddActor(solid_);
}

void Glyph::setOpacity(double opacity) { (ghost_ ? ghost_ : solid_)->GetProperty()->SetOpacity(opacity); }

void Glyph::setShape(vtkPolyData* shape) {
  forEach([&](vtkActor* actor) { static_cast<vtkPolyDataMapper*>(actor->GetMapper())->SetInputData(shape); });
}

void Glyph::show(palette::Shade shade, vtkMatrix4x4* place) {
  forEach([&](vtkActor* actor) {
    actor->GetProperty()->SetColor(shade.red, shade.green, shade.blue);
    actor->SetUserMatrix(place);
    actor->SetVisibility(true);
  });
}

void Glyph::setLineWidth(float width_px) {
  forEach([&](vtkActor* actor) {
    actor->GetProperty()->SetLineWidth(width_px);
    actor->GetProperty()->SetPointSize(width_px);
  });
}

void Glyph::setVisible(bool visible) {
  forEach([&](vtkActor* actor) { actor->SetVisibility(visible); });
}

ContactGlyphs::ContactGlyphs(ScenePane& pane, const GlyphSizes& sizes)
    : sizes_(sizes),
      trail_(pane, vtkNew<vtkPolyData>(), Glyph::Kind::kAbove),
      primitive_(pane, vtkNew<vtkPolyData>(), Glyph::Kind::kOnObject),
      primitiveOutline_(pane, vtkNew<vtkPolyData>(), Glyph::Kind::kOnObject),
      hip_(pane, unitSphere(), Glyph::Kind::kBody),
      ihip_(pane, unitSphere(), Glyph::Kind::kBody),
      spring_(pane, unitCylinder(), Glyph::Kind::kBody),
      thread_(pane, unitCylinder(), Glyph::Kind::kBody),
      pin_(pane, unitCylinder(), Glyph::Kind::kBody),
      pinHead_(pane, unitSphere(), Glyph::Kind::kBody),
      shaft_(pane, unitCylinder(), Glyph::Kind::kBody),
      tip_(pane, unitCone(), Glyph::Kind::kBody),
      toolForces_(pane, vtkNew<vtkPolyData>(), Glyph::Kind::kAbove),
      toolPoints_(pane, vtkNew<vtkPolyData>(), Glyph::Kind::kAbove),
      torque_(pane, vtkNew<vtkPolyData>(), Glyph::Kind::kAbove),
      toolAtDevice_(pane, vtkNew<vtkPolyData>(), Glyph::Kind::kOnObject) {
  trail_.setLineWidth(kTrailLine_px);
  toolForces_.setLineWidth(kToolForce_px);
  toolPoints_.setLineWidth(kToolPoint_px);
  torque_.setLineWidth(kTorque_px);
  toolAtDevice_.setOpacity(kToolAtDeviceOpacity);
  primitive_.setOpacity(kPrimitiveOpacity);
  ihip_.setOpacity(kOnTopOpacity);
  for (Glyph* glyph : {&thread_, &pin_, &pinHead_, &shaft_, &tip_}) glyph->setOpacity(kOnTopOpacity);
}

void ContactGlyphs::drawLast() {
  for (Glyph* glyph : all()) glyph->drawLast();
}

void ContactGlyphs::update(const MirrorView& view, const ShownHand& hand, const Trail& trail, double metresPerPixel,
                           bool current) {
  for (Glyph* glyph : all()) glyph->setVisible(false);
  if (hand.sample == nullptr) return;
  const TelemetrySample& sample = *hand.sample;
  const double radius = sizes_.marker_px * metresPerPixel;
  hip_.show(shadeIf(current, palette::kHip), ball(sample.hip, radius));
  if (sample.object != 0) ihip_.show(shadeIf(current, palette::kIhip), ball(sample.ihip, radius));
  show(spring_, sample.hip, sample.ihip, kSpringLine_px / 2 * metresPerPixel, shadeIf(current, palette::kSpring));
  updatePin(sample, metresPerPixel, current);
  updateForce(hand, metresPerPixel, current);
  updatePrimitive(view, sample, metresPerPixel, current);
  if (hand.tool != nullptr) {
    updateToolAtDevice(view, hand, current);
    updateTool(hand, metresPerPixel, current);
  }
  updateTrail(trail, current);
}

void ContactGlyphs::updateForce(const ShownHand& hand, double metresPerPixel, bool current) {
  const Vec3 force = hand.sample->force.written;
  const double force_N = glm::length(force);
  if (!(force_N > kSmallestArrow_N)) return;
  const double share = force_N / (hand.maxForce_N > 0 ? hand.maxForce_N : kFullScale_N);
  const palette::Shade shade = shadeIf(current, palette::forceShade(std::min(share, 1.0)));
  const double length = sizes_.arrow_mPerN * force_N;
  const double radius = sizes_.arrowRadius_px * metresPerPixel;
  const double tipLength = std::min(kTipLength * radius, length);
  const Vec3 axis = force / force_N, start = hand.sample->ihip;
  tip_.show(shade, alongAxis(start + axis * (length - tipLength), axis, tipLength, kTipRadius * radius));
  if (length > tipLength) shaft_.show(shade, alongAxis(start, axis, length - tipLength, radius));
}

void ContactGlyphs::updatePin(const TelemetrySample& sample, double metresPerPixel, bool current) {
  if (sample.frictionState == FrictionState::kNone) return;
  const bool sticking = sample.frictionState == FrictionState::kSticking;
  const palette::Shade shade = shadeIf(current, sticking ? palette::kSticking : palette::kSliding);
  const Vec3 head = sample.stickingPoint + sample.surfaceNormal * (kPin_px * metresPerPixel);
  show(pin_, sample.stickingPoint, head, kNeedle_px * metresPerPixel, shadeIf(current, palette::kSpring));
  show(thread_, sample.stickingPoint, sample.ihip, kThread_px * metresPerPixel, shade);
  pinHead_.show(shade, ball(head, kPinHead_px * metresPerPixel));
}

void ContactGlyphs::updatePrimitive(const MirrorView& view, const TelemetrySample& sample, double metresPerPixel,
                                    bool current) {
  const PrimitiveId& primitive = sample.primitive;
  const SceneVersion::Object object = view.scene->find(sample.object);
  if (!object || primitive.kind == PrimitiveKind::kNone) return;
  const auto triangle = view.cornersOf(*object, primitive.polygon);
  if (!triangle) return;
  const bool textured = object->material.surface.texture.has_value();
  const double lift = kPrimitiveLift_px * metresPerPixel + std::max(sample.height_m, 0.0);
  std::vector<Vec3> corners = primitiveCorners(*triangle, primitive, lift);
  if (corners.empty()) return;
  const vtkSmartPointer<vtkMatrix4x4> place = matrixOf(view.poseOf(*object));
  const palette::Shade shade = shadeIf(current, palette::kPrimitive);
  if (corners.size() == 3) {
    primitive_.setShape(polygon(corners));
    const double side_m = std::max({glm::distance(corners[0], corners[1]), glm::distance(corners[1], corners[2]),
                                    glm::distance(corners[2], corners[0])});
    const bool isLarge = side_m > kLargePolygon_px * metresPerPixel;
    if (!textured && !isLarge) primitive_.show(shade, place);  // its face would cut through the bumps
    corners = {corners[0], corners[1], corners[1], corners[2], corners[2], corners[0]};
  }
  primitiveOutline_.setShape(corners.size() == 1 ? vertices(corners) : segments(corners));
  primitiveOutline_.setLineWidth(corners.size() == 1   ? kVertexPoint_px
                                 : corners.size() == 2 ? kPrimitiveLine_px
                                                       : kPolygonOutline_px);
  primitiveOutline_.show(shade, place);
}

void ContactGlyphs::updateTool(const ShownHand& hand, double metresPerPixel, bool current) {
  const ToolState& tool = *hand.tool;
  std::vector<Vec3> places, lines;
  for (const ToolState::Point& point : tool.points()) {
    places.push_back(point.place);
    lines.insert(lines.end(), {point.place, point.place + sizes_.arrow_mPerN * point.force_N});
  }
  const vtkSmartPointer<vtkMatrix4x4> asItIs = matrixOf({});
  if (!places.empty()) {
    toolPoints_.setShape(vertices(places));
    toolPoints_.show(shadeIf(current, palette::kPrimitive), asItIs);
    toolForces_.setShape(segments(lines));
    toolForces_.show(shadeIf(current, palette::kSpring), asItIs);
  }
  const double torque_Nm = glm::length(tool.torque_Nm);
  if (!(torque_Nm > kSmallestArc_Nm)) return;
  torque_.setShape(segments(arcAround(hand.sample->ihip, tool.torque_Nm / torque_Nm, kArc_px * metresPerPixel,
                                      std::min(kArc_radPerNm * torque_Nm, kLongestArc_rad))));
  torque_.show(shadeIf(current, palette::kTorque), asItIs);
}

void ContactGlyphs::updateToolAtDevice(const MirrorView& view, const ShownHand& hand, bool current) {
  const SceneVersion::Object object = view.scene->find(hand.tool->object);
  if (!object || hand.sample->object == 0) return;
  const auto mesh = view.meshes.find(object->mesh);
  if (mesh == view.meshes.end()) return;
  const auto& tool = object->motion ? object->motion->tool : std::nullopt;
  const double opening_rad = tool && tool->jaws ? hand.sample->handle.gripper_rad : 0;
  if (toolShape_ != object->mesh || toolOpening_rad_ != opening_rad) {
    std::vector<Vec3f> vertices = mesh->second->vertices;
    if (opening_rad != 0) {
      for (Vec3f& v : vertices) v = Vec3f(toWorld(jawPose(*tool->jaws, Vec3(v), opening_rad), Vec3(v)));
    }
    toolAtDevice_.setShape(trianglesOf(vertices, mesh->second->triangles));
    toolShape_ = object->mesh;
    toolOpening_rad_ = opening_rad;
  }
  toolAtDevice_.show(shadeIf(current, palette::kHip),
                     matrixOf({hand.tool->deviceRotation * object->pose.rotation, hand.sample->hip}));
}

void ContactGlyphs::updateTrail(const Trail& trail, bool current) {
  std::vector<Vec3> ends;
  vtkNew<vtkUnsignedCharArray> colors;
  colors->SetNumberOfComponents(4);
  const palette::Shade shade = shadeIf(current, palette::kTrail);
  const auto add = [&](const Trail::Point& point) {
    ends.push_back(point.place);
    colors->InsertNextTuple4(255 * shade.red, 255 * shade.green, 255 * shade.blue, 255 * trail.freshness(point));
  };
  for (std::size_t i = 1; i < trail.points().size(); ++i) {
    if (trail.points()[i].startsStroke) continue;
    add(trail.points()[i - 1]);
    add(trail.points()[i]);
  }
  if (ends.empty()) return;
  const vtkSmartPointer<vtkPolyData> lines = segments(ends);
  lines->GetPointData()->SetScalars(colors);
  trail_.setShape(lines);
  trail_.setVisible(true);
}

std::vector<Vec3> primitiveCorners(const std::array<Vec3, 3>& triangle, const PrimitiveId& primitive, double lift_m) {
  if (primitive.kind == PrimitiveKind::kNone || primitive.localIndex > 2) return {};
  std::vector<Vec3> corners(triangle.begin(), triangle.end());
  const Vec3 across = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
  const double area = glm::length(across);
  if (area > 0) {
    for (Vec3& corner : corners) corner += across * (lift_m / area);
  }
  const std::size_t k = primitive.localIndex;
  if (primitive.kind == PrimitiveKind::kLine) return {corners[k], corners[(k + 1) % 3]};
  if (primitive.kind == PrimitiveKind::kVertex) return {corners[k]};
  return corners;
}

}  // namespace haptics
