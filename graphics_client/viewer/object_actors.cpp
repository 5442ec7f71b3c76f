#include "graphics_client/viewer/object_actors.h"

#include <vtkPointData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <utility>

#include "graphics_client/viewer/floor.h"
#include "graphics_client/viewer/palette.h"

namespace haptics {
namespace {

/// How much of an object's own colour is left when the picture is no longer current.
constexpr double kFadedColorShare = 0.25;
/// Polygon edges are the object's colour darkened this far towards black.
constexpr double kEdgeDarkening = 0.35, kCloseUpEdgeDarkening = 0.22;
/// Brightness of a texture's lowest and highest places: some of the light does not reach the pits.
constexpr double kPitBrightness = 0.72, kPeakBrightness = 1.06;
/// Towards the camera, in steps of the depth buffer: the polygons' edges lie on the surface.
constexpr double kRimOffset = -4;

void setUp(vtkActor* actor, vtkPolyData* data, bool faceted) {
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(data);
  mapper->ScalarVisibilityOff();
  actor->SetMapper(mapper);
  vtkProperty* surface = actor->GetProperty();
  if (faceted) {
    surface->SetInterpolationToFlat();
  } else {
    surface->SetInterpolationToPhong();
  }
  surface->SetAmbient(0.14);
  surface->SetDiffuse(0.92);
  surface->SetSpecular(0.18);
  surface->SetSpecularPower(24);
  surface->SetSpecularColor(1, 1, 1);
}

void setUpRims(vtkActor* actor, vtkPolyData* rims) {
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(rims);
  mapper->ScalarVisibilityOff();
  mapper->SetResolveCoincidentTopologyToPolygonOffset();
  mapper->SetRelativeCoincidentTopologyLineOffsetParameters(0, kRimOffset);
  actor->SetMapper(mapper);
  actor->GetProperty()->LightingOff();
  actor->SetPickable(false);
}

void setEdgeColor(vtkActor* actor, vtkActor* rims, palette::Shade shade, double darkening) {
  const palette::Shade edge = palette::mix(shade, {0, 0, 0}, darkening);
  actor->GetProperty()->SetEdgeColor(edge.red, edge.green, edge.blue);
  rims->GetProperty()->SetColor(edge.red, edge.green, edge.blue);
}

}  // namespace

ObjectActors::ObjectActors(vtkRenderer* world, vtkRenderer* closeUp, std::shared_ptr<const Look> look)
    : worldRenderer_(world), closeUpRenderer_(closeUp), look_(std::move(look)), shadow_(makeShadow(look_->shadow)) {
  drawn_->ShallowCopy(look_->drawn);
  for (vtkActor* actor : {world_.Get(), closeUp_.Get()}) {
    setUp(actor, drawn_, look_->faceted);
    actor->GetProperty()->SetBackfaceCulling(look_->closed);
  }
  closeUp_->GetProperty()->SetEdgeVisibility(!look_->rims);
  worldRenderer_->AddActor(shadow_);
  worldRenderer_->AddActor(world_);
  closeUpRenderer_->AddActor(closeUp_);
  if (!look_->rims) return;
  for (vtkActor* actor : {worldRims_.Get(), closeUpRims_.Get()}) setUpRims(actor, look_->rims);
  worldRenderer_->AddActor(worldRims_);
  closeUpRenderer_->AddActor(closeUpRims_);
}

ObjectActors::~ObjectActors() {
  for (vtkActor* actor : {shadow_.Get(), world_.Get(), worldRims_.Get()}) worldRenderer_->RemoveActor(actor);
  for (vtkActor* actor : {closeUp_.Get(), closeUpRims_.Get()}) closeUpRenderer_->RemoveActor(actor);
}

void ObjectActors::paint(const Paint& paint) {
  const palette::Shade own = palette::shadeOf(paint.color);
  const palette::Shade shade = paint.current ? own : palette::mix(palette::kFaded, own, kFadedColorShare);
  const bool colored = paint.current && (!look_->heights.empty() || !look_->friction.empty());
  if (colored) colorPoints(paint);
  for (vtkActor* actor : {world_.Get(), closeUp_.Get()}) {
    actor->GetProperty()->SetColor(shade.red, shade.green, shade.blue);
    actor->GetMapper()->SetScalarVisibility(colored);
  }
  setEdgeColor(world_, worldRims_, shade, kEdgeDarkening);
  setEdgeColor(closeUp_, closeUpRims_, shade, kCloseUpEdgeDarkening);
  world_->GetProperty()->SetEdgeVisibility(paint.edges && !look_->rims);
  worldRims_->SetVisibility(paint.edges);
  if (paint.wireframe) {
    world_->GetProperty()->SetRepresentationToWireframe();
  } else {
    world_->GetProperty()->SetRepresentationToSurface();
  }
}

void ObjectActors::colorPoints(const Paint& paint) {
  if (colored_ == paint.color && coloredRange_ == paint.friction) return;
  colored_ = paint.color;
  coloredRange_ = paint.friction;
  const palette::Shade own = palette::shadeOf(paint.color);
  const vtkIdType points = drawn_->GetNumberOfPoints();
  const FrictionRange range = paint.friction.value_or(FrictionRange{});
  const double width = range.most - range.least;
  vtkNew<vtkUnsignedCharArray> colors;
  colors->SetNumberOfComponents(3);
  colors->SetNumberOfTuples(points);
  for (vtkIdType i = 0; i < points; ++i) {
    const auto v = static_cast<std::size_t>(i);
    palette::Shade shade = own;
    if (!look_->friction.empty()) {
      shade = palette::frictionShade(width > 0 ? (look_->friction[v] - range.least) / width : 0);
    }
    double brightness = 1;
    if (!look_->heights.empty()) {
      brightness = kPitBrightness + (kPeakBrightness - kPitBrightness) * double{look_->heights[v]};
    }
    const double parts[] = {shade.red, shade.green, shade.blue};
    for (int k = 0; k < 3; ++k) {
      const double part = 255 * std::clamp(parts[k] * brightness, 0.0, 1.0);
      colors->SetTypedComponent(i, k, static_cast<unsigned char>(part + 0.5));
    }
  }
  drawn_->GetPointData()->SetScalars(colors);
}

void ObjectActors::place(vtkMatrix4x4* object, vtkMatrix4x4* shadow) {
  for (vtkActor* actor : {world_.Get(), closeUp_.Get(), worldRims_.Get(), closeUpRims_.Get()}) {
    actor->SetUserMatrix(object);
  }
  shadow_->SetUserMatrix(shadow);
}

void ObjectActors::setShadowVisible(bool visible) { shadow_->SetVisibility(visible); }

}  // namespace haptics
