#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "common/wire/transport.h"
#include "haptic_server/net/admission.h"
#include "haptic_server/net/server_session.h"
#include "haptic_server/net/session_host.h"
#include "haptic_server/net/shape_updates.h"
#include "haptic_server/net/shared_by_connections.h"

namespace haptics {

class Connections;

/// One client's connection to a server: its transport, its session, and what the session needs. Network thread.
class Connection final : public SessionHost {
 public:
  /// All but the transport outlive it. `number` tells it from every other connection of the server.
  Connection(Connections& all, SharedByConnections& shared, const ServerIdentity& identity, std::uint64_t number,
             std::unique_ptr<Transport> transport);
  ~Connection() override { left_.request_stop(); }  ///< Edits that only this client waits for are stopped.

  [[nodiscard]] ServerSession& session() noexcept { return session_; }
  [[nodiscard]] const ServerSession& session() const noexcept { return session_; }
  [[nodiscard]] Admission::Client client() const { return {session_.id(), session_.role(), token_}; }
  [[nodiscard]] std::string peer() const { return transport_->peer(); }
  [[nodiscard]] std::string described() const;  ///< Name and address, for the log.

  [[nodiscard]] std::shared_ptr<const SceneHistory> history() const override { return shared_.history; }
  [[nodiscard]] std::shared_ptr<const Asset> findAsset(const ContentHash& hash) const override {
    return shared_.sceneService.findAsset(hash);
  }
  [[nodiscard]] bool submitEdit(SessionId id, std::uint64_t clientSeq, Transaction transaction,
                                bool wantsProgress) override;
  [[nodiscard]] std::optional<Place> waiting(SessionId id) override;
  [[nodiscard]] std::optional<ContentHash> deformedHash() override;

  [[nodiscard]] bool submitAsset(const AssetName& name, std::string bytes) override;
  [[nodiscard]] bool reserveUpload(std::size_t bytes) override { return shared_.uploads.reserve(token_, bytes); }
  void releaseUpload(std::size_t bytes) override { shared_.uploads.release(token_, bytes); }

  [[nodiscard]] const MotionState& motion() const override { return shared_.servo.motion(); }
  void addShapes(v1::Telemetry& sample) override {
    if (shared_.servo.shapes().count > 0)
      shapes_.add(shared_.servo.shapes(), *shared_.sceneService.drivenShapes(), now_ns(), sample);
  }
  [[nodiscard]] EnergySource largestEnergySource() const override { return shared_.servo.largestEnergySource(); }
  [[nodiscard]] const TickHistory* ticks() override { return &shared_.servo.ticks(); }
  [[nodiscard]] std::optional<DatagramOffer> offerDatagrams() override;
  [[nodiscard]] bool sendDatagram(const v1::Telemetry& telemetry) override {
    return shared_.paths.send(number_, telemetry, now_ns());
  }

  [[nodiscard]] Result<void> leadHand(std::size_t hand, bool lead) override;
  void commandHand(std::size_t hand, const HandCommand& command) override;
  [[nodiscard]] Result<void> moveWorkspace(std::size_t hand, const WorkspaceCommand& command) override;
  [[nodiscard]] Result<void> addWrench(std::size_t hand, const Wrench& wrench) override;
  [[nodiscard]] std::optional<Leader> handLeader(std::size_t hand) const override;

  [[nodiscard]] std::uint64_t now_ns() const override { return monotonicNow_ns(); }
  [[nodiscard]] Result<Role> admit(SessionId id, const std::string& token) override;
  void sessionClaimed(SessionId id) override;
  [[nodiscard]] bool requestDump() override;
  void fillStatus(v1::Status& status) override;
  void refused(const std::string& why) override;
  void ended(const std::string& why) override;

 private:
  [[nodiscard]] SessionId editSession(SessionId id) const {
    return shared_.admission.editSession({id, session_.role(), token_});
  }

  Connections& all_;
  SharedByConnections& shared_;
  const std::uint64_t number_;
  const std::unique_ptr<Transport> transport_;
  ContentHash token_{};  // its hash; of no token where none is asked for
  bool wasRefused_ = false;
  std::stop_source left_;
  ShapeUpdates shapes_;
  ServerSession session_;  // last: when it ends it gives back what it reserved
};

}  // namespace haptics
