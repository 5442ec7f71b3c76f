#include "tests/sim/frame_tap.h"

#include <cmath>
#include <utility>

#include "common/wire/convert.h"

namespace haptics::sim {
namespace {

constexpr double kSeldom = 0.05;  // how often a mutant that cannot always strike does

std::string frameOf(const v1::Envelope& envelope) {
  std::string frame;
  (void)appendFrame(frame, envelope);
  return frame;
}

/// The root that the scene's records have, whatever it says itself.
ContentHash rootOf(const SceneVersion& scene) {
  std::vector<ObjectRecord> records;
  for (const auto& object : scene.objects()) records.push_back(*object);
  const auto again = SceneVersion::fromSnapshot(scene.revision(), std::move(records));
  return again ? again->root() : ContentHash{};
}

}  // namespace

FrameTap::FrameTap(std::unique_ptr<Transport> line, Mutant mutant, const Mirror& mirror, Random& random)
    : line_(std::move(line)), mutant_(mutant), mirror_(mirror), random_(random) {}
FrameTap::~FrameTap() = default;

void FrameTap::start(Events events) {
  events_ = std::make_shared<const Events>(std::move(events));
  line_->start({.received = [this](std::span<const char> bytes) { received(bytes); },
                .drained = [this] { events_->drained(); },
                .closed = [this](const std::string& why) { std::shared_ptr(events_)->closed(why); }});
}

void FrameTap::send(std::string bytes) {
  fromClient_.feed(bytes);
  while (auto envelope = fromClient_.next().value_or(std::nullopt)) {
    changeFromClient(*envelope);
    if (mutant_ == Mutant::kEditsOutOfOrder && overtaken(*envelope, v1::Envelope::kEditRequest)) continue;
    line_->send(frameOf(*envelope));
  }
}

void FrameTap::received(std::span<const char> bytes) {
  const std::weak_ptr<const bool> alive = alive_;
  fromServer_.feed(bytes);
  while (!alive.expired()) {
    auto envelope = fromServer_.next().value_or(std::nullopt);
    if (!envelope) return;
    if (drops(*envelope)) continue;
    if (mutant_ == Mutant::kCommitsReordered && overtaken(*envelope, v1::Envelope::kCommit)) continue;
    changeFromServer(*envelope);
    const bool again = mutant_ == Mutant::kCommitRepeated && envelope->has_commit() && random_.chance(kSeldom);
    std::shared_ptr(events_)->received(frameOf(*envelope));
    if (again && !alive.expired()) std::shared_ptr(events_)->received(frameOf(*envelope));
  }
}

bool FrameTap::drops(const v1::Envelope& envelope) {
  if (envelope.has_welcome()) skipsDelta_ = envelope.welcome().resumed();
  if (mutant_ == Mutant::kNoHeartbeats) return envelope.has_heartbeat();
  if (!envelope.has_commit()) return false;
  if (mutant_ == Mutant::kCommitLost) return random_.chance(kSeldom);
  const bool first = std::exchange(skipsDelta_, false);
  return mutant_ == Mutant::kResumesFromWrongRevision && first;
}

bool FrameTap::overtaken(const v1::Envelope& envelope, v1::Envelope::BodyCase kind) {
  if (envelope.body_case() != kind) return false;
  const bool fromServer = kind == v1::Envelope::kCommit;
  const auto pass = [&](const v1::Envelope& e) {
    if (fromServer) return std::shared_ptr(events_)->received(frameOf(e));
    line_->send(frameOf(e));
  };
  if (held_) {
    const std::weak_ptr<const bool> alive = alive_;
    const v1::Envelope first = *std::exchange(held_, std::nullopt);
    pass(envelope);
    if (!alive.expired()) pass(first);
    return true;
  }
  if (!random_.chance(kSeldom)) return false;
  held_ = envelope;
  return true;
}

void FrameTap::changeFromClient(v1::Envelope& envelope) {
  if (mutant_ == Mutant::kEditsOfAnotherEpoch && envelope.has_edit_request()) {
    envelope.mutable_edit_request()->clear_epoch();
  }
}

void FrameTap::changeFromServer(v1::Envelope& envelope) {
  if (flipped_) flip(envelope);
  switch (mutant_) {
    case Mutant::kNoHashCheck:
      return believe(envelope);
    case Mutant::kIncrements:
      if (envelope.has_commit()) makeIncrements(*envelope.mutable_commit());
      return believe(envelope);
    case Mutant::kLiveLostWithConnection:
      if (envelope.has_heartbeat()) envelope.mutable_heartbeat()->clear_adopted_revision();
      return;
    case Mutant::kBusyIsFinal:
      if (envelope.has_edit_reply() && envelope.edit_reply().has_rejected()) {
        envelope.mutable_edit_reply()->mutable_rejected()->clear_retry_after_ms();
      }
      return;
    case Mutant::kTornSnapshot:
      if (envelope.has_snapshot_objects() && random_.chance(0.5)) {
        auto& object = *envelope.mutable_snapshot_objects()->mutable_object(0);
        object.mutable_pose()->mutable_position()->set_x(object.pose().position().x() - 1);
      }
      return;
    default:
      return;
  }
}

void FrameTap::flip(v1::Envelope& envelope) {
  if (!envelope.has_commit() || envelope.commit().put().empty()) return;
  v1::Vector3& position = *envelope.mutable_commit()->mutable_put(0)->mutable_pose()->mutable_position();
  position.set_z(position.z() + 0.25);
  std::exchange(flipped_, nullptr)();
}

/// Every root becomes the one that the client is going to find.
void FrameTap::believe(v1::Envelope& envelope) {
  if (envelope.has_heartbeat()) envelope.mutable_heartbeat()->set_root(rootOf(mirror_.scene()).asBytes());
  if (!envelope.has_commit()) return;
  v1::Commit& message = *envelope.mutable_commit();
  message.set_prev_root(mirror_.scene().root().asBytes());
  if (const auto commit = fromWire(message)) {
    if (const auto next = mirror_.scene().apply(*commit)) message.set_root(next->root().asBytes());
  }
}

/// Values that should become what the server says become what they were here plus the change. The server's are whole
/// numbers and what flips adds a quarter, so that what the server had before is known.
void FrameTap::makeIncrements(v1::Commit& commit) {
  for (v1::ObjectState& state : *commit.mutable_put()) {
    const auto own = mirror_.scene().find(state.id());
    if (!own) continue;
    v1::Vector3& position = *state.mutable_pose()->mutable_position();
    const auto added = [](double before, double now) { return before + (now - std::floor(before)); };
    position.set_x(added(own->pose.position.x, position.x()));
    position.set_z(added(own->pose.position.z, position.z()));
  }
}

}  // namespace haptics::sim
