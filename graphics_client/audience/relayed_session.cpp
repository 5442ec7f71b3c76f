#include "graphics_client/audience/relayed_session.h"

#include <string>
#include <utility>

#include "common/wire/convert.h"
#include "common/wire/framing.h"
#include "common/wire/snapshot.h"
#include "graphics_client/audience/published_messages.h"

namespace haptics {
namespace {

constexpr const char* kWatchOnly = "is only watched here; connect to the server itself to change it";

}  // namespace

RelayedSession::RelayedSession(StoredSession stored, Send send, FetchAsset fetch)
    : stored_(std::move(stored)),
      send_(std::move(send)),
      fetch_(std::move(fetch)),
      revision_(stored_.scene.revision()) {}

Result<void> RelayedSession::fromClient(const v1::Envelope& envelope) {
  v1::Envelope answer;
  switch (envelope.body_case()) {
    case v1::Envelope::kHello:
      greet();
      return {};
    case v1::Envelope::kAssetRequest: {
      const auto hash = hashFromWire(envelope.asset_request().hash(), "asset_request.hash");
      if (!hash) return tl::unexpected<Error>(hash.error());
      fetch_(*hash, envelope.asset_request().offset());
      return {};
    }
    case v1::Envelope::kEditRequest:
      refuseEdit(envelope.edit_request());
      return {};
    case v1::Envelope::kAssetUpload:
      refuseUpload(envelope.asset_upload());
      return {};
    case v1::Envelope::kDumpRequest:
      answer.mutable_dump_reply()->set_reason(std::string("the session ") + kWatchOnly);
      break;
    case v1::Envelope::kLeadHand:
      answer.mutable_hand_leader()->set_hand(envelope.lead_hand().hand());
      if (envelope.lead_hand().lead()) {
        answer.mutable_hand_leader()->set_refused(std::string("the session ") + kWatchOnly);
      }
      break;
    default:
      return {};  // nothing here has an answer to it
  }
  send_(answer);
  return {};
}

void RelayedSession::greet() {
  v1::Envelope envelope;
  v1::Welcome& welcome = *envelope.mutable_welcome() = stored_.welcome;
  welcome.set_revision(stored_.scene.revision());
  welcome.set_root(stored_.scene.root().asBytes());
  welcome.set_resumed(false);
  welcome.set_may_edit(false);
  welcome.clear_datagram_port();
  welcome.clear_datagram_cookie();
  send_(envelope);
  sendSnapshot(stored_.scene, kMaxChunkBytes, send_);
  greeted_ = true;
}

void RelayedSession::refuseEdit(const v1::EditRequest& request) {
  v1::Envelope answer;
  answer.mutable_edit_reply()->set_client_seq(request.client_seq());
  answer.mutable_edit_reply()->mutable_rejected()->set_field("session");
  answer.mutable_edit_reply()->mutable_rejected()->set_reason(kWatchOnly);
  send_(answer);
}

void RelayedSession::refuseUpload(const v1::AssetUpload& upload) {
  if (upload.chunk().offset() != 0 || !upload.cancel().empty()) return;  // answered at its beginning
  v1::Envelope answer;
  answer.mutable_asset_upload_reply()->set_hash(upload.chunk().hash());
  answer.mutable_asset_upload_reply()->set_field("session");
  answer.mutable_asset_upload_reply()->set_reason(kWatchOnly);
  send_(answer);
}

Result<void> RelayedSession::checkEpoch(std::uint64_t epoch) const {
  if (epoch == stored_.welcome.epoch()) return {};
  return refused("", "the server was started anew");
}

Result<void> RelayedSession::commit(std::string_view bytes) {
  auto published = readPublishedCommit(bytes);
  if (!published) {
    ++ignored_;
    return {};
  }
  if (auto same = checkEpoch(published->epoch()); !same) return same;
  const std::uint64_t revision = published->commit().revision();
  if (revision <= revision_) return {};  // stored when the session was read, or published again
  if (revision != revision_ + 1) return refused("", "commits were missed after revision " + std::to_string(revision_));
  revision_ = revision;
  heartbeatsAhead_ = 0;
  v1::Envelope envelope;
  *envelope.mutable_commit() = std::move(*published->mutable_commit());
  send_(envelope);
  return {};
}

Result<void> RelayedSession::sample(std::string_view bytes) {
  auto live = readLiveMessage(bytes);
  if (!live) {
    ++ignored_;
    return {};
  }
  if (live->has_heartbeat()) {
    if (auto same = checkEpoch(live->epoch()); !same) return same;
    return heartbeat(live->heartbeat());
  }
  if (live->epoch() != stored_.welcome.epoch()) return {};
  v1::Envelope envelope;
  *envelope.mutable_telemetry() = std::move(*live->mutable_telemetry());
  send_(envelope);
  return {};
}

/// Heartbeats and commits take different ways: the client gets only those that name the revision that it holds.
Result<void> RelayedSession::heartbeat(const v1::Heartbeat& message) {
  if (message.revision() < revision_) return {};
  if (message.revision() > revision_) {
    if (++heartbeatsAhead_ <= kMaxHeartbeatsAhead) return {};
    return refused("", "commits were missed after revision " + std::to_string(revision_));
  }
  heartbeatsAhead_ = 0;
  v1::Envelope envelope;
  *envelope.mutable_heartbeat() = message;
  send_(envelope);
  return {};
}

}  // namespace haptics
