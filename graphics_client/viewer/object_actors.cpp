#include "graphics_client/viewer/object_actors.h"

#include <vtkPointData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <cmath>
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

palette::Shade edgeOf(palette::Shade shade, double darkening) { return palette::mix(shade, {0, 0, 0}, darkening); }

void setEdgeColor(vtkActor* actor, palette::Shade edge) {
  actor->GetProperty()->SetEdgeColor(edge.red, edge.green, edge.blue);
}

}  // namespace

ObjectActors::ObjectActors(vtkRenderer* world, vtkRenderer* closeUp, std::shared_ptr<const Look> look)
    : worldRenderer_(world),
      closeUpRenderer_(closeUp),
      look_(std::move(look)),
      parts_(look_->sides.size()),
      shadow_(makeShadow(look_->shadow)) {
  worldRenderer_->AddActor(shadow_);
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    Part& part = parts_[i];
    part.drawn->ShallowCopy(look_->sides[i].drawn);
    for (vtkActor* actor : {part.world.Get(), part.closeUp.Get()}) {
      setUp(actor, part.drawn, look_->faceted);
      actor->GetProperty()->SetBackfaceCulling(look_->closed);
    }
    part.closeUp->GetProperty()->SetEdgeVisibility(!look_->rims);
    worldRenderer_->AddActor(part.world);
    closeUpRenderer_->AddActor(part.closeUp);
  }
  if (!look_->rims) return;
  setUpRims(rims_, look_->rims);
  worldRenderer_->AddActor(rims_);
}

ObjectActors::~ObjectActors() {
  for (const Part& part : parts_) {
    worldRenderer_->RemoveActor(part.world);
    closeUpRenderer_->RemoveActor(part.closeUp);
  }
  worldRenderer_->RemoveActor(shadow_);
  worldRenderer_->RemoveActor(rims_);
}

void ObjectActors::paint(const Paint& paint) {
  const palette::Shade own = palette::shadeOf(paint.color);
  const palette::Shade shade = paint.current ? own : palette::mix(palette::kFaded, own, kFadedColorShare);
  const bool colored = paint.current && (!look_->heights.empty() || !look_->friction.empty());
  displacementOn_ = paint.displacement && paint.current ? std::optional(own) : std::nullopt;
  if (displacementOn_) {
    if (!dented_) makeDentable();
    colorDisplacement();
    colored_.reset();
  } else if (colored) {
    colorPoints(paint);
  }
  for (const Part& part : parts_) {
    for (vtkActor* actor : {part.world.Get(), part.closeUp.Get()}) {
      actor->GetProperty()->SetColor(shade.red, shade.green, shade.blue);
      actor->GetMapper()->SetScalarVisibility(colored || displacementOn_);
    }
    vtkProperty* world = part.world->GetProperty();
    setEdgeColor(part.world, edgeOf(shade, kEdgeDarkening));
    setEdgeColor(part.closeUp, edgeOf(shade, kCloseUpEdgeDarkening));
    world->SetEdgeVisibility(paint.edges && !look_->rims);
    if (paint.wireframe) {
      world->SetRepresentationToWireframe();
    } else {
      world->SetRepresentationToSurface();
    }
  }
  const palette::Shade rims = edgeOf(shade, kEdgeDarkening);
  rims_->GetProperty()->SetColor(rims.red, rims.green, rims.blue);
  rims_->SetVisibility(paint.edges);
}

void ObjectActors::colorPoints(const Paint& paint) {
  if (colored_ == paint.color && coloredRange_ == paint.friction) return;
  colored_ = paint.color;
  coloredRange_ = paint.friction;
  const palette::Shade own = palette::shadeOf(paint.color);
  const vtkIdType points = parts_.front().drawn->GetNumberOfPoints();
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
      colors->SetTypedComponent(i, k, static_cast<unsigned char>(std::lround(part)));
    }
  }
  for (const Part& part : parts_) part.drawn->GetPointData()->SetScalars(colors);
}

/// From here on the object has points of its own.
void ObjectActors::makeDentable() {
  dented_ = std::make_unique<DentedPoints>(look_->sides.front().drawn);
  for (const Part& part : parts_) dented_->drawIn(part.drawn);
  const auto own = [&](vtkActor* actor, vtkPolyData* looks) {
    vtkNew<vtkPolyData> data;
    data->ShallowCopy(looks);
    dented_->drawIn(data);
    vtkPolyDataMapper::SafeDownCast(actor->GetMapper())->SetInputData(data);
  };
  if (look_->rims) own(rims_, look_->rims);
  if (look_->shadow == look_->sides.front().drawn) own(shadow_, look_->shadow);
}

void ObjectActors::dent(std::span<const Dent> dents, const Falloff& falloff) {
  if (!dented_) {
    if (dents.empty()) return;
    makeDentable();
  }
  if (!dented_->follow(dents, falloff)) return;
  for (const Part& part : parts_) part.drawn->Modified();
  if (displacementOn_) colorDisplacement();
}

void ObjectActors::colorDisplacement() {
  for (const Part& part : parts_) dented_->colorIn(part.drawn, *displacementOn_);
}

void ObjectActors::place(vtkMatrix4x4* object, vtkMatrix4x4* shadow) {
  for (const Part& part : parts_) {
    part.world->SetUserMatrix(object);
    part.closeUp->SetUserMatrix(object);
  }
  rims_->SetUserMatrix(object);
  shadow_->SetUserMatrix(shadow);
}

void ObjectActors::showFor(Vec3 worldEye, Vec3 closeUpEye) {
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    parts_[i].world->SetVisibility(!facesAway(*look_, look_->sides[i], worldEye));
    parts_[i].closeUp->SetVisibility(!facesAway(*look_, look_->sides[i], closeUpEye));
  }
}

void ObjectActors::setShadowVisible(bool visible) { shadow_->SetVisibility(visible); }

}  // namespace haptics
