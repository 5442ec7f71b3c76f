#include "graphics_client/viewer/object_actors.h"

#include <vtkPointData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "graphics_client/viewer/floor.h"
#include "graphics_client/viewer/palette.h"
#include "graphics_client/viewer/vertex_lighting.h"

namespace haptics {
namespace {

/// How much of an object's own colour is left when the picture is no longer current.
constexpr double kFadedColorShare = 0.25;
/// Polygon edges are the object's colour darkened this far towards black.
constexpr double kEdgeDarkening = 0.35, kCloseUpEdgeDarkening = 0.22;
/// Lines alone, on a pale ground.
constexpr double kWireDarkening = 0.5;
/// Brightness of a texture's lowest and highest places: some of the light does not reach the pits.
constexpr double kPitBrightness = 0.72, kPeakBrightness = 1.06;
/// From so many on, an object's triangles are a few pixels large.
constexpr std::size_t kFineTriangles = 20'000;
/// In radii of the falloff: what is farther away is not moved, whatever the rounding.
constexpr double kReach = 1 + 1e-5;
/// Towards the camera, in steps of the depth buffer: the polygons' edges lie on the surface.
constexpr double kRimOffset = -4;

void setUp(vtkActor* actor, vtkPolyData* data, bool faceted) {
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(data);
  mapper->ScalarVisibilityOff();
  actor->SetMapper(mapper);
  vtkProperty* surface = actor->GetProperty();
  surface->SetInterpolation(faceted ? VTK_FLAT : VTK_PHONG);
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

void cutBy(vtkActor* actor, vtkPlane* plane) {
  actor->GetMapper()->RemoveAllClippingPlanes();
  if (plane != nullptr) actor->GetMapper()->AddClippingPlane(plane);
}

void setEdgeColor(vtkActor* actor, palette::Shade edge) {
  actor->GetProperty()->SetEdgeColor(edge.red, edge.green, edge.blue);
}

}  // namespace

ObjectActors::ObjectActors(vtkRenderer* world, vtkRenderer* closeUp, std::shared_ptr<const RenderMesh> renderMesh)
    : worldRenderer_(world),
      closeUpRenderer_(closeUp),
      renderMesh_(std::move(renderMesh)),
      parts_(renderMesh_->pieces.size()),
      shadow_(makeShadow(renderMesh_->shadow)) {
  worldRenderer_->AddActor(shadow_);
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    Part& part = parts_[i];
    part.drawn->ShallowCopy(renderMesh_->pieces[i].drawn);
    for (vtkActor* actor : {part.world.Get(), part.closeUp.Get()}) {
      setUp(actor, part.drawn, renderMesh_->faceted);
      actor->GetProperty()->SetBackfaceCulling(renderMesh_->closed);
    }
    part.closeUp->GetProperty()->SetEdgeVisibility(!renderMesh_->rims);
    worldRenderer_->AddActor(part.world);
    closeUpRenderer_->AddActor(part.closeUp);
  }
  if (renderMesh_->coarse) {
    coarse_ = vtkSmartPointer<vtkActor>::New();
    setUp(coarse_, renderMesh_->coarse, renderMesh_->faceted);
    coarse_->VisibilityOff();
    worldRenderer_->AddActor(coarse_);
  }
  if (!renderMesh_->rims) return;
  setUpRims(rims_, renderMesh_->rims);
  worldRenderer_->AddActor(rims_);
}

ObjectActors::~ObjectActors() {
  for (const Part& part : parts_) {
    worldRenderer_->RemoveActor(part.world);
    closeUpRenderer_->RemoveActor(part.closeUp);
  }
  worldRenderer_->RemoveActor(shadow_);
  worldRenderer_->RemoveActor(rims_);
  if (coarse_) worldRenderer_->RemoveActor(coarse_);
}

void ObjectActors::paint(const Paint& paint) {
  const palette::Shade own = palette::shadeOf(paint.color);
  const palette::Shade shade = paint.current ? own : palette::mix(palette::kFaded, own, kFadedColorShare);
  const bool colored = paint.current && (!renderMesh_->heights.empty() || !renderMesh_->friction.empty());
  displacementOn_ = paint.displacement && paint.current ? std::optional(own) : std::nullopt;
  if (displacementOn_) {
    colored_.reset();
  } else if (colored) {
    colorPoints(paint);
  }
  const bool fine = renderMesh_->closed && !renderMesh_->faceted && renderMesh_->triangles >= kFineTriangles;
  cut_ = paint.cut != nullptr;
  for (Part& part : parts_) {
    cutBy(part.world, paint.cut);
    part.world->GetProperty()->SetBackfaceCulling(renderMesh_->closed && !cut_);  // else there is nothing inside
    if (displacementOn_ && part.dented) colorDisplacement(part);
    for (vtkActor* actor : {part.world.Get(), part.closeUp.Get()}) {
      const palette::Shade drawn = paint.wireframe && actor == part.world.Get() ? edgeOf(shade, kWireDarkening) : shade;
      actor->GetProperty()->SetColor(drawn.red, drawn.green, drawn.blue);
      actor->GetMapper()->SetScalarVisibility(displacementOn_ ? part.dented != nullptr : colored);
    }
    vtkProperty* world = part.world->GetProperty();
    setEdgeColor(part.world, edgeOf(shade, kEdgeDarkening));
    setEdgeColor(part.closeUp, edgeOf(shade, kCloseUpEdgeDarkening));
    world->SetEdgeVisibility(paint.edges && !renderMesh_->rims);
    world->SetRepresentation(paint.wireframe ? VTK_WIREFRAME : VTK_SURFACE);
    world->SetLighting(!paint.wireframe);  // lines have no side that looks away
    lightVertices(part.world, fine && paint.vertexLighting && !paint.wireframe && !world->GetEdgeVisibility());
    const bool edged = part.closeUp->GetProperty()->GetEdgeVisibility();
    lightVertices(part.closeUp, fine && paint.vertexLighting && !edged);
  }
  if (coarse_) {
    const palette::Shade drawn = paint.wireframe ? edgeOf(shade, kWireDarkening) : shade;
    coarse_->GetProperty()->SetColor(drawn.red, drawn.green, drawn.blue);
    coarse_->GetProperty()->SetRepresentation(paint.wireframe ? VTK_WIREFRAME : VTK_SURFACE);
    coarse_->GetProperty()->SetLighting(!paint.wireframe);
    lightVertices(coarse_, fine && paint.vertexLighting && !paint.wireframe);
    cutBy(coarse_, paint.cut);
  }
  const palette::Shade rims = edgeOf(shade, kEdgeDarkening);
  rims_->GetProperty()->SetColor(rims.red, rims.green, rims.blue);
  rims_->SetVisibility(paint.edges && !paint.hidden);
  hidden_ = paint.hidden;
  if (renderMesh_->rims) cutBy(rims_, paint.cut);
}

void ObjectActors::colorPoints(const Paint& paint) {
  if (colored_ == paint.color && coloredRange_ == paint.friction) return;
  colored_ = paint.color;
  coloredRange_ = paint.friction;
  const palette::Shade own = palette::shadeOf(paint.color);
  const FrictionRange range = paint.friction.value_or(FrictionRange{});
  const double width = range.most - range.least;
  const auto colorOf = [&](std::size_t v) {
    palette::Shade shade = own;
    if (!renderMesh_->friction.empty()) {
      shade = palette::frictionShade(width > 0 ? (renderMesh_->friction[v] - range.least) / width : 0);
    }
    double brightness = 1;
    if (!renderMesh_->heights.empty()) {
      brightness = kPitBrightness + (kPeakBrightness - kPitBrightness) * double{renderMesh_->heights[v]};
    }
    return palette::Shade{shade.red * brightness, shade.green * brightness, shade.blue * brightness};
  };
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const std::vector<std::uint32_t>& points = renderMesh_->pieces[i].patch.points;
    vtkNew<vtkUnsignedCharArray> colors;
    colors->SetNumberOfComponents(3);
    colors->SetNumberOfTuples(static_cast<vtkIdType>(points.size()));
    for (std::size_t p = 0; p < points.size(); ++p) {
      const auto color = palette::bytes(colorOf(points[p]));
      colors->SetTypedTuple(static_cast<vtkIdType>(p), color.data());
    }
    parts_[i].drawn->GetPointData()->SetScalars(colors);
  }
}

void ObjectActors::dent(std::span<const Dent> dents, const Falloff& falloff) {
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const Patch& patch = renderMesh_->pieces[i].patch;
    std::vector<Dent> reaching;
    std::ranges::copy_if(dents, std::back_inserter(reaching), [&](const Dent& dent) {
      return glm::distance(Vec3(dent.centre), patch.centre) < patch.radius_m + kReach * falloff.radius_m();
    });
    dent(parts_[i], reaching, falloff);
  }
  if (renderMesh_->rims) dentRims(dents, falloff);
}

void ObjectActors::dentRims(std::span<const Dent> dents, const Falloff& falloff) {
  if (!dentedRims_ && dents.empty()) return;
  vtkPolyData* rims = ownRims();
  if (dentedRims_->follow(dents, falloff)) rims->Modified();
}

vtkPolyData* ObjectActors::ownRims() {
  auto* mapper = vtkPolyDataMapper::SafeDownCast(rims_->GetMapper());
  if (!dentedRims_) {
    vtkNew<vtkPolyData> own;
    own->ShallowCopy(mapper->GetInput());
    mapper->SetInputData(own);
    dentedRims_ = std::make_unique<DentedPoints>(own);
    dentedRims_->drawIn(own);
  }
  return mapper->GetInput();
}

void ObjectActors::giveOwnPoints(Part& part) {
  part.dented = std::make_unique<DentedPoints>(part.drawn);
  part.dented->drawIn(part.drawn);
  for (vtkActor* actor : {part.world.Get(), part.closeUp.Get()}) {
    if (displacementOn_) actor->GetMapper()->ScalarVisibilityOn();
  }
}

void ObjectActors::open(const JawProperties& jaws, double opening_rad) {
  for (Part& part : parts_) {
    part.isDented = opening_rad != 0;
    if (!part.dented && opening_rad == 0) continue;
    if (!part.dented) giveOwnPoints(part);
    if (part.dented->open(jaws, opening_rad)) part.drawn->Modified();
  }
  if (!renderMesh_->rims || (!dentedRims_ && opening_rad == 0)) return;
  vtkPolyData* rims = ownRims();
  if (dentedRims_->open(jaws, opening_rad)) rims->Modified();
}

/// From the first dent on it has points of its own.
void ObjectActors::dent(Part& part, std::span<const Dent> dents, const Falloff& falloff) {
  part.isDented = !dents.empty();
  if (!part.dented) {
    if (dents.empty()) return;
    giveOwnPoints(part);
  }
  if (!part.dented->follow(dents, falloff)) return;
  part.drawn->Modified();
  if (displacementOn_) colorDisplacement(part);
}

void ObjectActors::place(vtkMatrix4x4* object, vtkMatrix4x4* shadow) {
  for (const Part& part : parts_) {
    part.world->SetUserMatrix(object);
    part.closeUp->SetUserMatrix(object);
  }
  rims_->SetUserMatrix(object);
  if (coarse_) coarse_->SetUserMatrix(object);
  shadow_->SetUserMatrix(shadow);
}

void ObjectActors::showFor(Vec3 worldEye, Vec3 closeUpEye) {
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const auto isSeen = [&](Vec3 eye) {
      return !hidden_ && (cut_ || parts_[i].isDented || !facesAway(*renderMesh_, renderMesh_->pieces[i], eye));
    };
    parts_[i].world->SetVisibility(!isCoarse_ && isSeen(worldEye));
    parts_[i].closeUp->SetVisibility(isSeen(closeUpEye));
  }
  if (coarse_) coarse_->SetVisibility(isCoarse_ && !hidden_);
}

}  // namespace haptics
