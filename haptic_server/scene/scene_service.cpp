#include "haptic_server/scene/scene_service.h"

#include <algorithm>
#include <exception>
#include <utility>

#include "common/clock/monotonic.h"
#include "common/interruption/interruption.h"
#include "common/scene/deformed_hash.h"
#include "haptic_server/scene/lost_parts.h"

namespace haptics {
namespace {

/// Between two takings-in of dents, nanoseconds: each is a commit with all of an object's moved vertices. Shorter costs
/// lines more; longer lets a long stroke run out of places for its marks.
constexpr std::uint64_t kBakeEvery_ns = 200'000'000;

/// Between two attempts to make a scene for the servo that there was no memory for.
constexpr std::uint64_t kCatchUpEvery_ns = 1'000'000'000;

}  // namespace

SceneService::SceneService(Options options, SceneMailbox& mailbox)
    : options_(std::move(options)),
      mailbox_(mailbox),
      library_(options_.assetFolders, store_, options_.device),
      sequencer_(newEpoch(), library_, {.driven_triangles = mostDrivenTriangles(options_.device)}),
      servoScenes_(options_.makePlan, options_.device),
      published_(sequencer_.history()) {}

SceneService::~SceneService() { stop(); }

Result<std::vector<std::string>> SceneService::loadStartScene(const Transaction& scene) {
  const Submission submission{kServerSession, history()->version.revision() + 1, scene};
  const auto before = sequencer_.history();
  const EditOutcome outcome = sequencer_.submitOwn(submission);
  if (sequencer_.history() != before) publish(before);
  if (const auto* error = std::get_if<Error>(&outcome)) return tl::unexpected(*error);
  if (const auto* conflict = std::get_if<EditConflict>(&outcome)) return refused("preconditions", conflict->reason);
  return std::get<std::shared_ptr<const AcceptedEdit>>(outcome)->reports;
}

std::vector<std::string> SceneService::resume(SequencerState state, AssetReader readAsset, EditJournal& journal) {
  readAsset_ = std::move(readAsset);
  journal_ = &journal;
  std::map<ContentHash, Result<std::shared_ptr<const Asset>>> read;  // each once
  const auto lookUp = [&](const AssetName& name) {
    const auto at = read.find(name.hash);
    return at != read.end() ? at->second : read.emplace(name.hash, findOrRead(name)).first->second;
  };
  RestoredState restored = restore(std::move(state), lookUp, store_, newEpoch());
  lostAtStart_ = restored.state.lost;
  sequencer_.resume(std::move(restored.state), std::move(restored.assets), journal);
  if (restored.changed) sequencer_.checkpoint();
  published_ = sequencer_.history();
  publishToServo(ServoSceneBuilder::Plan::kKeep);
  return std::move(restored.warnings);
}

bool SceneService::checkpoint(std::function<void()> before) {
  return enqueue(kServerSession, sizeof(Job), std::function<void()>([this, before = std::move(before)] {
                   before();
                   sequencer_.checkpoint();
                 }));
}

Result<std::shared_ptr<const Asset>> SceneService::findOrRead(const AssetName& name) {
  if (auto known = store_.find(name.hash)) return known;
  auto bytes = readAsset_(name.hash);
  if (!bytes) return refused("", bytes.error().text());
  auto asset = store_.internEncoded(name, *std::move(bytes));
  if (!asset) return refused("", "is damaged: " + asset.error().text());
  return asset;
}

std::vector<std::string> SceneService::lostParts() const {
  std::vector<std::string> objects;
  const auto now = history();
  for (const auto& before : lostAtStart_) {
    const auto object = now->version.find(before->id);
    std::string text;
    if (object) {
      for (const std::string& part : haptics::lostParts(*object, *before)) text += (text.empty() ? ": " : ", ") + part;
    }
    if (!text.empty()) objects.push_back(object->name + text);
  }
  return objects;
}

/// An asset that objects have lost is here: they have it again.
void SceneService::restoreLostParts(const ContentHash& asset) {
  const auto before = sequencer_.history();
  const auto lookUp = [this](const AssetName& name) { return findOrRead(name); };
  std::vector<ObjectRecord> objects;
  Sequencer::Assets assets;
  for (const auto& lost : lostAtStart_) {
    const auto now = before->version.find(lost->id);
    if (!now) continue;
    const ObjectRecord restored = withLostParts(*now, *lost);
    if (restored == *now || !std::ranges::count(restored.assets(), asset, &AssetName::hash)) continue;
    RecoveredObject held = recoverObject(restored, lookUp, store_);
    if (held.record == *now) continue;
    held.record.revision = before->version.revision() + 1;
    objects.push_back(std::move(held.record));
    assets[now->id] = std::move(held.assets);
  }
  if (objects.empty() || !sequencer_.replaceObjects(objects, assets)) return;
  publish(before);
  for (const ObjectRecord& object : objects)
    log("object \"" + object.name + "\": what was lost of it was uploaded and is here again");
}

bool SceneService::show(SceneVersion version, Sequencer::Assets assets) {
  return enqueue(kServerSession, sizeof(Job),
                 std::function<void()>([this, version = std::move(version), assets = std::move(assets)] {
                   sequencer_.show(version, assets);
                   publishHistory();
                 }));
}

std::shared_ptr<const SceneHistory> SceneService::history() const {
  const std::lock_guard lock(historyMutex_);
  return published_;
}

std::shared_ptr<const SceneService::DrivenShapes> SceneService::drivenShapes() const {
  const std::lock_guard lock(historyMutex_);
  return drivenShapes_;
}

void SceneService::setListener(HistoryListener listener) {
  const std::lock_guard lock(listenerMutex_);
  listener_ = std::move(listener);
  if (listener_) listener_(history());
}

/// Where what moves has come to, and which dents stay.
void SceneService::followServo() {
  const MotionState* motion = options_.takeMotion ? options_.takeMotion() : nullptr;
  if (motion == nullptr) return;
  servoScenes_.follow(*motion);
  permanentDents_ = permanentDents(*motion, handled_);
  permanentDentsAt_ = motion->sceneRevision;
}

EditOutcomes SceneService::apply(std::span<const Submission> submissions, AssetResolver& resolver,
                                 const std::stop_token& unwanted) {
  if (!options_.readOnlyReason.empty())
    return std::vector<EditOutcome>(submissions.size(), Error{"", options_.readOnlyReason});
  const auto before = sequencer_.history();
  const std::uint64_t samples = sequencer_.kinematicSamples();
  auto outcomes = decide(submissions, resolver, unwanted);
  try {
    if (sequencer_.history() != before) {
      publish(before);
    } else if (sequencer_.kinematicSamples() != samples) {
      publishToServo(ServoSceneBuilder::Plan::kKeep);
    }
  } catch (const std::exception& failure) {  // what was decided is decided
    isBehind_ = isUnheard_ = true;
    try {
      log(std::string("warning: not all have heard of an edit yet: ") + failure.what() + "; trying again");
    } catch (const std::exception&) {  // nor is there memory to say so
    }
  }
  return outcomes;
}

void SceneService::publish(const std::shared_ptr<const SceneHistory>& before) {
  const auto& now = sequencer_.history();
  publishHistory();  // first: what the network sends, it sends while the servo's scene is made
  publishToServo(ServoSceneBuilder::Plan::kKeep);
  for (std::uint64_t revision = before->version.revision() + 1; revision <= now->version.revision(); ++revision) {
    for (const std::string& report : now->find(revision)->reports) log(report);
  }
}

/// Until then an edit may be given up, by the server or by whoever asked for it.
EditOutcomes SceneService::decide(std::span<const Submission> submissions, AssetResolver& resolver,
                                  const std::stop_token& unwanted) {
  std::stop_source either;
  const auto stop = [&either] { either.request_stop(); };
  const std::stop_callback onStop(Interruptible::token(), stop);
  const std::stop_callback onUnwanted(unwanted, stop);
  const Interruptible work(either.get_token());
  try {
    return sequencer_.submit(submissions, resolver);
  } catch (const std::exception& failure) {
    const Error error{"", std::string("the server could not carry out the edit: ") + failure.what()};
    return std::vector<EditOutcome>(submissions.size(), error);
  }
}

/// Into the objects' surfaces, by edits of the server's own: dents that stay are part of the scene like all else.
void SceneService::bakeDents() {
  const std::uint64_t now_ns = options_.now_ns();
  if (permanentDents_.empty() || now_ns < bakeAfter_ns_) return;
  bakeAfter_ns_ = now_ns + kBakeEvery_ns;
  std::erase_if(permanentDents_, [this](const auto& entry) { return bakeDents(entry.first, entry.second); });
}

/// False: they are to be tried again.
bool SceneService::bakeDents(ObjectId object, std::span<const PermanentDent> dents) {
  const auto before = sequencer_.history();
  const auto record = before->version.find(object);
  if (!record) {
    handled_.erase(object);
    return true;
  }
  if (permanentDentsAt_ < record->revision)
    return true;  // the object was edited since: the servo tells anew once it has adopted that
  const BakeResult taken = bake(record->deformation, sequencer_.assetsOf(object), dents);
  if (taken.releasedUpTo > 0) servoScenes_.releaseDents(object, taken.releasedUpTo);
  if (taken.upTo > 0) {
    std::shared_ptr<const Asset> asset;
    std::optional<ContentHash> residue;
    SetDeformation set{ObjectRef{object}, {}};
    set.deformation.residue.emplace();
    if (!taken.residue.vertex.empty()) {
      asset = store_.intern(taken.residue);
      residue = asset->name.hash;
      *set.deformation.residue = AssetSource{*residue};
    }
    servoScenes_.setBakedDents(object, residue, taken.upTo);
    if (residue != record->deformation.residue) {
      const Submission submission{kServerSession, before->version.revision() + 1, {{}, {std::move(set)}}};
      static_cast<void>(apply(std::span(&submission, 1), library_));
      if (sequencer_.history() == before) return false;
    } else {
      publishToServo(ServoSceneBuilder::Plan::kKeep);
    }
    handled_[object].upTo = taken.upTo;
  } else if (taken.releasedUpTo > 0) {
    publishToServo(ServoSceneBuilder::Plan::kKeep);
  }
  if (taken.releasedUpTo > 0) handled_[object].releasedUpTo = taken.releasedUpTo;
  return true;
}

std::optional<ContentHash> SceneService::deformedHash(const SceneVersion& scene,
                                                      std::span<const ObjectDent> dents) const {
  std::vector<std::shared_ptr<const Asset>> used;  // none goes while it is looked at
  const auto find = [&]<class Kind>(const ContentHash& hash, const Kind*) {
    const auto asset = as<Kind>(store_.find(hash));
    used.push_back(asset);
    return asset.get();
  };
  const HeldShapes held{.vertices = [&](const ContentHash& mesh) -> const std::vector<Vec3f>* {
                          const auto* asset = find(mesh, static_cast<const MeshAsset*>(nullptr));
                          return asset == nullptr ? nullptr : &asset->mesh->vertices;
                        },
                        .residue = [&](const ContentHash& residue) -> const MovedVertices* {
                          const auto* asset = find(residue, static_cast<const MovedVerticesAsset*>(nullptr));
                          return asset == nullptr ? nullptr : asset->moved.get();
                        }};
  return haptics::deformedHash(scene, held, dents);
}

void SceneService::publishHistory() {
  const std::lock_guard lock(listenerMutex_);
  {
    const std::lock_guard historyLock(historyMutex_);
    published_ = sequencer_.history();
  }
  if (listener_) listener_(sequencer_.history());
  isUnheard_ = false;
}

void SceneService::publishDrivenShapes() {
  if (drivenShapes_->empty() && sequencer_.drivenShapes().empty()) return;
  auto shapes = std::make_shared<const DrivenShapes>(sequencer_.drivenShapes());
  const std::lock_guard lock(historyMutex_);
  drivenShapes_ = std::move(shapes);
}

/// Where that cannot be done now, as for want of memory, the servo goes on with the scene that it has: what was accepted
/// stays accepted, and is felt when it can be, or when an edit has made the scene smaller.
void SceneService::publishToServo(ServoSceneBuilder::Plan plan) {
  publishDrivenShapes();
  if (isBehind_ && options_.now_ns() < catchUpAfter_ns_) return;
  try {
    mailbox_.publish(servoScenes_.make(sequencer_, options_.now_ns(), plan, options_.onServoScene));
    isBehind_ = false;
  } catch (const Interrupted&) {
  } catch (const std::exception& failure) {
    if (stop_.stop_requested()) return;
    catchUpAfter_ns_ = options_.now_ns() + kCatchUpEvery_ns;
    if (std::exchange(isBehind_, true)) return;
    log("warning: revision " + std::to_string(sequencer_.history()->version.revision()) +
        " is not felt yet, the servo keeps the scene before it: " + failure.what() + "; trying again");
  }
}

void SceneService::log(const std::string& line) const {
  if (options_.log) options_.log(line);
}

}  // namespace haptics
