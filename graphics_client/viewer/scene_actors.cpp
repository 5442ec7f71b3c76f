#include "graphics_client/viewer/scene_actors.h"

#include <vtkMatrix4x4.h>

#include <algorithm>

#include "graphics_client/viewer/poly_data.h"

namespace haptics {
namespace {

std::size_t countTextured(const SceneVersion& scene) {
  return static_cast<std::size_t>(
      std::ranges::count_if(scene.objects(), [](const auto& o) { return hasField(o->material.surface); }));
}

/// Around an object's box a place on its drawn surface may be (metres): bumps, dents.
constexpr double kAround_m = 0.002;

/// Whether a place is within the box that these are the corners of.
bool isWithin(const NamedBox& box, Vec3 place) {
  const Vec3 from = place - box.corners[0];
  for (const std::size_t axis : {1, 2, 4}) {
    const Vec3 side = box.corners[axis] - box.corners[0];
    const double length = glm::length(side);
    if (!(length > 0)) continue;
    const double along = glm::dot(from, side) / length;
    if (along < -kAround_m || along > length + kAround_m) return false;
  }
  return true;
}

double volume(const NamedBox& box) {
  double product = 1;
  for (const std::size_t axis : {1, 2, 4}) product *= glm::distance(box.corners[axis], box.corners[0]);
  return product;
}

}  // namespace

SceneActors::SceneActors(vtkRenderer* world, vtkRenderer* closeUp)
    : worldRenderer_(world), closeUpRenderer_(closeUp), floor_(world) {}

bool SceneActors::update(const MirrorView& view, bool current) {
  const std::size_t share = maxTriangles_ / std::max<std::size_t>(countTextured(*view.scene), 1);
  bool changed = std::erase_if(shown_, [&](const auto& entry) { return !view.scene->find(entry.first); }) > 0;
  for (const SceneVersion::Object& object : view.scene->objects()) {
    changed |= follow(shown_[object->id], object, view, share);
  }
  if (changed) updateFrictionRange();
  if (current != paint_.current) paintWith(&ObjectActors::Paint::current, current);
  if (changed) placeFloor();
  return changed;
}

void SceneActors::settle(const MirrorView& view, bool current) {
  while (update(view, current) || isSettling()) {
    for (const auto& [id, shown] : shown_) {
      if (shown.pending.valid()) shown.pending.wait();
    }
  }
}

bool SceneActors::isSettling() const {
  return std::ranges::any_of(shown_, [](const auto& entry) { return entry.second.pending.valid(); });
}

bool SceneActors::follow(Shown& shown, const SceneVersion::Object& object, const MirrorView& view,
                         std::size_t maxTriangles) {
  bool changed = takeRenderMesh(shown);
  const bool isOther = shown.ordered != object || shown.share != maxTriangles ||
                       !(shown.request.deformation == view.deformationOf(*object));
  if (!shown.pending.valid() && isOther) {
    if (std::optional<SurfaceRequest> request = surfaceRequest(*object, view, maxTriangles)) {
      shown.ordered = object;
      shown.share = maxTriangles;
      if (!request->sameAs(shown.request)) {
        shown.pending = builder_.request(*request);
        shown.request = *std::move(request);
        changed |= takeRenderMesh(shown);
      }
    }
  }
  const Pose pose = view.poseOf(*object);
  const bool moved = !shown.record || shown.pose != pose;
  shown.pose = pose;
  if (moved && object->motion && shown.actors) place(shown);
  const bool hasJaws = object->motion && object->motion->tool && object->motion->tool->jaws;
  if (shown.actors && hasJaws) {
    const bool isHeld = view.tool && view.tool->object == object->id && view.tool->grip;
    shown.actors->open(*object->motion->tool->jaws, isHeld ? view.tool->grip->opening_rad : 0);
  } else if (shown.actors) {
    dent(shown, *object, view);
  }
  if (shown.record == object) return changed;
  shown.record = object;
  if (!shown.actors) return changed;
  paint(shown);
  return changed || moved;
}

/// As the newest sample has its dents. The first ones may have ended in it because a residue holds them, and are shown
/// until that is.
void SceneActors::dent(Shown& shown, const ObjectRecord& object, const MirrorView& view) {
  const Softness softness = object.deformation.softness.value_or(Softness{.radius_m = 1});
  std::vector<Dent> dents = view.dentsIn(object);
  const bool awaits = shown.pending.valid() || shown.request.deformation.residue != object.deformation.residue;
  if (awaits && shown.dents.size() > dents.size()) {
    const auto ended = static_cast<std::ptrdiff_t>(shown.dents.size() - dents.size());
    dents.insert(dents.begin(), shown.dents.begin(), shown.dents.begin() + ended);
  }
  shown.dents = std::move(dents);
  shown.actors->dent(shown.dents, tissueOf(softness).falloff);
}

/// Shows the requested render mesh once it is built.
bool SceneActors::takeRenderMesh(Shown& shown) {
  if (!shown.pending.valid() || !RenderMeshBuilder::isReady(shown.pending)) return false;
  shown.actors = std::make_unique<ObjectActors>(worldRenderer_, closeUpRenderer_, shown.pending.get());
  shown.pending = {};
  shown.actors->setCoarse(coarse_);
  if (shown.record) paint(shown);
  return true;
}

void SceneActors::updateFrictionRange() {
  std::optional<FrictionRange> range;
  for (const auto& [id, shown] : shown_) {
    if (!shown.actors || shown.actors->renderMesh().friction.empty()) continue;
    const RenderMesh& renderMesh = shown.actors->renderMesh();
    if (!range) range = FrictionRange{renderMesh.minFriction, renderMesh.maxFriction};
    range->least = std::min<double>(range->least, renderMesh.minFriction);
    range->most = std::max<double>(range->most, renderMesh.maxFriction);
  }
  if (range == paint_.friction) return;
  paint_.friction = range;
  paintAll();
}

void SceneActors::paintAll() {
  for (const auto& [id, shown] : shown_) {
    if (shown.actors && shown.record) paint(shown);
  }
}

void SceneActors::paint(const Shown& shown) const {
  ObjectActors::Paint own = paint_;
  own.color = shown.record->material.color;
  own.hidden = hidden_.contains(shown.record->name);
  own.displacement = paint_.displacement && shown.record->deformation.softness;
  shown.actors->paint(own);
}

void SceneActors::place(const Shown& shown) const {
  const vtkSmartPointer<vtkMatrix4x4> object = matrixOf(shown.pose);
  vtkNew<vtkMatrix4x4> shadow;
  vtkMatrix4x4::Multiply4x4(floor_.shadowMatrix(), object, shadow);
  shown.actors->place(object, shadow);
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
  for (const auto& [id, shown] : shown_) {
    if (shown.actors) place(shown);
  }
}

void SceneActors::setCoarse(bool on) {
  coarse_ = on;
  for (const auto& [id, shown] : shown_) {
    if (shown.actors) shown.actors->setCoarse(on);
  }
}

bool SceneActors::isCoarse() const {
  return coarse_ && std::ranges::any_of(shown_, [](const auto& entry) {
           return entry.second.actors && entry.second.actors->renderMesh().coarse;
         });
}

void SceneActors::hide(std::set<std::string> names) {
  if (names == hidden_) return;
  hidden_ = std::move(names);
  paintAll();
}

void SceneActors::cut(const std::optional<CutPlane>& plane) {
  paint_.cut = nullptr;
  if (plane) {
    paint_.cut = vtkSmartPointer<vtkPlane>::New();
    paint_.cut->SetOrigin(plane->point.x, plane->point.y, plane->point.z);
    paint_.cut->SetNormal(plane->normal.x, plane->normal.y, plane->normal.z);
  }
  paintAll();
}

void SceneActors::paintWith(bool ObjectActors::Paint::*how, bool on) {
  paint_.*how = on;
  paintAll();
}

std::vector<Vec3> SceneActors::outline() const {
  std::vector<Vec3> all;
  for (const auto& [id, shown] : shown_) {
    if (!shown.actors) continue;
    for (const Vec3& p : shown.actors->renderMesh().outline) all.push_back(toWorld(shown.pose, p));
  }
  return all;
}

std::vector<NamedBox> SceneActors::boxes() const {
  std::vector<NamedBox> boxes;
  for (const auto& [id, shown] : shown_) {
    if (!shown.actors || !shown.record || hidden_.contains(shown.record->name)) continue;
    const RenderMesh& renderMesh = shown.actors->renderMesh();
    NamedBox& box = boxes.emplace_back(NamedBox{shown.record->name, {}});
    for (std::size_t i = 0; i < box.corners.size(); ++i) {
      const Vec3 corner((i & 1) != 0 ? renderMesh.high.x : renderMesh.low.x,
                        (i & 2) != 0 ? renderMesh.high.y : renderMesh.low.y,
                        (i & 4) != 0 ? renderMesh.high.z : renderMesh.low.z);
      box.corners[i] = toWorld(shown.pose, corner);
    }
  }
  return boxes;
}

void SceneActors::showFor(Vec3 worldCamera, Vec3 closeUpCamera) {
  for (const auto& [id, shown] : shown_) {
    if (!shown.actors) continue;
    const Pose& pose = shown.pose;
    shown.actors->showFor(toLocal(pose, worldCamera), toLocal(pose, closeUpCamera));
    shown.actors->setShadowVisible(worldCamera.z > floor_.height_m() && !paint_.wireframe);
  }
}

std::optional<CoarseDetail> SceneActors::coarsestDetail() const {
  std::optional<CoarseDetail> coarsest;
  for (const auto& [id, shown] : shown_) {
    if (!shown.actors || !shown.actors->renderMesh().filtered) continue;
    const RenderMesh& renderMesh = shown.actors->renderMesh();
    const CoarseDetail detail{shown.record->name, renderMesh.finestDetail_m, renderMesh.longestEdge_m};
    const auto ratio = [](const CoarseDetail& d) { return d.edge_m / d.detail_m; };
    if (!coarsest || ratio(detail) > ratio(*coarsest)) coarsest = detail;
  }
  return coarsest;
}

bool SceneActors::anyPitsFeltAsBumps() const {
  return std::ranges::any_of(shown_, [](const auto& entry) {
    return entry.second.actors && entry.second.actors->renderMesh().pitsAreFeltAsBumps;
  });
}

std::string SceneActors::objectAt(Vec3 place) const {
  std::string name;
  double smallest = 0;
  for (const NamedBox& box : boxes()) {
    if (!isWithin(box, place) || (!name.empty() && volume(box) >= smallest)) continue;
    smallest = volume(box);
    name = box.name;
  }
  return name;
}

}  // namespace haptics
