#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/wire/convert.h"
#include "common/wire/framing.h"
#include "haptic_server/net/server_session.h"
#include "tests/common/wire/memory_link.h"
#include "tests/haptic_server/scene/scene_edits.h"

namespace haptics::test {

constexpr std::uint64_t kMillisecond_ns = 1'000'000;
constexpr std::uint64_t kSecond_ns = 1'000'000'000;
constexpr SessionId kClientSession = 77;

/// A client without wits: keeps what it gets and sends what it is told.
class RawClient {
 public:
  explicit RawClient(Transport& transport) : transport_(transport) {
    transport_.start({.received = [this](std::span<const char> bytes) { receive(bytes); },
                      .drained = {},
                      .closed = [this](const std::string& why) { closed = why; }});
  }

  void send(v1::Envelope envelope) {
    if (envelope.protocol_version() == 0) envelope.set_protocol_version(kProtocolVersion);
    std::string frame;
    EXPECT_TRUE(appendFrame(frame, envelope));
    transport_.send(std::move(frame));
  }
  void sendBytes(std::string bytes) { transport_.send(std::move(bytes)); }
  void hello(std::uint64_t epoch = 0, std::uint64_t revision = 0, const ContentHash& root = {},
             SessionId session = kClientSession) {
    v1::Envelope envelope;
    envelope.mutable_hello()->set_session(session);
    envelope.mutable_hello()->set_client_name("raw");
    envelope.mutable_hello()->set_epoch(epoch);
    envelope.mutable_hello()->set_revision(revision);
    envelope.mutable_hello()->set_root(root.asBytes());
    send(envelope);
  }
  void subscribe(double rate_Hz, bool datagrams = false) {
    v1::Envelope envelope;
    envelope.mutable_subscribe()->set_datagrams(datagrams);
    envelope.mutable_subscribe()->set_rate_hz(rate_Hz);
    send(envelope);
  }
  void heartbeat() {
    v1::Envelope envelope;
    envelope.mutable_heartbeat();
    send(envelope);
  }
  void moveObject(std::uint64_t seq, const std::string& name, double x, bool progress = false) {
    v1::Envelope envelope;
    envelope.mutable_edit_request()->set_progress(progress);
    envelope.mutable_edit_request()->set_client_seq(seq);
    auto& set = *envelope.mutable_edit_request()->mutable_transaction()->add_operations()->mutable_set_pose();
    set.mutable_object()->set_name(name);
    set.mutable_pose()->mutable_position()->set_x(x);
    send(envelope);
  }
  void upload(const ContentHash& hash, std::uint64_t total, std::uint64_t offset, std::string data,
              v1::AssetKind kind = v1::ASSET_KIND_MESH) {
    v1::Envelope envelope;
    v1::AssetChunk& chunk = *envelope.mutable_asset_upload()->mutable_chunk();
    chunk.set_hash(hash.asBytes());
    chunk.set_kind(kind);
    chunk.set_total_size(total);
    chunk.set_offset(offset);
    chunk.set_data(std::move(data));
    send(envelope);
  }
  void cancelUpload(const ContentHash& hash) {
    v1::Envelope envelope;
    envelope.mutable_asset_upload()->set_cancel(hash.asBytes());
    send(envelope);
  }
  void requestAsset(const ContentHash& hash, std::uint64_t offset = 0) {
    v1::Envelope envelope;
    envelope.mutable_asset_request()->set_hash(hash.asBytes());
    envelope.mutable_asset_request()->set_offset(offset);
    send(envelope);
  }

  /// All messages of one kind, in order.
  [[nodiscard]] std::vector<v1::Envelope> all(v1::Envelope::BodyCase kind) const {
    std::vector<v1::Envelope> of;
    for (const v1::Envelope& envelope : got) {
      if (envelope.body_case() == kind) of.push_back(envelope);
    }
    return of;
  }
  [[nodiscard]] std::size_t count(v1::Envelope::BodyCase kind) const { return all(kind).size(); }
  [[nodiscard]] v1::Refusal refusal() const {
    const auto refusals = all(v1::Envelope::kRefusal);
    EXPECT_EQ(refusals.size(), 1U);
    return refusals.empty() ? v1::Refusal{} : refusals.back().refusal();
  }

  std::vector<v1::Envelope> got;
  std::optional<std::string> closed;

 private:
  Transport& transport_;
  FrameDecoder decoder_;

  void receive(std::span<const char> bytes) {
    decoder_.feed(bytes);
    for (;;) {
      auto envelope = decoder_.next();
      if (!envelope) ADD_FAILURE() << "the server sent " << envelope.error().text();
      if (!envelope || !*envelope) return;
      got.push_back(std::move(**envelope));
    }
  }
};

/// A server with one session, in virtual time: edits are decided at once, assets when told.
class SessionWorld : public SessionHost {
 public:
  explicit SessionWorld(const SessionLimits& limits = {}) : session(*serverEnd, *this, identity, limits) {
    session.start();
  }

  /// Goes on between two readings, as a clock does.
  [[nodiscard]] std::uint64_t now_ns() const override { return time_ns++; }
  [[nodiscard]] std::shared_ptr<const SceneHistory> history() const override { return sequencer.history(); }
  [[nodiscard]] std::shared_ptr<const Asset> findAsset(const ContentHash& hash) const override {
    if (auto asset = resolver.store().find(hash)) return asset;
    return uploads.find(hash);
  }
  [[nodiscard]] bool submitEdit(SessionId id, std::uint64_t clientSeq, Transaction transaction,
                                bool wantsProgress) override {
    if (builderIsFull) return false;
    if (!decides) return true;
    if (wantsProgress) session.editProgress(clientSeq, WorkStage::kBuilding, 0.5);
    session.editDecided(clientSeq, sequencer.submit(id, clientSeq, transaction));
    session.sceneChanged();
    return true;
  }
  [[nodiscard]] bool submitAsset(const AssetName& name, std::string bytes) override {
    if (builderIsFull) return false;
    building.emplace_back(name, std::move(bytes));
    return true;
  }
  [[nodiscard]] bool reserveUpload(std::size_t bytes) override {
    if (reserved + bytes > uploadBudget) return false;
    reserved += bytes;
    return true;
  }
  void releaseUpload(std::size_t bytes) override { reserved -= bytes; }
  [[nodiscard]] bool requestDump() override {
    ++dumpsAsked;
    return records;
  }
  void sessionClaimed(SessionId id) override { claimed = id; }
  void fillStatus(v1::Status& status) override { status.set_ticks(42); }
  void refused(const std::string& why) override { refusals.push_back(why); }
  void ended(const std::string&) override { over = true; }

  [[nodiscard]] Result<Role> admit(SessionId, const std::string& token) override {
    tokens.push_back(token);
    return role;
  }
  [[nodiscard]] const TickHistory* ticks() override { return &tickHistory; }
  [[nodiscard]] std::optional<DatagramOffer> offerDatagrams() override { return DatagramOffer{7654, "cookie"}; }
  [[nodiscard]] bool sendDatagram(const v1::Telemetry& telemetry) override {
    if (datagramPathOpen) datagrams.push_back(telemetry);
    return datagramPathOpen;
  }

  /// The server's own edit.
  Accepted edit(const Transaction& transaction) {
    auto accepted = std::get<Accepted>(sequencer.submit(kServerSession, ++serverSeq, transaction));
    session.sceneChanged();
    return accepted;
  }
  void join() {
    client.hello();
    link.settle();
    client.got.clear();
  }
  void decideAssets() {
    for (auto& [name, bytes] : std::exchange(building, {})) {
      session.assetDecided(name.hash, uploads.internEncoded(name, std::move(bytes)));
    }
    link.settle();
  }
  /// Lets time pass in the steps of the network thread's timer, messages arriving at once.
  void pass(std::uint64_t duration_ns, std::uint64_t step_ns = 2 * kMillisecond_ns) {
    for (const std::uint64_t end = time_ns + duration_ns; time_ns < end;) {
      time_ns += step_ns;
      session.poll();
      link.settle();
    }
  }

  mutable std::uint64_t time_ns = 1000 * kSecond_ns;
  BoxResolver resolver;
  AssetStore uploads;
  Sequencer sequencer{5, resolver};
  std::uint64_t serverSeq = 0;
  bool records = true;  // the last seconds
  int dumpsAsked = 0;
  bool builderIsFull = false;
  bool decides = true;  ///< At once; else never.
  std::vector<std::pair<AssetName, std::string>> building;
  std::size_t uploadBudget = 64U << 20;
  std::size_t reserved = 0;
  std::optional<SessionId> claimed;
  Result<Role> role = Role::kEdit;  ///< What the next Hello gets.
  TickHistory tickHistory;
  bool datagramPathOpen = false;
  std::vector<v1::Telemetry> datagrams;  ///< That were sent.
  std::vector<std::string> tokens;       ///< That came with a Hello.
  std::vector<std::string> refusals;
  bool over = false;

  MemoryLink link;
  std::unique_ptr<Transport> serverEnd = link.takeServer();
  std::unique_ptr<Transport> clientEnd = link.takeClient();
  ServerIdentity identity{"test", "simulated", 1000, 3.3};
  ServerSession session;
  RawClient client{*clientEnd};
};

}  // namespace haptics::test
