#include "graphics_client/mirror/client_session.h"

#include <algorithm>
#include <utility>

#include "common/wire/convert.h"
#include "common/wire/parts.h"

// Connections, timers and what is sent. What is received: client_session_receive.cpp.
namespace haptics {

ClientSession::ClientSession(Options options)
    : options_(std::move(options)),
      random_(options_.session),
      edits_(options_.frames.frame_bytes),
      uploads_(options_.frames.chunk_bytes) {
  if (!options_.held) return;
  HeldScene held = *std::exchange(options_.held, std::nullopt);
  const ContentHash root = held.scene.root();
  (void)mirror_.replaceScene(held.epoch, std::move(held.scene), root);
}

void ClientSession::connected(Transport& transport, std::uint64_t now_ns) {
  transport_ = &transport;
  phase_ = Phase::kHello;
  over_.clear();
  decoder_ = FrameDecoder(options_.frames.frame_bytes);
  nextMessageId_ = 1;
  lastByte_ns_ = now_ns;
  snapshot_.reset();
  behindAtHeartbeat_ = false;
  if (!refused_) linkText_ = withTrouble("connected to " + transport.peer() + ", awaiting its welcome");
  ++changes_;
  sendHello();
}

void ClientSession::received(std::span<const char> bytes, std::uint64_t now_ns) {
  lastByte_ns_ = now_ns;
  decoder_.feed(bytes);
  while (transport_ != nullptr && over_.empty()) {
    const auto envelope = decoder_.next();
    if (!envelope) {
      edits_.answerUnreadable();
      return over("the server does not speak this protocol: " + envelope.error().text());
    }
    if (!*envelope) return;
    handle(**envelope, now_ns);
  }
}

void ClientSession::poll(std::uint64_t now_ns) {
  if (phase_ == Phase::kDown || connectionOver()) return;
  if (now_ns - lastByte_ns_ >= kSilence_ns) return over("the server has been silent for 3 s");
  if (transport_->backlog() > kMaxUnsent_bytes) return over("the server does not read: 64 MiB are waiting for it");
  if (phase_ == Phase::kHello) return;
  if (now_ns >= nextHeartbeat_ns_) {
    nextHeartbeat_ns_ = now_ns + kHeartbeat_ns;
    v1::Envelope envelope;
    envelope.mutable_heartbeat()->set_epoch(mirror_.epoch());
    envelope.mutable_heartbeat()->set_revision(mirror_.scene().revision());
    envelope.mutable_heartbeat()->set_root(mirror_.scene().root().asBytes());
    send(envelope);
    assets_.retry();
    requestAssets();
  }
  if (now_ns >= nextProbe_ns_) {
    nextProbe_ns_ = now_ns + (probesAnswered_ < ClockOffset::kWindow ? kFirstProbes_ns : kLaterProbes_ns);
    v1::Envelope envelope;
    envelope.mutable_clock_probe()->set_client_send_ns(now_ns);
    send(envelope);
  }
  edits_.poll(now_ns);
  uploads_.poll(now_ns);
  pumpEdits();
  pumpUploads();
  pumpHand(now_ns);
}

void ClientSession::datagramReceived(std::span<const char> bytes, const Endpoint& from, std::uint64_t now_ns) {
  const auto telemetry = datagrams_.take(bytes, from, now_ns);
  followDatagramPath();
  if (telemetry) show(*telemetry);
}

std::optional<DatagramPath::Datagram> ClientSession::nextDatagram(std::uint64_t now_ns) {
  auto datagram = datagrams_.poll(now_ns);
  followDatagramPath();
  if (datagram) return datagram;
  const auto target = std::exchange(targetByDatagram_, std::nullopt);
  if (target && datagrams_.open()) return datagrams_.withTarget(*target);
  return std::nullopt;
}

/// Telemetry takes the path that is open. Before the first Subscribe there is nothing to say.
void ClientSession::followDatagramPath() {
  if (phase_ != Phase::kLive || datagrams_.open() == byDatagram_) return;
  if (byDatagram_) ++datagramPathsLost_;
  sendSubscribe();
  linkText_ = liveText();
  ++changes_;
}

std::string ClientSession::liveText() const {
  std::string text = "connected to " + transport_->peer();
  if (!options_.datagrams || options_.telemetryRate_Hz <= 0) return text;
  if (!datagrams_.offered()) return text + "; telemetry over TCP: the server offers no UDP";
  if (byDatagram_) return text + "; telemetry over UDP";
  return text + "; telemetry over TCP: no datagram has come " + (datagramPathsLost_ > 0 ? "for 1 s" : "yet");
}

std::string ClientSession::withTrouble(std::string text) const {
  return trouble_.empty() ? text : std::move(text) + "; before: " + trouble_;
}

void ClientSession::turnedAway(const std::string& why) {
  refused_ = true;
  linkText_ = why;
}

void ClientSession::connectionLost(const std::string& why) {
  transport_ = nullptr;
  phase_ = Phase::kDown;
  over_.clear();
  snapshot_.reset();
  edits_.connectionLost();
  assets_.connectionLost();
  uploads_.connectionLost();
  datagrams_.connectionLost();
  hand_.connectionLost();
  byDatagram_ = false;
  trouble_ = why;
  if (!refused_) linkText_ = why;
  ++changes_;
}

std::uint64_t ClientSession::reconnectDelay_ns() {
  if (refused_) return kRefusedDelay_ns;
  return std::uniform_int_distribution<std::uint64_t>(kMinReconnectDelay_ns, kMaxReconnectDelay_ns)(random_);
}

void ClientSession::submit(v1::Transaction transaction, EditCallbacks callbacks) {
  edits_.submit(std::move(transaction), std::move(callbacks), mirror_.epoch());
  pumpEdits();
}

void ClientSession::upload(AssetKind kind, std::string bytes, UploadCallbacks callbacks) {
  uploads_.add(kind, std::move(bytes), std::move(callbacks));
  pumpUploads();
}

void ClientSession::cancelUpload(const ContentHash& asset) {
  const bool connected = phase_ == Phase::kSyncing || phase_ == Phase::kLive;
  if (uploads_.cancel(asset) && connected) {
    v1::Envelope envelope;
    envelope.mutable_asset_upload()->set_cancel(asset.asBytes());
    send(envelope);
  }
  pumpUploads();
}

void ClientSession::requestStatus(StatusCallback callback, bool deformed) {
  statusWaiters_.push_back(std::move(callback));
  const bool asksForMore = deformed && !statusDeformed_;
  statusDeformed_ = deformed;
  if (statusWaiters_.size() == 1 || asksForMore) sendStatusRequest();
}

void ClientSession::requestDump(DumpCallback callback) {
  dumpWaiters_.push_back(std::move(callback));
  if (dumpWaiters_.size() == 1) sendDumpRequest();
}

void ClientSession::setTelemetryRate(double rate_Hz) {
  options_.telemetryRate_Hz = rate_Hz;
  if (phase_ == Phase::kLive) sendSubscribe();
}

void ClientSession::leadHand(bool lead, std::uint64_t now_ns) {
  if (phase_ != Phase::kSyncing && phase_ != Phase::kLive) return;
  if (lead && options_.hand > 0 && welcome_.second_device().empty()) {
    v1::HandLeader none;
    none.set_hand(static_cast<std::uint32_t>(options_.hand));
    none.set_refused("lead_hand: there is no second hand: this server has one");
    hand_.answered(none);
    ++changes_;
    return;
  }
  hand_.ask(lead);
  pumpHand(now_ns);
}

void ClientSession::commandHand(const HandCommand& command, std::uint64_t now_ns) {
  hand_.command(command);
  pumpHand(now_ns);
}

void ClientSession::addWrench(std::size_t hand, const Wrench& wrench) {
  const std::size_t hands = welcome_.second_device().empty() ? 1 : 2;
  if (phase_ != Phase::kLive || !welcome_.may_edit() || hand >= hands) return;
  v1::Envelope envelope;
  v1::AddWrench& message = *envelope.mutable_add_wrench();
  message.set_hand(static_cast<std::uint32_t>(hand));
  toWire(wrench.force_N, *message.mutable_force_n());
  toWire(wrench.torque_Nm, *message.mutable_torque_nm());
  send(envelope);
}

void ClientSession::setWorkspace(const v1::SetWorkspace& message) {
  if (phase_ != Phase::kLive) return;
  v1::Envelope envelope;
  *envelope.mutable_set_workspace() = message;
  send(envelope);
}

MirrorView ClientSession::view(std::uint64_t now_ns) const {
  MirrorView view = mirror_.contents();
  view.link = phase_ == Phase::kLive      ? LinkState::kLive
              : phase_ == Phase::kSyncing ? LinkState::kSyncing
              : refused_                  ? LinkState::kRefused
                                          : LinkState::kConnecting;
  view.linkText = linkText_;
  view.takenAt_ns = now_ns;
  if (view.sample && clock_.known() && view.sample->time_ns != 0) {
    const std::int64_t age_ns = static_cast<std::int64_t>(now_ns) - clock_.toClient_ns(view.sample->time_ns);
    view.telemetryAge_s = std::max(0.0, 1e-9 * static_cast<double>(age_ns));
    view.clockUncertainty_s = 1e-9 * static_cast<double>(clock_.uncertainty_ns());
  }
  view.connections = connections_;
  view.serverName = welcome_.server_name();
  view.device = welcome_.device();
  view.maxForce_N = welcome_.max_force_n();
  view.secondDevice = welcome_.second_device();
  view.secondMaxForce_N = welcome_.second_max_force_n();
  view.servoRate_Hz = welcome_.servo_rate_hz();
  view.mayEdit = welcome_.may_edit();
  view.hand = hand_.leader();
  view.telemetryByDatagram = byDatagram_;
  view.forgedDatagrams = datagrams_.forged();
  view.datagramPathsLost = datagramPathsLost_;
  return view;
}

/// As assets that were fetched, by their hash: that the server holds them proves nothing about their bytes.
Result<void> ClientSession::shareAssets() {
  if (!options_.sharedAssets) return {};
  for (const AssetName& name : mirror_.lackingAssets()) {
    auto content = options_.sharedAssets(name);
    if (!content) continue;
    if (auto added = mirror_.addAsset(name, *std::move(content)); !added) return added;
  }
  return {};
}

void ClientSession::requestAssets() {
  if (!options_.fetchAssets || phase_ != Phase::kLive) return;
  while (const auto request = assets_.next()) {
    v1::Envelope envelope;
    *envelope.mutable_asset_request() = *request;
    send(envelope);
  }
}

void ClientSession::pumpEdits() {
  if ((phase_ != Phase::kSyncing && phase_ != Phase::kLive) || uploads_.sendsAgain()) return;
  while (const v1::EditRequest* request = edits_.next()) {
    v1::Envelope envelope;
    *envelope.mutable_edit_request() = *request;
    send(envelope);
  }
}

void ClientSession::pumpUploads() {
  if (phase_ != Phase::kSyncing && phase_ != Phase::kLive) return;
  while (transport_->backlog() < kUploadBacklog_bytes) {
    auto chunk = uploads_.next();
    if (!chunk) return;
    v1::Envelope envelope;
    *envelope.mutable_asset_upload() = std::move(*chunk);
    send(envelope);
  }
}

void ClientSession::pumpHand(std::uint64_t now_ns) {
  while (auto envelope = hand_.next(now_ns)) {
    if (byDatagram_ && envelope->has_hand_target()) {
      targetByDatagram_ = envelope->hand_target();
    } else {
      send(*envelope);
    }
  }
}

void ClientSession::sendHello() {
  const bool resumes = mirror_.epoch() != 0 && !needsSnapshot_;
  v1::Envelope envelope;
  v1::Hello& hello = *envelope.mutable_hello();
  hello.set_session(options_.session);
  hello.set_client_name(options_.clientName);
  hello.set_token(options_.token);
  hello.set_epoch(resumes ? mirror_.epoch() : 0);
  hello.set_revision(resumes ? mirror_.scene().revision() : 0);
  if (resumes) hello.set_root(mirror_.scene().root().asBytes());
  send(envelope);
}

void ClientSession::sendSubscribe() {
  v1::Envelope envelope;
  byDatagram_ = datagrams_.open();
  envelope.mutable_subscribe()->set_rate_hz(options_.telemetryRate_Hz);
  envelope.mutable_subscribe()->set_datagrams(byDatagram_);
  envelope.mutable_subscribe()->set_every_tick(static_cast<bool>(options_.onTicks));
  send(envelope);
}

void ClientSession::sendStatusRequest() {
  if (phase_ != Phase::kSyncing && phase_ != Phase::kLive) return;
  v1::Envelope envelope;
  envelope.mutable_status_request()->set_deformed(statusDeformed_);
  send(envelope);
}

void ClientSession::sendDumpRequest() {
  if (phase_ != Phase::kSyncing && phase_ != Phase::kLive) return;
  v1::Envelope envelope;
  envelope.mutable_dump_request();
  send(envelope);
}

void ClientSession::send(v1::Envelope& envelope) {
  if (transport_ == nullptr || connectionOver()) return;
  envelope.set_protocol_version(kProtocolVersion);
  envelope.set_message_id(nextMessageId_++);
  std::string frame;
  if (const auto framed = appendFrame(frame, envelope, options_.frames.frame_bytes); !framed)
    return over(framed.error().text());
  transport_->send(std::move(frame));
}

void ClientSession::over(const std::string& why) {
  over_ = why;
  ++changes_;
}

/// The server asks for more than a client gives: trying again soon will not help.
void ClientSession::leave(const Error& why) {
  assets_ = {};
  turnedAway("left the server: " + why.text());
  over(linkText_);
}

void ClientSession::resync(const Error& why) {
  mirror_.countResync();
  needsSnapshot_ = true;
  over("out of step with the server, asking for a snapshot: " + why.text());
}

}  // namespace haptics
