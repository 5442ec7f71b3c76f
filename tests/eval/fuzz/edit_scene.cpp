#include "tests/eval/fuzz/edit_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "common/deform/free_form.h"
#include "common/scene/deformation_properties.h"
#include "haptic_server/device/presets.h"

namespace haptics::eval {
namespace {

constexpr double kApproach_m_per_s = 0.2;
constexpr double kLongestApproach_s = 0.9;
constexpr double kRest_s = 0.1;     ///< Before an edit.
constexpr double kSettled_s = 1;    ///< After it, it is to be felt in full.
constexpr double kWatched_s = 1.2;  ///< After it.
constexpr double kLeaves_s = 0.5;   ///< For so long the server keeps what was removed.
constexpr double kMaxPress_N = 2.5;
constexpr std::array kRates_Hz{1000.0, 500.0, 2000.0, 4000.0};
constexpr std::array kKinds{"add",     "remove",   "move",     "turn",    "stiffness", "damping", "remesh",
                            "lattice", "softness", "friction", "texture", "shading",   "motion"};

}  // namespace

EditScene::EditScene(std::uint64_t seed) : random_(seed), drive_(chosenRun()), judge_(run_) {
  const int objects = 1 + random_.below(3);
  for (int i = 0; i < objects; ++i) add(somePose());
  ++revision_;
  publish();
  step(hip_);
}

/// Rate, device and features; every fourth scene has no features.
const EditRun& EditScene::chosenRun() {
  run_.rate_Hz = random_.below(2) == 0 ? kRates_Hz[0] : kRates_Hz[static_cast<std::size_t>(random_.below(4))];
  if (random_.below(2) == 0) {
    const auto presets = devicePresets();
    run_.device = presets[static_cast<std::size_t>(random_.below(static_cast<int>(presets.size())))].name;
    run_.stabiliser = random_.below(2) == 0;
  }
  const bool plain = random_.below(4) == 0;
  for (bool* feature : {&features_.damping, &features_.soft, &features_.moving, &features_.friction, &features_.texture,
                        &features_.shading}) {
    *feature = random_.below(3) == 0 && !plain;
  }
  return run_;
}

std::uint64_t EditScene::ticks(double seconds) const {
  return static_cast<std::uint64_t>(std::lround(seconds * run_.rate_Hz));
}

void EditScene::step(Vec3 hip) {
  hip_ = hip;
  run_.hips.push_back(hip);
  drive_.step(hip);
}

void EditScene::publish() { run_.scenes.push_back({drive_.tick(), revision_, objects_}); }

std::size_t EditScene::someObject() {
  return static_cast<std::size_t>(random_.below(static_cast<int>(objects_.size())));
}

std::size_t EditScene::touchedOrSome() {
  const auto touched = std::ranges::find(objects_, drive_.sample().object, &FuzzObject::id);
  const bool takeTouched = touched != objects_.end() && random_.chance(0.75);
  return takeTouched ? static_cast<std::size_t>(touched - objects_.begin()) : someObject();
}

std::size_t EditScene::addMesh(MeshKind kind) {
  run_.meshes.push_back({makeMesh(kind, random_), std::nullopt});
  canMove_.push_back(kind == MeshKind::kBox || kind == MeshKind::kBlob);
  return run_.meshes.size() - 1;
}

std::size_t EditScene::someMesh(bool mayMove) {
  const double draw = random_.between(0, 1);
  if (mayMove || draw < 0.75) return addMesh(random_.below(2) == 0 ? MeshKind::kBox : MeshKind::kBlob);
  if (draw < 0.87) return addMesh(MeshKind::kSpiky);
  if (draw < 0.93) return addMesh(MeshKind::kFolded);
  return addMesh(draw < 0.98 ? MeshKind::kScan : MeshKind::kSheet);
}

Pose EditScene::somePose() {
  constexpr double kSpread_m = 0.015;
  const Vec3 place = kSpread_m * normalVector(random_);
  return {random_.rotation(), place};
}

SoftTissue EditScene::someTissue() {
  const Falloff falloff{random_.between(0.005, 0.015), 2 + static_cast<unsigned>(random_.below(3))};
  const double stiffness = random_.between(200, 1500);
  const double return_s = random_.below(2) == 0 ? 0 : random_.between(0.05, 0.5);
  return {falloff, stiffness, return_s, random_.below(3) == 0 ? random_.between(0, 1) : 0};
}

void EditScene::add(const Pose& pose) {
  FuzzObject object;
  object.id = ++lastId_;
  object.mesh = someMesh(false);
  object.pose = pose;
  object.poseRevision = revision_ + 1;
  object.stiffness_N_per_m = random_.between(200, 1700);
  if (features_.damping && random_.below(2) == 0) object.damping_Ns_per_m = random_.between(0, 4);
  if (features_.soft && random_.below(2) == 0) object.tissue = someTissue();
  if (features_.moving && canMove_[object.mesh] && random_.below(2) == 0) object.mass_kg = random_.between(0.1, 1);
  if (features_.friction && random_.below(2) == 0) object.friction = random_.between(0.1, 1);
  if (features_.shading && random_.below(2) == 0) object.crease_rad = std::numbers::pi / 3;
  if (features_.texture && random_.below(2) == 0) {
    object.textureAmplitude_m = random_.between(0.00005, 0.0003);
    object.textureWavelength_m = random_.between(0.002, 0.006);
  }
  objects_.push_back(object);
}

void EditScene::setPose(FuzzObject& object, const Pose& pose) {
  object.pose = pose;
  object.poseRevision = revision_ + 1;
}

void EditScene::setMesh(FuzzObject& object, std::size_t mesh) {
  object.mesh = mesh;
  ++object.shape;
}

/// Control points of the mesh's box go somewhere else.
void EditScene::pullLattice(FuzzObject& object) {
  constexpr double kPull = 0.15;  // of the box
  std::size_t root = object.mesh;
  while (run_.meshes[root].refitted) root = *run_.meshes[root].refitted;
  const std::vector<Vec3f> rest = run_.meshes[root].mesh.vertices;
  Vec3f low = rest.front();
  Vec3f high = low;
  for (const Vec3f v : rest) {
    low = glm::min(low, v);
    high = glm::max(high, v);
  }
  Lattice lattice{Vec3(low), Vec3(high - low), {3, 3, 3}, {}};
  lattice.control_m = FreeForm::atRest(lattice.low_m, lattice.size_m, lattice.points);
  const double pull = random_.chance(0.5) ? kPull : kPull / 10;
  for (Vec3f& point : lattice.control_m) {
    const double part = random_.between(0, pull);
    point += Vec3f(part * random_.direction() * lattice.size_m);
  }
  FuzzMesh pulled{shapedBy(lattice, rest), run_.meshes[root].mesh.triangles, {}};
  run_.meshes.push_back({std::move(pulled), object.mesh});
  canMove_.push_back(false);
  setMesh(object, run_.meshes.size() - 1);
}

/// @return Whether there is something to edit so.
bool EditScene::tryEdit(int kind) {
  const std::string name = kKinds[static_cast<std::size_t>(kind)];
  if (name == "add") {
    Pose pose = somePose();
    if (random_.chance(0.6)) pose.position = hip_ + 0.01 * normalVector(random_);
    add(pose);
    return true;
  }
  FuzzObject& object = objects_[touchedOrSome()];
  if (object.pendingRemoval) return false;
  if (name == "remove") {
    if (std::ranges::count(objects_, false, &FuzzObject::pendingRemoval) < 2) return false;
    object.pendingRemoval = true;
  } else if (name == "move") {
    const double far_m = random_.chance(0.6) ? 0.0003 : 0.01;
    setPose(object, {object.pose.rotation, object.pose.position + far_m * normalVector(random_)});
  } else if (name == "turn") {
    const double angle = random_.between(0, 0.3);
    const Quat turn = glm::angleAxis(angle, random_.direction());
    setPose(object, {glm::normalize(turn * object.pose.rotation), object.pose.position});
  } else if (name == "stiffness") {
    object.stiffness_N_per_m = random_.between(100, 3100);
  } else if (name == "damping") {
    object.damping_Ns_per_m = random_.chance(0.3) ? 0 : random_.between(0, 5);
  } else if (name == "remesh") {
    setMesh(object, someMesh(object.mass_kg > 0));
  } else if (name == "lattice") {
    if (object.mass_kg > 0 || !run_.meshes[object.mesh].mesh.closed()) return false;
    pullLattice(object);
  } else if (name == "softness") {
    if (!features_.soft) return false;
    if (object.tissue && random_.chance(0.5)) {
      object.tissue.reset();
    } else {
      object.tissue = someTissue();
    }
  } else if (name == "friction") {
    if (!features_.friction) return false;
    object.friction = object.friction > 0 && random_.chance(0.5) ? 0 : random_.between(0.1, 1);
  } else if (name == "texture") {
    if (!features_.texture) return false;
    const bool off = object.textureAmplitude_m > 0 && random_.chance(0.5);
    object.textureAmplitude_m = off ? 0 : random_.between(0.00005, 0.0003);
    object.textureWavelength_m = random_.between(0.002, 0.006);
    object.bumpMapped = random_.below(2) == 0;
  } else if (name == "shading") {
    if (!features_.shading) return false;
    object.crease_rad = object.crease_rad > 0 ? 0 : std::numbers::pi / 3;
  } else {
    if (!features_.moving || !canMove_[object.mesh]) return false;
    object.mass_kg = object.mass_kg > 0 ? 0 : random_.between(0.1, 1);
  }
  return true;
}

std::string EditScene::edit() {
  int kind = 0;
  do {
    kind = random_.below(static_cast<int>(kKinds.size()));
  } while (!tryEdit(kind));
  return kKinds[static_cast<std::size_t>(kind)];
}

/// Towards a random place of an object, or into it, until it presses back.
void EditScene::press() {
  const FuzzObject object = objects_[someObject()];
  const FuzzMesh& mesh = run_.meshes[object.mesh].mesh;
  Vec3 place = mesh.middleOf(static_cast<std::size_t>(random_.below(static_cast<int>(mesh.triangles.size()))));
  constexpr double kFarthest_m = 0.06;  // of a sheet only the middle
  if (glm::length(place) > kFarthest_m) place *= kFarthest_m / glm::length(place);
  const Vec3 target = toWorld(object.pose, place * random_.between(0.75, 1));
  const double most_m = kApproach_m_per_s * run_.period_s();
  for (std::uint64_t i = 0; i < ticks(kLongestApproach_s); ++i) {
    const Vec3 way = target - hip_;
    const double left_m = glm::length(way);
    const TelemetrySample& sample = drive_.sample();
    const FuzzObject* touched = drive_.object(sample.object);
    const double depth_m = glm::distance(drive_.state().contact.ihip, drive_.state().contact.hip);
    if (touched != nullptr && depth_m * touched->stiffness_N_per_m > kMaxPress_N) break;
    if (left_m < 1e-9) break;
    step(hip_ + way * std::min(1.0, most_m / left_m));
  }
  for (std::uint64_t i = 0; i < ticks(kRest_s); ++i) step(hip_);
}

void EditScene::watch(double seconds) {
  for (std::uint64_t i = 0; i < ticks(seconds); ++i) {
    step(hip_);
    judge_.observe(drive_, hip_);
  }
}

EditVerdict EditScene::next() {
  constexpr std::uint64_t kMaxBetween = 200;  // ticks, of two edits
  press();
  inContact_ = drive_.sample().object != 0;
  EditWindow window{"", objects_.size(), drive_.tick(), 0, 0};
  const int manner = random_.below(10);
  judge_.begin(drive_);
  std::string kind = edit();
  if (manner == 0) {
    static_cast<void>(edit());
    kind = "two at once";
  }
  ++revision_;
  publish();
  if (manner == 1) {
    const auto between = 1 + static_cast<std::uint64_t>(random_.below(kMaxBetween));
    watch(static_cast<double>(between) * run_.period_s());
    static_cast<void>(edit());
    ++revision_;
    publish();
    kind = "one after another";
  }
  window.edit = kind;
  watch(kLeaves_s);
  if (std::erase_if(objects_, [](const FuzzObject& o) { return o.pendingRemoval; }) > 0) publish();
  watch(kSettled_s - kLeaves_s);
  window.settled = drive_.tick();
  judge_.settle(drive_);
  watch(kWatched_s - kSettled_s);
  window.end = drive_.tick();
  run_.windows.push_back(window);
  return judge_.end();
}

}  // namespace haptics::eval
