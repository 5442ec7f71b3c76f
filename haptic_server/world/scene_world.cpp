#include "haptic_server/world/scene_world.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <utility>
#include <variant>

#include "common/text/printable.h"
#include "common/wire/convert.h"
#include "haptic_server/engine/step/moving_bodies.h"
#include "haptic_server/engine/step/soft_bodies.h"
#include "haptic_server/scene/asset_library.h"
#include "haptic_server/scene/dent_baking.h"
#include "haptic_server/scene/servo_scene_builder.h"
#include "haptic_server/world/input_checks.h"
#include "haptic_server/world/stepped_scene.h"

namespace haptics {
namespace {

[[nodiscard]] DeviceLimits limitsFor(const SteppedScene& scene) {
  return {.encoderStep_m = scene.config().positionStep_m,
          .stableLateral_N_per_m = scene.config().stableLateral_N_per_m,
          .period_s = scene.config().period_s,
          .stiffest_N_per_m = scene.limits().stiffness_N_per_m,
          .maxDamping_Ns_per_m = scene.limits().damping_Ns_per_m,
          .observed = scene.config().observer.has_value()};
}

[[nodiscard]] Transaction transactionOf(const Result<v1::Transaction>& message) {
  if (!message) throw InvalidInput(message.error().text());
  const auto transaction = fromWire(*message);
  if (!transaction) throw InvalidInput(transaction.error().text());
  return *transaction;
}

[[nodiscard]] World::Pose poseOf(const Pose& pose) {
  const Quat& q = pose.rotation;
  return {vectorOf(pose.position), {q.w, q.x, q.y, q.z}};
}

}  // namespace

struct SceneWorld::Impl {
  Impl(const World::Device& device, std::vector<std::string> folders)
      : scene(device),
        library({folders.begin(), folders.end()}, store, limitsFor(scene)),
        sequencer(1, library, {.driven_triangles = mostDrivenTriangles(limitsFor(scene))}),
        builder(nullptr, limitsFor(scene)) {}

  SteppedScene scene;
  AssetStore store;
  AssetLibrary library;
  Sequencer sequencer;
  ServoSceneBuilder builder;
  DentWatermarks handled;

  void publish() {
    constexpr double kNanoseconds = 1e9;
    const auto now_ns =
        static_cast<std::uint64_t>(static_cast<double>(scene.tick()) * scene.config().period_s * kNanoseconds);
    scene.publish(builder.make(sequencer, now_ns, ServoSceneBuilder::Plan::kKeep));
  }

  [[nodiscard]] std::uint64_t nextRevision() const { return sequencer.history()->version.revision() + 1; }

  std::vector<std::string> apply(const Transaction& transaction) {
    const EditOutcome outcome = sequencer.submit(kServerSession, nextRevision(), transaction);
    if (const auto* error = std::get_if<Error>(&outcome)) throw InvalidInput(asUtf8(error->text()));
    if (const auto* conflict = std::get_if<EditConflict>(&outcome)) refuse("preconditions", conflict->reason);
    publish();
    return std::get<std::shared_ptr<const AcceptedEdit>>(outcome)->reports;
  }

  /// \param inAdopted  The revision in which the dents are.
  void keep(ObjectId object, std::span<const PermanentDent> dents, std::uint64_t inAdopted) {
    const auto record = sequencer.history()->version.find(object);
    if (!record || inAdopted < record->revision) return;  // edited since: the next call sees it as it is then
    const BakeResult taken = bake(record->deformation, sequencer.assetsOf(object), dents);
    if (taken.releasedUpTo > 0) builder.releaseDents(object, taken.releasedUpTo);
    handled[object] = {std::max(handled[object].upTo, taken.upTo),
                       std::max(handled[object].releasedUpTo, taken.releasedUpTo)};
    if (taken.upTo == 0) return;
    std::shared_ptr<const Asset> asset;  // held until the edit names it
    std::optional<ContentHash> residue;
    SetDeformation set{ObjectRef{object}, {}};
    set.deformation.residue.emplace();
    if (!taken.residue.vertex.empty()) {
      asset = store.intern(taken.residue);
      residue = asset->name.hash;
      *set.deformation.residue = AssetSource{*residue};
    }
    builder.setBakedDents(object, residue, taken.upTo);
    if (residue != record->deformation.residue) (void)apply({{}, {std::move(set)}});
  }
};

SceneWorld::SceneWorld(const World::Device& device, std::vector<std::string> folders)
    : impl_(std::make_unique<Impl>(device, std::move(folders))) {}
SceneWorld::~SceneWorld() = default;
SceneWorld::SceneWorld(SceneWorld&&) noexcept = default;
SceneWorld& SceneWorld::operator=(SceneWorld&&) noexcept = default;

SceneWorld SceneWorld::load(const std::string& file, const World::Device& device, std::vector<std::string> folders) {
  const Transaction scene = transactionOf(readSceneFile(file));
  folders.insert(folders.begin(), std::filesystem::absolute(file).parent_path().string());
  SceneWorld world(device, std::move(folders));
  (void)world.impl_->apply(scene);
  return world;
}

std::vector<std::string> SceneWorld::apply(const std::string& edit) {
  return impl_->apply(transactionOf(parseSceneText(edit, "edit")));
}

std::string SceneWorld::root() const { return impl_->sequencer.history()->version.root().hex(); }

std::vector<SceneWorld::Body> SceneWorld::bodies() const {
  MotionState motion;
  (void)updateMotionState(impl_->scene.state(), impl_->scene.tick(), motion);
  std::map<ObjectId, Pose> now;
  for (const BodyState& body : motion.bodies()) now[body.object] = body.pose;
  std::vector<Body> bodies;
  for (const auto& object : impl_->sequencer.history()->version.objects()) {
    const auto moved = now.find(object->id);
    bodies.push_back({object->id, object->name, poseOf(moved == now.end() ? object->pose : moved->second)});
  }
  return bodies;
}

void SceneWorld::keepDents() {
  MotionState motion;
  (void)updateDentsState(impl_->scene.state(), impl_->scene.tick(), motion);
  const auto dents = permanentDents(motion, impl_->handled);
  if (dents.empty()) return;
  for (const auto& [object, of] : dents) impl_->keep(object, of, motion.sceneRevision);
  impl_->publish();
}

World::Sample SceneWorld::step(const World::Vector& hip_m) noexcept { return impl_->scene.step(hip_m); }

World::Sample SceneWorld::step(const World::Vector& hip_m, std::uint64_t missedTicks) noexcept {
  impl_->scene.miss(missedTicks);
  return impl_->scene.step(hip_m);
}

void SceneWorld::run(std::span<const World::Vector> hips_m, std::span<World::Sample> samples) noexcept {
  impl_->scene.run(hips_m, samples);
}

}  // namespace haptics
