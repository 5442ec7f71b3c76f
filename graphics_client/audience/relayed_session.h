#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string_view>

#include "common/error/error.h"
#include "common/hash/content_hash.h"
#include "graphics_client/audience/stored_session.h"
#include "haptics/v1/envelope.pb.h"

namespace haptics {

/// The server's half of the protocol, of what a relay has published: answers a client that watches. No sockets, threads or
/// clock of its own. Messages that came by NATS are checked for form and order here, roots by the client's mirror.
class RelayedSession {
 public:
  using Send = std::function<void(v1::Envelope&)>;
  using FetchAsset = std::function<void(const ContentHash&, std::uint64_t offset)>;

  /// Heartbeats that may name a revision before its commit comes. Fewer: a slow line is taken for a loss.
  static constexpr int kMaxHeartbeatsAhead = 3;

  /// @param send   Gets what goes to the client.
  /// @param fetch  An asset is asked for, from this byte on.
  RelayedSession(StoredSession stored, Send send, FetchAsset fetch);

  /// Refused: the connection is to end.
  [[nodiscard]] Result<void> fromClient(const v1::Envelope& envelope);
  [[nodiscard]] bool greeted() const noexcept { return greeted_; }  ///< The client has said Hello.

  /// A message of the subject live.commit. Refused: one that leaves a gap, or is another epoch's; to be begun anew.
  [[nodiscard]] Result<void> commit(std::string_view bytes);
  /// One of live.sample. Refused likewise.
  [[nodiscard]] Result<void> sample(std::string_view bytes);
  [[nodiscard]] std::uint64_t ignored() const noexcept { return ignored_; }  ///< Malformed messages.

 private:
  StoredSession stored_;
  Send send_;
  FetchAsset fetch_;
  bool greeted_ = false;
  std::uint64_t revision_;  // that the client is about to have
  int heartbeatsAhead_ = 0;
  std::uint64_t ignored_ = 0;

  void greet();
  void refuseEdit(const v1::EditRequest& request);
  void refuseUpload(const v1::AssetUpload& upload);
  [[nodiscard]] Result<void> heartbeat(const v1::Heartbeat& message);
  [[nodiscard]] Result<void> checkEpoch(std::uint64_t epoch) const;
};

}  // namespace haptics
