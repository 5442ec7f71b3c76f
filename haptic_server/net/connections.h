#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "common/wire/event_loop.h"
#include "common/wire/tls.h"
#include "common/wire/transport.h"
#include "haptic_server/net/connection.h"
#include "haptic_server/net/rate_limit.h"
#include "haptic_server/net/shared_by_connections.h"

namespace haptics {

/// The clients of a server, and the loop of the network thread that serves them. Methods are called on that thread, or
/// while it does not run, but for post() and postTo(), which any thread may call.
class Connections final : public std::enable_shared_from_this<Connections> {
 public:
  /// Connections that have not been welcomed yet. Beyond, the oldest gives way to the newest: those who open connections
  /// and say nothing keep nobody out who speaks at once.
  static constexpr std::size_t kMaxHalfOpen = 64;

  /// Scene service and host outlive every call.
  Connections(const ServerIdentity& identity, const std::optional<ServerCredentials>& credentials,
              SceneService& sceneService, ServerHost& host)
      : identity_(identity), shared_(credentials, sceneService, host) {
    shared_.onTarget = [this](std::uint64_t number, const v1::HandTarget& target) {
      if (const auto at = connections_.find(number); at != connections_.end())
        at->second->session().handTargetByDatagram(target);
    };
  }

  [[nodiscard]] EventLoop& loop() noexcept { return loop_; }
  [[nodiscard]] const SharedByConnections& shared() const noexcept { return shared_; }
  void log(const std::string& line) { shared_.logLine(line); }

  /// Runs the task on the network thread, later, if the connections still exist.
  void post(std::function<void(Connections&)> task);
  using SessionTask = std::function<void(ServerSession&)>;
  /// Runs tasks of this connection's session on the network thread, later, while it still exists.
  [[nodiscard]] std::function<void(SessionTask)> postTo(std::uint64_t number);

  /// From now on every connection is to speak TLS.
  void secureWith(TlsContext tls) { tls_ = std::move(tls); }
  /// At this port where it is free, else at another. A server that gets no socket offers no datagrams.
  void openDatagrams(const Endpoint& local);

  void accept(std::unique_ptr<Transport> transport);
  void sceneChanged(std::shared_ptr<const SceneHistory> history);
  /// Closes the connections whose token is not on the list any more, or has another role there.
  /// @param anyway  Also where the list's file looks as it did.
  void refreshTokens(bool anyway);
  /// Empties the servo's queue. @return Whether there was a sample.
  bool drainTelemetry();
  /// Hands the servo's samples to the sessions and lets them do what has come due.
  /// @return The highest rate of telemetry that one of them wants.
  double serve_Hz();
  /// Closes all, accepts no more, and stops the loop once the last one is gone.
  void closeAll(const std::string& why);
  void clear();  ///< Drops all at once, and the socket for datagrams.

  // For a connection.

  /// The role of a client that says Hello, or why it is refused; the other clients count.
  [[nodiscard]] Result<Role> admit(SessionId id, const std::string& token) const;
  /// The client of a connection said that this session is its own: an older connection of it is closed.
  void claimed(const Connection& by, SessionId id);
  struct Upload {
    std::uint64_t connection;
    ContentHash token, hash;
    std::size_t reserved_bytes;
  };
  void assetDecided(const Upload& upload, const Result<std::shared_ptr<const Asset>>& asset);
  void remove(std::uint64_t number);
  /// As SessionHost::leadHand(), of the client of connection `number`.
  [[nodiscard]] Result<void> leadHand(std::uint64_t number, std::size_t hand, bool lead);
  [[nodiscard]] std::optional<SessionHost::Leader> handLeader(std::size_t hand) const;

 private:
  [[nodiscard]] bool admitsHandshake(const std::string& peer);
  void dropOldestHalfOpen();
  void countClients();
  void setHandLeader(std::size_t hand, std::optional<std::uint64_t> number);
  template <class Task>
  void each(Task task);

  const ServerIdentity identity_;
  EventLoop loop_;  // before what lives on it
  std::optional<TlsContext> tls_;
  HandshakeLimit handshakes_;
  SharedByConnections shared_;
  std::map<std::uint64_t, std::unique_ptr<Connection>> connections_;  // by number, the oldest first
  std::uint64_t nextNumber_ = 1;
  bool closing_ = false;
};

}  // namespace haptics
