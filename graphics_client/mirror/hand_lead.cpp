#include "graphics_client/mirror/hand_lead.h"

#include <utility>

#include "common/wire/convert.h"
#include "graphics_client/mirror/client_limits.h"

namespace haptics {

void HandLead::ask(bool lead) {
  request_ = lead;
  leader_.refused.clear();
  target_.reset();
}

void HandLead::command(const HandCommand& command) {
  if (!leader_.isSelf) return;
  toWire(command, target_.emplace());
  target_->set_hand(hand_);
  due_ns_ = 0;
}

void HandLead::answered(const v1::HandLeader& message) {
  if (message.hand() != hand_) return;
  leader_ = {.led = message.led(),
             .isSelf = message.you(),
             .clientName = message.client_name().substr(0, kMaxServerText_bytes),
             .refused = message.refused().substr(0, kMaxServerText_bytes)};
  if (!leader_.isSelf) target_.reset();
}

void HandLead::connectionLost() { *this = HandLead(hand_); }

std::optional<v1::Envelope> HandLead::next(std::uint64_t now_ns) {
  v1::Envelope envelope;
  if (request_) {
    envelope.mutable_lead_hand()->set_lead(*std::exchange(request_, std::nullopt));
    envelope.mutable_lead_hand()->set_hand(hand_);
    return envelope;
  }
  if (!target_ || now_ns < due_ns_) return std::nullopt;
  *envelope.mutable_hand_target() = *target_;
  due_ns_ = now_ns + kRepeat_ns;
  return envelope;
}

}  // namespace haptics
