#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

#include "common/wire/framing.h"
#include "graphics_client/mirror/client_callbacks.h"

namespace haptics {

/// Edits on their way: numbered from 1, kept until they are live, sent again in the same order and under the same
/// number after a reconnect until they are answered. What came too early for the server is kept and sent again too.
class EditOutbox {
 public:
  /// Sent and not yet replied to. A server remembers at least as many results, so that each resend finds its own.
  static constexpr std::size_t kMaxInFlight = 32;
  static constexpr std::size_t kMaxPendingEdits = 1000;
  /// Refused as too early for this long, an edit is given up and its refusal reported.
  static constexpr std::uint64_t kPatience_ns = 60'000'000'000;

  explicit EditOutbox(std::size_t frame_bytes = kMaxFrameBytes) noexcept : frame_bytes_(frame_bytes) {}

  /// Made from a scene of this epoch (0: none). An edit that is too large, or one too many, is answered from within
  /// with Rejected, under number 0.
  void submit(v1::Transaction transaction, EditCallbacks callbacks, std::uint64_t epoch);
  /// The next edit to send, or null; counts as sent. Valid until the next call of another method.
  [[nodiscard]] const v1::EditRequest* next();
  /// Unknown numbers and second answers are ignored.
  void replied(const v1::EditReply& reply, std::uint64_t now_ns);
  void live(const v1::EditLive& live);
  /// As a server says it: of an edit that is answered or unknown it is ignored.
  void progress(const v1::EditProgress& progress);
  /// The servo feels this revision: what was accepted up to it is live, though nobody has said so of each edit.
  void adopted(std::uint64_t revision, std::uint64_t tick);
  /// Call every few milliseconds: what came too early may go again after a while.
  void poll(std::uint64_t now_ns);
  /// What the server has said cannot be read, which may be the answer to the oldest edit that was sent. At the second time
  /// that edit is given up, with Rejected: sent again, it would be answered the same.
  void answerUnreadable();
  /// The connection is new: what was not answered is to be sent again.
  void connectionLost();
  /// The server lost its state: what it had accepted never becomes live.
  void stateLost();

 private:
  struct Edit {
    v1::EditRequest request;
    EditCallbacks callbacks;
    bool sent = false;
    std::uint64_t acceptedRevision = 0;  // not 0: replied, not yet live
    std::uint64_t firstPutOff_ns = 0;    // 0: never
    bool unreadableOnce = false;
  };
  std::size_t frame_bytes_;
  std::deque<Edit> edits_;  // in order of number
  std::uint64_t lastSeq_ = 0;
  std::optional<std::uint64_t> waitingUntil_ns_;  // sends nothing: the server found that edits came too early

  [[nodiscard]] std::size_t inFlight() const;
  std::deque<Edit>::iterator find(std::uint64_t seq);
};

}  // namespace haptics
