#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>

#include "graphics_client/mirror/client_callbacks.h"

namespace haptics {

/// Edits on their way: numbered from 1, kept until answered, sent again in the same order and under the same number
/// after a reconnect. Those accepted and not yet live are sent again too: the server does not apply them twice, and
/// says again from which tick they are felt.
class EditOutbox {
 public:
  /// Sent and not yet replied to. A server remembers at least as many results, so that each resend finds its own.
  static constexpr std::size_t kMaxInFlight = 32;
  static constexpr std::size_t kMaxPendingEdits = 1000;

  /// An edit that is too large, or one too many, is answered from within with Rejected, under number 0.
  void submit(v1::Transaction transaction, EditCallbacks callbacks);
  /// The next edit to send, or null; counts as sent. Valid until the next call of another method.
  [[nodiscard]] const v1::EditRequest* next();
  /// Unknown numbers and second answers are ignored.
  void replied(const v1::EditReply& reply);
  void live(const v1::EditLive& live);
  /// The connection is new: everything is to be sent again.
  void connectionLost();
  /// The server lost its state: what it had accepted never becomes live.
  void stateLost();

 private:
  struct Edit {
    v1::EditRequest request;
    EditCallbacks callbacks;
    bool sent = false;
    bool accepted = false;  // replied, not yet live
  };
  std::deque<Edit> edits_;  // in order of number
  std::uint64_t lastSeq_ = 0;

  std::deque<Edit>::iterator find(std::uint64_t seq);
};

}  // namespace haptics
