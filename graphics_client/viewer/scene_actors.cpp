#include "graphics_client/viewer/scene_actors.h"

#include <vtkMatrix4x4.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>

#include <algorithm>
#include <set>

#include "graphics_client/viewer/mesh_normals.h"
#include "graphics_client/viewer/palette.h"
#include "graphics_client/viewer/poly_data.h"

namespace haptics {
namespace {

/// How much of an object's own colour is left when the picture is no longer current.
constexpr double kFadedColorShare = 0.25;
/// Polygon edges are the object's colour darkened this far towards black.
constexpr double kEdgeDarkening = 0.35, kCloseUpEdgeDarkening = 0.22;

vtkSmartPointer<vtkActor> makeActor(vtkPolyData* data) {
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(data);
  mapper->ScalarVisibilityOff();
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  vtkProperty* surface = actor->GetProperty();
  surface->SetInterpolationToPhong();
  surface->SetAmbient(0.14);
  surface->SetDiffuse(0.92);
  surface->SetSpecular(0.18);
  surface->SetSpecularPower(24);
  return actor;
}

void setEdgeColor(vtkActor* actor, palette::Shade shade, double darkening) {
  const palette::Shade edge = palette::mix(shade, {0, 0, 0}, darkening);
  actor->GetProperty()->SetEdgeColor(edge.red, edge.green, edge.blue);
}

/// At most about this many vertices of an object decide on the camera and the floor, besides the extreme ones.
constexpr std::size_t kOutlinePoints = 4096;

std::vector<Vec3> outlineOf(const TriMesh& mesh) {
  std::vector<Vec3> points;
  const std::size_t step = mesh.vertices.size() / kOutlinePoints + 1;
  for (std::size_t i = 0; i < mesh.vertices.size(); i += step) points.emplace_back(mesh.vertices[i]);
  for (int axis = 0; axis < 3; ++axis) {
    const auto [low, high] = std::ranges::minmax_element(mesh.vertices, {}, [&](Vec3f v) { return v[axis]; });
    points.emplace_back(*low);
    points.emplace_back(*high);
  }
  return points;
}

}  // namespace

SceneActors::SceneActors(vtkRenderer* world, vtkRenderer* closeUp)
    : worldRenderer_(world), closeUpRenderer_(closeUp), floor_(world) {}

bool SceneActors::update(const MirrorView& view, bool current) {
  bool changed = false;
  std::set<ObjectId> present;
  std::set<ContentHash> used;
  for (const SceneVersion::Object& object : view.scene->objects()) {
    const auto mesh = view.meshes.find(object->mesh);
    if (mesh == view.meshes.end()) continue;  // still on its way
    present.insert(object->id);
    used.insert(object->mesh);
    if (!prepared_.contains(object->mesh)) prepared_[object->mesh] = prepare(*mesh->second);
    const auto at = shown_.find(object->id);
    if (at == shown_.end() || at->second.mesh != object->mesh) {
      if (at != shown_.end()) remove(at->second);
      shown_[object->id] = make(*object, prepared_.at(object->mesh));
      changed = true;
      continue;
    }
    Shown& shown = at->second;
    if (shown.pose != object->pose) {
      shown.pose = object->pose;
      changed = true;
    }
    if (shown.color != object->material.color) {
      shown.color = object->material.color;
      paint(shown);
    }
  }
  changed |= std::erase_if(shown_, [&](const auto& entry) {
               if (present.contains(entry.first)) return false;
               remove(entry.second);
               return true;
             }) > 0;
  std::erase_if(prepared_, [&](const auto& entry) { return !used.contains(entry.first); });
  if (current != current_) {
    current_ = current;
    for (auto& [id, shown] : shown_) paint(shown);
  }
  if (changed) placeFloor();
  return changed;
}

SceneActors::Prepared SceneActors::prepare(const TriMesh& mesh) {
  const ShadedMesh shaded = shadeMesh(mesh);
  return {polyDataOf(mesh, shaded), shaded.closed, outlineOf(mesh)};
}

SceneActors::Shown SceneActors::make(const ObjectRecord& object, const Prepared& prepared) {
  Shown shown{.mesh = object.mesh,
              .pose = object.pose,
              .color = object.material.color,
              .world = makeActor(prepared.data),
              .closeUp = makeActor(prepared.data),
              .shadow = makeShadow(prepared.data)};
  shown.world->GetProperty()->SetBackfaceCulling(prepared.closed);
  shown.closeUp->GetProperty()->SetBackfaceCulling(prepared.closed);
  shown.closeUp->GetProperty()->EdgeVisibilityOn();
  worldRenderer_->AddActor(shown.shadow);
  worldRenderer_->AddActor(shown.world);
  closeUpRenderer_->AddActor(shown.closeUp);
  paint(shown);
  return shown;
}

void SceneActors::remove(const Shown& shown) {
  worldRenderer_->RemoveActor(shown.shadow);
  worldRenderer_->RemoveActor(shown.world);
  closeUpRenderer_->RemoveActor(shown.closeUp);
}

void SceneActors::paint(Shown& shown) const {
  const palette::Shade own = palette::shadeOf(shown.color);
  const palette::Shade shade = current_ ? own : palette::mix(palette::kFaded, own, kFadedColorShare);
  for (vtkActor* actor : {shown.world.Get(), shown.closeUp.Get()}) {
    actor->GetProperty()->SetColor(shade.red, shade.green, shade.blue);
    actor->GetProperty()->SetSpecularColor(1, 1, 1);
  }
  setEdgeColor(shown.world, shade, kEdgeDarkening);
  setEdgeColor(shown.closeUp, shade, kCloseUpEdgeDarkening);
  shown.world->GetProperty()->SetEdgeVisibility(edges_);
  if (wireframe_) {
    shown.world->GetProperty()->SetRepresentationToWireframe();
  } else {
    shown.world->GetProperty()->SetRepresentationToSurface();
  }
}

void SceneActors::place(Shown& shown) const {
  const vtkSmartPointer<vtkMatrix4x4> object = matrixOf(shown.pose);
  shown.world->SetUserMatrix(object);
  shown.closeUp->SetUserMatrix(object);
  vtkNew<vtkMatrix4x4> shadow;
  vtkMatrix4x4::Multiply4x4(floor_.shadowMatrix(), object, shadow);
  shown.shadow->SetUserMatrix(shadow);
}

void SceneActors::placeFloor() {
  const std::vector<Vec3> all = outline();
  if (all.empty()) {
    floor_.hide();
    return;
  }
  Vec3 low = all.front(), high = all.front();
  for (const Vec3& p : all) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  floor_.placeUnder(low, high);
  for (auto& [id, shown] : shown_) place(shown);
}

void SceneActors::setWireframe(bool on) {
  wireframe_ = on;
  for (auto& [id, shown] : shown_) paint(shown);
}

void SceneActors::setEdges(bool on) {
  edges_ = on;
  for (auto& [id, shown] : shown_) paint(shown);
}

std::vector<Vec3> SceneActors::outline() const {
  std::vector<Vec3> all;
  for (const auto& [id, shown] : shown_) {
    for (const Vec3& p : prepared_.at(shown.mesh).outline) all.push_back(toWorld(shown.pose, p));
  }
  return all;
}

void SceneActors::setSeenFromAbove(const Vec3& camera) {
  for (auto& [id, shown] : shown_) shown.shadow->SetVisibility(camera.z > floor_.height_m() && !wireframe_);
}

}  // namespace haptics
