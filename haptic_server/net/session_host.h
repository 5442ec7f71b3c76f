#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "common/credentials/credentials.h"
#include "common/telemetry/added_wrench.h"
#include "common/telemetry/energy_state.h"
#include "common/telemetry/hand_command.h"
#include "common/telemetry/motion_state.h"
#include "haptic_server/net/tick_history.h"
#include "haptic_server/scene/scene_history.h"
#include "haptic_server/scene/sequencer.h"
#include "haptics/v1/envelope.pb.h"

namespace haptics {

/// The scene, as a session reads and edits it.
class SceneHost {
 public:
  virtual ~SceneHost() = default;
  [[nodiscard]] virtual std::shared_ptr<const SceneHistory> history() const = 0;
  [[nodiscard]] virtual std::shared_ptr<const Asset> findAsset(const ContentHash& hash) const = 0;
  /// Answered with ServerSession::editDecided, now or later. False: no room for it now, no answer follows.
  /// \param wantsProgress  With ServerSession::editProgress before, where it takes long.
  [[nodiscard]] virtual bool submitEdit(SessionId session, std::uint64_t clientSeq, Transaction transaction,
                                        bool wantsProgress) = 0;
  struct Place {
    std::uint64_t clientSeq;
    std::size_t place;  ///< 1: the next.
  };
  /// The session's edit that waits for its turn to be prepared, if one does.
  [[nodiscard]] virtual std::optional<Place> waiting([[maybe_unused]] SessionId session) { return std::nullopt; }
  /// Hash of the newest version with the newest sample's dents; nothing where it is not known.
  [[nodiscard]] virtual std::optional<ContentHash> deformedHash() { return std::nullopt; }
};

/// Where a session's uploads are kept and built.
class UploadHost {
 public:
  virtual ~UploadHost() = default;
  /// Answered with ServerSession::assetDecided, now or later. False: no room for it now, no answer follows.
  /// When the session is destroyed before, the host releases what it had reserved for these bytes.
  [[nodiscard]] virtual bool submitAsset(const AssetName& name, std::string bytes) = 0;
  /// Memory of the server for uploads, shared by all clients. False: there is not so much left.
  [[nodiscard]] virtual bool reserveUpload(std::size_t bytes) = 0;
  virtual void releaseUpload(std::size_t bytes) = 0;
};

/// Interface of a session to its server: the network thread's, or a simulation's in virtual time. Called on
/// the session's thread only.
class SessionHost : public SceneHost, public UploadHost {
 public:
  /// Of the newest sample that was offered. By default, of a scene in which nothing moves.
  [[nodiscard]] virtual const MotionState& motion() const {
    static const MotionState kNone;
    return kNone;
  }
  /// Adds shapes that are driven to a sample of this moment. By default none are.
  virtual void addShapes([[maybe_unused]] v1::Telemetry& sample) {}
  /// The object and feature that gave the hand most energy; object 0: none gave any, or nothing observes it.
  [[nodiscard]] virtual EnergySource largestEnergySource() const { return {}; }

  /// For a session that wants every tick; null, as by default: nobody keeps them.
  [[nodiscard]] virtual const TickHistory* ticks() { return nullptr; }

  struct DatagramOffer {
    std::uint16_t port;
    std::string cookie;
  };
  /// Telemetry by datagram, for Welcome; nothing where there is none.
  [[nodiscard]] virtual std::optional<DatagramOffer> offerDatagrams() { return std::nullopt; }
  /// False: there is no open path for datagrams now.
  [[nodiscard]] virtual bool sendDatagram([[maybe_unused]] const v1::Telemetry& telemetry) { return false; }

  /// Asks for the lead of a simulated hand, which one client at a time has, or gives it back where this session has it.
  /// Refused: another client leads it, or, as by default, there is no such hand to lead.
  /// @param hand  Below kMaxLedHands, as below.
  [[nodiscard]] virtual Result<void> leadHand([[maybe_unused]] std::size_t hand, bool lead) {
    if (lead) return haptics::refused("lead_hand", "this server has no hand that a client could lead");
    return {};
  }
  /// Of a session that does not lead it is ignored.
  virtual void commandHand([[maybe_unused]] std::size_t hand, [[maybe_unused]] const HandCommand& command) {}
  /// Refused: as by default, this hand has no device whose workspace could be moved.
  [[nodiscard]] virtual Result<void> moveWorkspace([[maybe_unused]] std::size_t hand,
                                                   [[maybe_unused]] const WorkspaceCommand& command) {
    return haptics::refused("set_workspace.hand", "this server has no such hand whose workspace could be moved");
  }
  /// Ignored while another session's is felt. Refused: as by default, nothing can be added to this hand's force.
  [[nodiscard]] virtual Result<void> addWrench([[maybe_unused]] std::size_t hand,
                                               [[maybe_unused]] const Wrench& wrench) {
    return haptics::refused("add_wrench.hand", "this server has no such hand to which a force could be added");
  }
  struct Leader {
    std::string name;
    SessionId session;
  };
  [[nodiscard]] virtual std::optional<Leader> handLeader([[maybe_unused]] std::size_t hand) const {
    return std::nullopt;
  }

  [[nodiscard]] virtual std::uint64_t now_ns() const = 0;  ///< Nanoseconds on the server's monotonic clock.
  /// The role of a client that says Hello as `session` with this token, or why it is refused. By default, as on a
  /// server that only this machine can reach: everybody may edit.
  [[nodiscard]] virtual Result<Role> admit([[maybe_unused]] SessionId session,
                                           [[maybe_unused]] const std::string& token) {
    return Role::kEdit;
  }
  /// The client said who it is: an older connection of the same session is to be closed.
  virtual void sessionClaimed(SessionId session) = 0;
  /// Records the last seconds. Answered with ServerSession::dumped, later. False: this server keeps none, no answer follows.
  [[nodiscard]] virtual bool requestDump() { return false; }
  /// All but what the session knows itself: epoch, revision and root.
  virtual void fillStatus(v1::Status& status) = 0;
  /// The client was refused, for the log. The connection ends (ended() follows).
  virtual void refused(const std::string& why) = 0;
  /// The connection is closed; nothing follows. The session may be destroyed once this call has returned.
  virtual void ended(const std::string& why) = 0;
};

}  // namespace haptics
