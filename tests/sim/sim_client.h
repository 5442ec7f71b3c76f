#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "graphics_client/mirror/client_session.h"
#include "tests/sim/line.h"
#include "tests/sim/stage.h"

namespace haptics::sim {

class FrameTap;

/// A client's process: a production session with the loop around it that ServerLink has. Edits go through here, so
/// that the oracle knows what was meant and what came of it.
class SimClient {
 public:
  /// A new line to the server whose other end has been handed over; nothing when there is no one to answer.
  using Dial = std::function<std::optional<Line>(const Weather&)>;

  /// Weather outlives the client. Only a bad memory can be corrupted.
  SimClient(Stage& stage, const Weather& weather, Dial dial, const std::string& token, bool badMemory);
  ~SimClient();

  void submit(v1::Transaction transaction, Intent intent);
  void upload(AssetKind kind, std::string bytes, std::function<void(bool accepted)> finished);
  void requestStatus();
  /// The process is stopped: it neither reads nor does anything for so long.
  void stopFor(std::uint64_t duration_ns);
  /// Drops the connection and makes another; what it had sent still arrives.
  void reconnect();
  /// The present connection, if there is one.
  void withLine(const std::function<void(Line&)>& what);
  /// Flips a value in an object or a mesh that this client shows, or in the next commit that it gets.
  void corruptMemory();

  [[nodiscard]] SessionId id() const noexcept { return id_; }
  [[nodiscard]] const Mirror& mirror() const { return session_->mirror(); }
  [[nodiscard]] MirrorView view() const { return session_->view(now_ns()); }
  [[nodiscard]] bool live() const { return view().link == LinkState::kLive; }
  /// Edits that are neither refused, live nor lost yet, uploads and requests that were not answered.
  [[nodiscard]] std::size_t unanswered() const noexcept { return unanswered_; }

 private:
  Stage& stage_;
  const Weather& weather_;
  Dial dial_;
  const bool badMemory_;
  const SessionId id_;
  const std::uint64_t clockStart_ns_;
  std::unique_ptr<ClientSession> session_;
  std::unique_ptr<Transport> transport_;
  FrameTap* tap_ = nullptr;  // where there is one: part of transport_
  std::optional<Line> line_;
  std::uint64_t connection_ = 0;  // counts them
  std::uint64_t lastSeq_ = 0;
  std::size_t unanswered_ = 0;
  bool stopped_ = false;
  std::uint64_t damagedAt_ns_ = 0;  // 0: the memory is sound, as far as is known
  std::uint64_t damagedConnection_ = 0;
  std::uint64_t stops_ = 0;
  std::shared_ptr<const bool> alive_ = std::make_shared<const bool>(true);

  [[nodiscard]] std::uint64_t now_ns() const { return stage_.time.now_ns() + clockStart_ns_; }
  void connect();
  void poll();
  void settle();
  void lost(const std::string& why);
  void watchMemory();
};

}  // namespace haptics::sim
