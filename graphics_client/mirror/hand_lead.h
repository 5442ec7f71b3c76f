#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "common/telemetry/hand_command.h"
#include "graphics_client/mirror/hand_leader.h"
#include "haptics/v1/envelope.pb.h"

namespace haptics {

/// A client's half of leading the hand: what it asked for, what it was answered, and its newest target, repeated so that
/// the server does not take it for silent. The lead ends with the connection; who wants it back asks again.
class HandLead {
 public:
  /// @param hand  Below kMaxLedHands: of the server.
  explicit HandLead(std::size_t hand = 0) noexcept : hand_(static_cast<std::uint32_t>(hand)) {}

  /// Of the same target: below the server's limit of 0.1 s.
  static constexpr std::uint64_t kRepeat_ns = 30'000'000;

  /// For the lead, or to give it back. Either way the server then says who leads, and whenever that changes.
  void ask(bool lead);
  /// Where the hand shall be; sent while this client leads.
  void command(const HandCommand& command);
  void answered(const v1::HandLeader& message);
  void connectionLost();
  /// The next message to be sent now; ask until there is none.
  [[nodiscard]] std::optional<v1::Envelope> next(std::uint64_t now_ns);
  [[nodiscard]] const HandLeader& leader() const noexcept { return leader_; }

 private:
  std::uint32_t hand_;
  HandLeader leader_;
  std::optional<bool> request_;  // unsent: for the lead, or to give it back
  std::optional<v1::HandTarget> target_;
  std::uint64_t due_ns_ = 0;  // of the target
};

}  // namespace haptics
