#include <utility>

#include "common/wire/convert.h"
#include "graphics_client/mirror/client_session.h"

// What the server says.
namespace haptics {

void ClientSession::handle(const v1::Envelope& envelope, std::uint64_t now_ns) {
  if (phase_ == Phase::kHello) return handleGreeting(envelope, now_ns);
  switch (envelope.body_case()) {
    case v1::Envelope::kSnapshotBegin:
      return handle(envelope.snapshot_begin());
    case v1::Envelope::kSnapshotObjects:
      return handle(envelope.snapshot_objects());
    case v1::Envelope::kSnapshotEnd:
      return handle(envelope.snapshot_end());
    case v1::Envelope::kCommit:
      return handle(envelope.commit());
    case v1::Envelope::kHeartbeat:
      return handle(envelope.heartbeat());
    case v1::Envelope::kAssetChunk:
      return handle(envelope.asset_chunk());
    case v1::Envelope::kAssetUnavailable:
      return assets_.unavailable(envelope.asset_unavailable().hash());
    case v1::Envelope::kTelemetry:
      if (options_.follower.telemetry) options_.follower.telemetry(envelope.telemetry());
      return show(envelope.telemetry());
    case v1::Envelope::kTelemetryBatch:
      return handle(envelope.telemetry_batch());
    case v1::Envelope::kEditReply:
      edits_.replied(envelope.edit_reply(), now_ns);
      return pumpEdits();
    case v1::Envelope::kEditProgress:
      return edits_.progress(envelope.edit_progress());
    case v1::Envelope::kEditLive:
      return edits_.live(envelope.edit_live());
    case v1::Envelope::kClockReply:
      return handle(envelope.clock_reply(), now_ns);
    case v1::Envelope::kStatus:
      for (const StatusCallback& callback : std::exchange(statusWaiters_, {})) callback(envelope.status());
      return;
    case v1::Envelope::kDumpReply:
      for (const DumpCallback& callback : std::exchange(dumpWaiters_, {})) callback(envelope.dump_reply());
      return;
    case v1::Envelope::kAssetUploadReply:
      uploads_.replied(envelope.asset_upload_reply(), now_ns);
      pumpEdits();
      return pumpUploads();
    case v1::Envelope::kHandLeader:
      hand_.answered(envelope.hand_leader());
      ++changes_;
      return;
    case v1::Envelope::kRefusal:
      return handle(envelope.refusal());
    default:
      return over("the server sent a message that is not a server's");
  }
}

void ClientSession::handleGreeting(const v1::Envelope& envelope, std::uint64_t now_ns) {
  if (envelope.has_refusal()) return handle(envelope.refusal());
  if (envelope.protocol_version() != kProtocolVersion) {
    v1::Refusal refusal;
    refusal.set_field("protocol_version");
    refusal.set_reason("the server speaks version " + std::to_string(envelope.protocol_version()) +
                       ", this client version " + std::to_string(kProtocolVersion));
    return handle(refusal);
  }
  if (!envelope.has_welcome()) return over("the server sent something before its welcome");
  handle(envelope.welcome(), now_ns);
}

void ClientSession::handle(const v1::Welcome& welcome, std::uint64_t now_ns) {
  const auto root = hashFromWire(welcome.root(), "welcome.root");
  if (!root) return over(root.error().text());
  if (welcome.epoch() == 0) return over("the server's epoch is 0");
  for (const auto& [field, text] :
       {std::pair{"server_name", &welcome.server_name()}, std::pair{"device", &welcome.device()},
        std::pair{"second_device", &welcome.second_device()}}) {
    if (text->size() > kMaxServerText_bytes) {
      return leave(
          {"welcome." + std::string(field), "is longer than " + std::to_string(kMaxServerText_bytes) + " bytes"});
    }
  }
  const bool sameState = welcome.epoch() == mirror_.epoch();
  if (welcome.resumed() && (!sameState || needsSnapshot_)) return over("the server resumes what this client lacks");
  phase_ = Phase::kSyncing;
  refused_ = false;
  needsSnapshot_ = needsSnapshot_ || !welcome.resumed();  // until the snapshot is whole
  welcome_ = welcome;
  if (options_.follower.welcomed) options_.follower.welcomed(welcome);
  ++connections_;
  ++changes_;
  if (options_.datagrams) {
    const auto server = parseEndpoint(transport_->peer());
    datagrams_.welcomed(welcome, server ? server->host : transport_->peer());
  }
  linkText_ = withTrouble("getting the scene from " + transport_->peer());
  nextHeartbeat_ns_ = nextProbe_ns_ = now_ns;
  mirror_.startTelemetry();
  mirror_.announce(welcome.revision(), *root);
  if (!sameState) {
    clock_ = {};
    probesAnswered_ = 0;
    edits_.stateLost();
  }
  pumpEdits();
  pumpUploads();
  if (!statusWaiters_.empty()) sendStatusRequest();
  if (!dumpWaiters_.empty()) sendDumpRequest();
  if (options_.followsHand) leadHand(false, now_ns);
  if (welcome.resumed()) sceneChanged();
}

/// In place of a welcome it turns this client away. Later it only says why the connection ends (a client that was
/// stopped for a while, or reads too slowly): the next one may do better at once.
void ClientSession::handle(const v1::Refusal& refusal) {
  if (refusal.field().starts_with("asset_request")) assets_ = {};  // what has come of it may be another server's
  const std::string why = Error{refusal.field(), refusal.reason()}.text().substr(0, kMaxServerText_bytes);
  if (phase_ != Phase::kHello) return over("the server ended the connection: " + why);
  refused_ = true;
  linkText_ = "refused by the server: " + why;
  over(linkText_);
}

void ClientSession::handle(const v1::SnapshotBegin& begin) {
  if (begin.object_count() > kMaxHeldObjects) {
    return leave({"snapshot_begin.object_count", "the scene has more than " + std::to_string(kMaxHeldObjects) +
                                                     " objects, the most that this client holds"});
  }
  snapshot_ = Snapshot{begin.revision(), begin.object_count(), {}};
}

void ClientSession::handle(const v1::SnapshotObjects& objects) {
  if (!snapshot_) return over("a snapshot's objects came without its beginning");
  for (const v1::ObjectState& state : objects.object()) {
    auto record = fromWire(state);
    if (!record) return resync(std::move(record.error()).within("snapshot object "));
    if (snapshot_->objects.size() == snapshot_->objectCount) return resync({"snapshot", "has more objects than said"});
    snapshot_->objects.push_back(std::move(*record));
  }
}

void ClientSession::handle(const v1::SnapshotEnd& end) {
  if (!snapshot_) return over("a snapshot ended without its beginning");
  Snapshot snapshot = *std::exchange(snapshot_, std::nullopt);
  if (end.revision() != snapshot.revision || snapshot.objects.size() != snapshot.objectCount) {
    return resync({"snapshot", "is not the one that was begun"});
  }
  const auto root = hashFromWire(end.root(), "snapshot_end.root");
  if (!root) return resync(root.error());
  auto scene = SceneVersion::fromSnapshot(snapshot.revision, std::move(snapshot.objects));
  if (!scene) return resync(scene.error());
  if (auto replaced = mirror_.replaceScene(welcome_.epoch(), std::move(*scene), *root); !replaced) {
    return resync(replaced.error());
  }
  needsSnapshot_ = false;
  if (options_.follower.snapshot) options_.follower.snapshot(mirror_.scene());
  sceneChanged();
}

void ClientSession::handle(const v1::Commit& message) {
  if (needsSnapshot_) return over("a commit came before the snapshot that it changes");
  const auto commit = fromWire(message);
  if (!commit) return resync(commit.error());
  if (auto applied = mirror_.apply(*commit); !applied) return resync(applied.error());
  for (const ObjectRecord& record : commit->put) {
    for (const AssetName& name : record.assets()) uploads_.named(name.hash);
  }
  if (commit->revision > mirror_.contents().serverRevision) mirror_.announce(commit->revision, commit->root);
  if (options_.follower.commit) options_.follower.commit(message, mirror_.scene());
  sceneChanged();
}

/// Commits go before the heartbeat that counts them: a client that is behind at two heartbeats in a row, without a
/// commit between them, has missed one.
void ClientSession::handle(const v1::Heartbeat& heartbeat) {
  const auto root = hashFromWire(heartbeat.root(), "heartbeat.root");
  if (!root) return over(root.error().text());
  mirror_.announce(heartbeat.revision(), *root);
  ++changes_;
  edits_.adopted(heartbeat.adopted_revision(), heartbeat.adoption_tick());
  if (phase_ != Phase::kLive) return;
  if (const auto sound = mirror_.audit(kAudit_bytes); !sound) return resync(sound.error());
  const SceneVersion& own = mirror_.scene();
  if (own.revision() == heartbeat.revision()) {
    behindAtHeartbeat_ = false;
    if (own.root() != *root) resync({"heartbeat.root", "differs at revision " + std::to_string(own.revision())});
    return;
  }
  if (behindAtHeartbeat_) {
    return resync({"heartbeat.revision",
                   "is " + std::to_string(heartbeat.revision()) + ", " + std::to_string(own.revision()) + " here"});
  }
  behindAtHeartbeat_ = true;
}

void ClientSession::handle(const v1::AssetChunk& chunk) {
  auto complete = assets_.take(chunk);
  if (!complete) {
    assets_ = {};  // what has come so far may be what does not fit
    return resync(complete.error());
  }
  const std::size_t whole_bytes = *complete ? (*complete)->bytes.size() : 0;
  if (mirror_.contents().assetBytes + assets_.arriving_bytes() + whole_bytes > kMaxHeldAssets_bytes) {
    return leave({"asset_chunk.total_size", "the scene's assets take more than " +
                                                std::to_string(kMaxHeldAssets_bytes >> 20) +
                                                " MiB, the most that this client holds"});
  }
  if (!*complete) return;
  if (auto added = mirror_.addAsset((*complete)->name, (*complete)->bytes); !added) return resync(added.error());
  ++changes_;
  requestAssets();
}

void ClientSession::handle(const v1::ClockReply& reply, std::uint64_t now_ns) {
  if (reply.client_send_ns() > now_ns) return;
  clock_.add(reply.client_send_ns(), reply.server_receive_ns(), reply.server_send_ns(), now_ns);
  ++probesAnswered_;
}

/// Live once the scene stands at the welcome's revision or beyond.
void ClientSession::sceneChanged() {
  ++changes_;
  behindAtHeartbeat_ = false;
  if (options_.fetchAssets) {
    if (const auto shared = shareAssets(); !shared) return resync(shared.error());
    assets_.want(mirror_.lackingAssets());
  }
  if (phase_ == Phase::kSyncing && mirror_.scene().revision() >= welcome_.revision()) becomeLive();
  requestAssets();
}

void ClientSession::show(const v1::Telemetry& sample) {
  if (mirror_.take(fromWire(sample), bodiesFromWire(sample), dentsFromWire(sample), toolFromWire(sample),
                   secondHandFromWire(sample), shapesFromWire(sample)))
    ++changes_;
}

void ClientSession::handle(const v1::TelemetryBatch& batch) {
  if (batch.sample().empty()) return;
  if (batch.reaches_newest()) show(*batch.sample().rbegin());
  if (options_.onTicks) options_.onTicks(batch);
}

void ClientSession::becomeLive() {
  phase_ = Phase::kLive;
  if (mirror_.scene().revision() == welcome_.revision() && mirror_.scene().root().asBytes() != welcome_.root()) {
    return resync({"welcome.root", "differs at revision " + std::to_string(welcome_.revision())});
  }
  if (options_.telemetryRate_Hz > 0 || options_.onTicks) sendSubscribe();
  trouble_.clear();
  linkText_ = liveText();
}

}  // namespace haptics
