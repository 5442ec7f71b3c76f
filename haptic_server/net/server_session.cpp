#include "haptic_server/net/server_session.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <new>
#include <utility>
#include <variant>

#include "common/text/printable.h"
#include "common/wire/convert.h"
#include "common/wire/snapshot.h"
#include "haptic_server/net/scene_messages.h"
#include "haptic_server/scene/scene_limits.h"

namespace haptics {
namespace {

constexpr const char* kBecomeEditor = "connect with editor.credentials to change the scene";

Error notAnEditor() { return {"role", std::string("is view; ") + kBecomeEditor}; }

bool isControl(char c) {
  constexpr unsigned char kFirstPrintable = 0x20, kDelete = 0x7F;
  return static_cast<unsigned char>(c) < kFirstPrintable || c == kDelete;
}

bool namesAnId(const Operation& operation) {
  return std::visit(
      [](const auto& op) {
        if constexpr (requires { op.object; }) return std::holds_alternative<ObjectId>(op.object.value);
        return false;
      },
      operation);
}

/// Whether it means something else in another epoch, where ids and revisions are others.
bool restsOnState(const Transaction& transaction) {
  return !transaction.preconditions.empty() || std::ranges::any_of(transaction.operations, namesAnId);
}

}  // namespace

ServerSession::ServerSession(Transport& transport, SessionHost& host, const ServerIdentity& identity,
                             const SessionLimits& limits)
    : transport_(transport),
      host_(host),
      identity_(identity),
      limits_(limits),
      assets_(limits.frames.chunk_bytes),
      editGate_(limits.editsPerSecond, limits.editBurst),
      uploads_(host, host, limits.frames.chunk_bytes) {}

void ServerSession::start() {
  started_ns_ = lastByte_ns_ = lastTaken_ns_ = host_.now_ns();
  transport_.start({.received = [this](std::span<const char> bytes) { received(bytes); },
                    .drained = [this] { pump(); },
                    .closed = [this](const std::string& why) { closed(why); }});
}

void ServerSession::poll() {
  if (phase_ == Phase::kClosed) return;
  const std::uint64_t now_ns = host_.now_ns();
  if (phase_ == Phase::kAwaitingHello) {
    if (now_ns - started_ns_ >= kHelloWithin_ns) refuse("hello", "none came within 3 s of connecting");
    return;
  }
  if (now_ns - lastByte_ns_ >= kSilence_ns) return refuse("heartbeat", "not a byte came for 3 s");
  noteProgress(now_ns);
  if (now_ns - lastTaken_ns_ >= kTakesNothing_ns)
    return refuse("", "the client reads too slowly: for 10 s it has taken none of the bytes that are waiting for it");
  if (const auto stalled = uploads_.poll(now_ns)) send(*stalled);
  if (now_ns >= nextHeartbeat_ns_) {
    sendHeartbeat();
    tellProgress();
    nextHeartbeat_ns_ = now_ns + kHeartbeat_ns;
  }
  pump();
}

void ServerSession::offerTelemetry(const TelemetrySample& sample, const TelemetrySample* second) {
  telemetry_.offer(sample, second);
  pump();
}

void ServerSession::adopted(std::uint64_t revision, std::uint64_t tick) {
  adoptions_.adopted(revision, tick);
  sendLive();
}

void ServerSession::editDecided(std::uint64_t clientSeq, const EditOutcome& outcome) {
  undecided_.erase(clientSeq);
  if (phase_ != Phase::kLive) return;
  v1::Envelope envelope;
  v1::EditReply& reply = *envelope.mutable_edit_reply();
  reply.set_client_seq(clientSeq);
  toWire(outcome, limits_.frames.frame_bytes, reply);
  send(envelope);
  const auto* accepted = std::get_if<std::shared_ptr<const AcceptedEdit>>(&outcome);
  if (!accepted) return;
  const Commit& commit = (*accepted)->commit;
  for (const ObjectRecord& record : commit.put) {
    for (const AssetName& name : record.assets()) uploads_.named(name.hash);
  }
  adoptions_.accepted(clientSeq, commit.revision);
  sendLive();
}

void ServerSession::editProgress(std::uint64_t clientSeq, WorkStage stage, double share) {
  if (phase_ != Phase::kLive) return;
  if (const auto at = undecided_.find(clientSeq); at != undecided_.end()) at->second = {stage, share};
  sendProgress(clientSeq, stage, share, 0);
}

void ServerSession::tellProgress() {
  if (undecided_.empty()) return;
  const auto waits = host_.waiting(id_);
  for (const auto& [clientSeq, progress] : undecided_) {
    if (waits && waits->clientSeq == clientSeq) {
      sendProgress(clientSeq, WorkStage{}, 0, waits->place);
    } else {
      sendProgress(clientSeq, progress.stage, progress.share, 0);
    }
  }
}

void ServerSession::sendProgress(std::uint64_t clientSeq, WorkStage stage, double share, std::size_t place) {
  v1::Envelope envelope;
  v1::EditProgress& progress = *envelope.mutable_edit_progress();
  progress.set_client_seq(clientSeq);
  progress.set_stage(static_cast<v1::EditProgress::Stage>(stage));
  progress.set_share(share);
  progress.set_place(place);
  send(envelope);
}

void ServerSession::assetDecided(const ContentHash& hash, Result<std::shared_ptr<const Asset>> outcome) {
  const auto reply = uploads_.decided(hash, std::move(outcome));
  if (reply && phase_ == Phase::kLive) send(*reply);
}

void ServerSession::refuse(const std::string& field, const std::string& reason) {
  if (phase_ == Phase::kClosed) return;
  v1::Envelope envelope;
  envelope.mutable_refusal()->set_field(asUtf8(field));
  envelope.mutable_refusal()->set_reason(asUtf8(reason));
  envelope.mutable_refusal()->set_supported_version(kProtocolVersion);
  const std::string why = Error{field, reason}.text();
  phase_ = Phase::kClosed;
  host_.refused(why);
  send(envelope);
  transport_.close(why);
}

void ServerSession::close(const std::string& why) {
  phase_ = Phase::kClosed;
  transport_.close(why);
}

void ServerSession::received(std::span<const char> bytes) {
  if (phase_ == Phase::kClosed) return;
  lastByte_ns_ = host_.now_ns();
  try {
    handleAll(bytes);
  } catch (const std::bad_alloc&) {
    refuse("", "the server has no memory for what the client sent");
  } catch (const std::exception& failure) {
    refuse("", std::string("the server could not carry out what the client sent: ") + failure.what());
  }
}

void ServerSession::handleAll(std::span<const char> bytes) {
  const bool views = phase_ == Phase::kLive && role_ == Role::kView;
  if (views && !viewerBytes_.allow(lastByte_ns_, static_cast<double>(bytes.size()))) {
    return refuse("role", "is view, and the client sends more than 64 KiB a second; " + std::string(kBecomeEditor));
  }
  decoder_.feed(bytes);
  while (phase_ != Phase::kClosed) {
    const auto envelope = decoder_.next();
    if (!envelope) {
      return refuse(envelope.error().field,
                    envelope.error().reason + (views ? "; the role is view: " + std::string(kBecomeEditor) : ""));
    }
    if (!*envelope) break;
    handle(**envelope);
  }
  pump();
}

void ServerSession::closed(const std::string& why) {
  phase_ = Phase::kClosed;
  uploads_.clear();
  host_.ended(why);
}

void ServerSession::handle(const v1::Envelope& envelope) {
  if (envelope.protocol_version() != kProtocolVersion) {
    return refuse("protocol_version", "is " + std::to_string(envelope.protocol_version()) + "; this server speaks " +
                                          std::to_string(kProtocolVersion));
  }
  if (phase_ == Phase::kLive) return handleLive(envelope);
  if (!envelope.has_hello()) return refuse("hello", "is what a client sends first");
  handle(envelope.hello());
}

void ServerSession::handleLive(const v1::Envelope& envelope) {
  switch (envelope.body_case()) {
    case v1::Envelope::kHeartbeat:
      return;  // its bytes have counted as life
    case v1::Envelope::kAssetRequest:
      return handle(envelope.asset_request());
    case v1::Envelope::kSubscribe:
      return handle(envelope.subscribe());
    case v1::Envelope::kEditRequest:
      return handle(envelope.edit_request());
    case v1::Envelope::kClockProbe:
      return handle(envelope.clock_probe());
    case v1::Envelope::kStatusRequest:
      return reportStatus(envelope.status_request().deformed());
    case v1::Envelope::kAssetUpload:
      return handle(envelope.asset_upload());
    case v1::Envelope::kDumpRequest:
      return dump();
    case v1::Envelope::kLeadHand:
      return handle(envelope.lead_hand());
    case v1::Envelope::kHandTarget:
      return handle(envelope.hand_target());
    case v1::Envelope::kSetWorkspace:
      return handle(envelope.set_workspace());
    case v1::Envelope::kAddWrench:
      return handle(envelope.add_wrench());
    default:
      return refuse("body", "is a message that a client does not send, or not after Hello");
  }
}

void ServerSession::handle(const v1::Hello& hello) {
  if (hello.session() == kServerSession) return refuse("hello.session", "is 0; choose one at random");
  if (hello.client_name().size() > kMaxClientName) {
    return refuse("hello.client_name", "is longer than " + std::to_string(kMaxClientName) + " bytes");
  }
  if (std::ranges::any_of(hello.client_name(), isControl)) {
    return refuse("hello.client_name", "holds a control character; give printable text");
  }
  const auto role = host_.admit(hello.session(), hello.token());
  if (!role) return refuse(role.error().field, role.error().reason);
  const auto history = host_.history();
  // A root that is no hash is the root of no revision: the client gets a snapshot.
  const auto root = ContentHash::fromBytes(hello.root());
  const bool resumed = root && history->canResumeFrom(hello.epoch(), hello.revision(), *root) &&
                       fitFrames(*history, hello.revision(), limits_.frames.frame_bytes);
  id_ = hello.session();
  name_ = hello.client_name();
  role_ = *role;
  phase_ = Phase::kLive;
  decoder_.setLimit(role_ == Role::kEdit ? limits_.frames.frame_bytes : SessionLimits::kViewerFrameBytes);
  nextHeartbeat_ns_ = host_.now_ns();  // at once: it also says what the servo feels

  v1::Envelope envelope;
  v1::Welcome& welcome = *envelope.mutable_welcome();
  epoch_ = history->epoch;
  welcome.set_epoch(history->epoch);
  welcome.set_revision(history->version.revision());
  welcome.set_root(history->version.root().asBytes());
  welcome.set_resumed(resumed);
  welcome.set_server_name(identity_.name);
  welcome.set_servo_rate_hz(identity_.servoRate_Hz);
  welcome.set_device(identity_.device);
  welcome.set_max_force_n(identity_.maxForce_N);
  welcome.set_second_device(identity_.secondDevice);
  welcome.set_second_max_force_n(identity_.secondMaxForce_N);
  welcome.set_may_edit(role_ == Role::kEdit);
  if (auto offer = host_.offerDatagrams()) {
    welcome.set_datagram_port(offer->port);
    welcome.set_datagram_cookie(std::move(offer->cookie));
  }
  send(envelope);
  host_.sessionClaimed(id_);
  if (!resumed) {
    sendSnapshot(history->version, limits_.frames.chunk_bytes, [this](v1::Envelope& message) { send(message); });
  }
  sentRevision_ = resumed ? hello.revision() : history->version.revision();
}

void ServerSession::handle(const v1::Subscribe& subscribe) {
  const double rate_Hz = subscribe.rate_hz();
  if (!std::isfinite(rate_Hz) || rate_Hz < 0) return refuse("subscribe.rate_hz", "must be finite and >= 0");
  telemetry_.setRate(std::min(rate_Hz, kMaxTelemetryRate_Hz));
  byDatagram_ = subscribe.datagrams();
  if (!subscribe.every_tick()) return batches_.stop();
  if (const TickHistory* ticks = host_.ticks(); ticks != nullptr && !batches_.wanted()) {
    batches_.start(*ticks);
    transport_.preferThroughput();
  }
}

void ServerSession::handle(const v1::AssetRequest& request) {
  const auto hash = hashFromWire(request.hash(), "asset_request.hash");
  if (!hash) return refuse(hash.error().field, hash.error().reason);
  const auto asset = host_.findAsset(*hash);
  if (!asset) {
    v1::Envelope envelope;
    envelope.mutable_asset_unavailable()->set_hash(request.hash());
    return send(envelope);
  }
  const std::size_t size = asset->bytes().size();
  if (request.offset() > size)
    return refuse("asset_request.offset", "is beyond the asset's " + std::to_string(size) + " bytes");
  if (!assets_.add(asset, request.offset())) return refuse("asset_request", "too many are waiting");
}

void ServerSession::handle(const v1::EditRequest& request) {
  const std::uint64_t clientSeq = request.client_seq();
  if (role_ != Role::kEdit) return editDecided(clientSeq, notAnEditor());
  if (!editGate_.allow(clientSeq, host_.now_ns())) return retryLater(clientSeq);
  auto transaction = fromWire(request.transaction());
  if (!transaction) return editDecided(clientSeq, std::move(transaction).error());
  if (request.epoch() != 0 && request.epoch() != host_.history()->epoch && restsOnState(*transaction)) {
    return editDecided(clientSeq, EditConflict{{}, "it was made from a state that the server has lost"});
  }
  if (request.progress()) undecided_[clientSeq] = {};
  if (host_.submitEdit(id_, clientSeq, *std::move(transaction), request.progress())) return;
  undecided_.erase(clientSeq);
  editGate_.retryLater(clientSeq);
  retryLater(clientSeq);
}

void ServerSession::retryLater(std::uint64_t clientSeq) {
  v1::Envelope envelope;
  v1::EditReply& reply = *envelope.mutable_edit_reply();
  reply.set_client_seq(clientSeq);
  const bool isRate = editGate_.cause() == EditGate::Cause::kRate;
  reply.mutable_rejected()->set_field(isRate ? "rate" : "busy");
  reply.mutable_rejected()->set_reason(isRate ? "more than 200 edits per second; send it again later"
                                              : "the server has too many edits waiting; send it again later");
  reply.mutable_rejected()->set_retry_after_ms(EditGate::kRetryAfter_ms);
  send(envelope);
}

void ServerSession::handle(const v1::AssetUpload& upload) {
  if (!upload.cancel().empty()) {
    const auto hash = hashFromWire(upload.cancel(), "asset_upload.cancel");
    if (!hash) return refuse(hash.error().field, hash.error().reason);
    return uploads_.cancel(*hash);
  }
  const auto reply = role_ == Role::kEdit ? uploads_.take(upload.chunk(), host_.now_ns())
                                          : uploads_.turnAway(upload.chunk(), notAnEditor());
  if (reply) send(*reply);
}

void ServerSession::handle(const v1::ClockProbe& probe) {
  v1::Envelope envelope;
  v1::ClockReply& reply = *envelope.mutable_clock_reply();
  reply.set_client_send_ns(probe.client_send_ns());
  reply.set_server_receive_ns(lastByte_ns_);
  reply.set_server_send_ns(host_.now_ns());
  send(envelope);
}

void ServerSession::handle(const v1::LeadHand& request) {
  if (request.hand() >= kMaxLedHands)
    return refuse("lead_hand.hand", "is neither 0, the first hand, nor 1, the second");
  followsHandLeader_[request.hand()] = true;
  auto led = request.lead() && role_ != Role::kEdit ? Result<void>(tl::unexpected(notAnEditor()))
                                                    : host_.leadHand(request.hand(), request.lead());
  sendHandLeader(request.hand(), led ? "" : led.error().text());
}

void ServerSession::handle(const v1::HandTarget& target) {
  const auto command = fromWire(target);
  if (!command) return refuse(command.error().field, command.error().reason);
  if (target.hand() >= kMaxLedHands)
    return refuse("hand_target.hand", "is neither 0, the first hand, nor 1, the second");
  host_.commandHand(target.hand(), *command);
}

void ServerSession::handle(const v1::SetWorkspace& message) {
  if (role_ != Role::kEdit) return refuse("set_workspace", notAnEditor().reason);
  const auto moved = fromWire(message).and_then(
      [&](const WorkspaceCommand& command) { return host_.moveWorkspace(message.hand(), command); });
  if (!moved) refuse(moved.error().field, moved.error().reason);
}

void ServerSession::handle(const v1::AddWrench& message) {
  if (role_ != Role::kEdit) return refuse("add_wrench", notAnEditor().reason);
  const auto added =
      fromWire(message).and_then([&](const Wrench& wrench) { return host_.addWrench(message.hand(), wrench); });
  if (!added) refuse(added.error().field, added.error().reason);
}

void ServerSession::handTargetByDatagram(const v1::HandTarget& target) {
  const auto command = fromWire(target);
  if (phase_ == Phase::kLive && command && target.hand() < kMaxLedHands) host_.commandHand(target.hand(), *command);
}

void ServerSession::handLeaderChanged(std::size_t hand) {
  if (phase_ == Phase::kLive && followsHandLeader_[hand]) sendHandLeader(hand, "");
}

void ServerSession::sendHandLeader(std::size_t hand, const std::string& refused) {
  v1::Envelope envelope;
  v1::HandLeader& message = *envelope.mutable_hand_leader();
  message.set_hand(static_cast<std::uint32_t>(hand));
  if (const auto leader = host_.handLeader(hand)) {
    message.set_led(true);
    message.set_client_name(leader->name);
    message.set_you(leader->session == id_);
  }
  message.set_refused(refused);
  send(envelope);
}

void ServerSession::dump() {
  if (role_ != Role::kEdit) return dumped(tl::unexpected(notAnEditor()));
  if (!host_.requestDump()) dumped(refused("", "this server does not record"));
}

void ServerSession::dumped(const Result<std::string>& file) {
  if (phase_ != Phase::kLive) return;
  v1::Envelope envelope;
  v1::DumpReply& reply = *envelope.mutable_dump_reply();
  if (file) {
    reply.set_file(asUtf8(*file));
  } else {
    reply.set_reason(asUtf8(file.error().text()));
  }
  send(envelope);
}

void ServerSession::reportStatus(bool deformed) {
  v1::Envelope envelope;
  v1::Status& status = *envelope.mutable_status();
  host_.fillStatus(status);
  const auto history = host_.history();
  status.set_epoch(history->epoch);
  status.set_revision(history->version.revision());
  status.set_root(history->version.root().asBytes());
  if (const auto hash = deformed ? host_.deformedHash() : std::nullopt) status.set_deformed_hash(hash->asBytes());
  send(envelope);
}

void ServerSession::pump() {
  if (phase_ != Phase::kLive) return;
  sendCommits();
  if (phase_ != Phase::kLive) return;
  const bool lineIsFree = transport_.backlog() == 0;
  if (lineIsFree || byDatagram_) sendTelemetry(lineIsFree);
  if (batches_.wanted()) sendTicks();
  if (phase_ != Phase::kLive || !lineIsFree) return;
  // Behind the newest sample one chunk, so that neither starves the other.
  if (!assets_.empty()) {
    v1::Envelope envelope;
    assets_.next(envelope);
    send(envelope);
  }
}

void ServerSession::sendTelemetry(bool lineIsFree) {
  const std::uint64_t now_ns = host_.now_ns();
  if (!telemetry_.due(now_ns)) return;
  v1::Telemetry& message = *telemetryEnvelope_.mutable_telemetry();
  toWire(telemetry_.take(now_ns), message);
  if (const TelemetrySample* second = telemetry_.second()) toWireOfSecondHand(*second, message);
  addBodiesAndDents(message);
  if (byDatagram_ && host_.sendDatagram(message)) return;
  if (lineIsFree) send(telemetryEnvelope_);
}

/// Fields that are known for the newest tick only.
void ServerSession::addBodiesAndDents(v1::Telemetry& message) {
  if (const EnergySource source = host_.largestEnergySource(); source.object != 0)
    toWire(source, *message.add_energy());
  bodies_.add(host_.motion(), message);
  for (const ObjectDent& dent : host_.motion().dents()) toWire(dent, *message.add_dent());
  host_.addShapes(message);
}

void ServerSession::sendTicks() {
  v1::TelemetryBatch& batch = *batchEnvelope_.mutable_telemetry_batch();
  while (phase_ == Phase::kLive && transport_.backlog() <= limits_.sendAhead_bytes &&
         batches_.take(*host_.ticks(), host_.now_ns(), batch)) {
    if (batch.reaches_newest()) addBodiesAndDents(*batch.mutable_sample()->rbegin());
    send(batchEnvelope_);
  }
}

void ServerSession::sendCommits() {
  const auto history = host_.history();
  while (phase_ == Phase::kLive && sentRevision_ < history->version.revision()) {
    const auto edit = history->find(sentRevision_ + 1);
    if (history->epoch != epoch_) return refuse("", "the scene is another one; connect again for a snapshot");
    if (!edit) return refuse("", "the client reads too slowly: it is more revisions behind than the server remembers");
    if (transport_.backlog() > limits_.sendAhead_bytes) return;
    v1::Envelope envelope;
    toWire(edit->commit, *envelope.mutable_commit());
    send(envelope);
    ++sentRevision_;
  }
}

void ServerSession::sendLive() {
  if (phase_ != Phase::kLive) return;
  for (v1::EditLive& live : adoptions_.take()) {
    v1::Envelope envelope;
    *envelope.mutable_edit_live() = std::move(live);
    send(envelope);
  }
}

/// Names the state that the client is in once it has read everything before this heartbeat, so that it can compare.
void ServerSession::sendHeartbeat() {
  const auto history = host_.history();
  const auto root = history->rootAt(sentRevision_);
  if (!root) return;  // so far behind that it is about to be disconnected
  v1::Envelope envelope;
  v1::Heartbeat& heartbeat = *envelope.mutable_heartbeat();
  heartbeat.set_epoch(history->epoch);
  heartbeat.set_revision(sentRevision_);
  heartbeat.set_root(root->asBytes());
  heartbeat.set_adopted_revision(adoptions_.newest().revision);
  heartbeat.set_adoption_tick(adoptions_.newest().tick);
  send(envelope);
}

void ServerSession::noteProgress(std::uint64_t now_ns) {
  const std::size_t now_bytes = transport_.backlog();
  if (now_bytes == 0 || now_bytes < backlog_bytes_) lastTaken_ns_ = now_ns;
  backlog_bytes_ = now_bytes;
}

void ServerSession::send(v1::Envelope& envelope) {
  envelope.set_protocol_version(kProtocolVersion);
  envelope.set_message_id(nextMessageId_++);
  std::string frame;
  if (const auto framed = appendFrame(frame, envelope, limits_.frames.frame_bytes); !framed) {
    return refuse(framed.error().field,
                  "of the server's next message " + framed.error().reason + "; connect again for a snapshot");
  }
  noteProgress(host_.now_ns());
  transport_.send(std::move(frame));
  backlog_bytes_ = transport_.backlog();
  if (backlog_bytes_ > limits_.backlog_bytes) {
    refuse("", "the client reads too slowly: " + std::to_string(limits_.backlog_bytes) + " bytes are waiting for it");
  }
}

void ServerSession::send(const v1::AssetUploadReply& reply) {
  v1::Envelope envelope;
  *envelope.mutable_asset_upload_reply() = reply;
  send(envelope);
}

}  // namespace haptics
