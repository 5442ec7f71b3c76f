#include "graphics_client/mirror/edit_outbox.h"

#include <algorithm>
#include <string>
#include <utility>

#include "common/wire/framing.h"

namespace haptics {
namespace {

/// Room in a frame for what stands around a transaction: envelope, numbers, lengths.
constexpr std::size_t kEnvelopeBytes = 64;

void reject(const EditCallbacks& callbacks, const char* field, const std::string& reason) {
  v1::EditReply reply;
  reply.mutable_rejected()->set_field(field);
  reply.mutable_rejected()->set_reason(reason);
  if (callbacks.replied) callbacks.replied(reply);
}

}  // namespace

void EditOutbox::submit(v1::Transaction transaction, EditCallbacks callbacks) {
  if (transaction.ByteSizeLong() > kMaxFrameBytes - kEnvelopeBytes) {
    return reject(callbacks, "transaction", "is larger than a frame, 1 MiB; split it");
  }
  if (edits_.size() >= kMaxPendingEdits) {
    return reject(callbacks, "", std::to_string(kMaxPendingEdits) + " edits wait for the server; try again later");
  }
  Edit edit;
  edit.request.set_client_seq(++lastSeq_);
  *edit.request.mutable_transaction() = std::move(transaction);
  edit.callbacks = std::move(callbacks);
  edits_.push_back(std::move(edit));
}

const v1::EditRequest* EditOutbox::next() {
  const auto inFlight = std::ranges::count_if(edits_, [](const Edit& edit) { return edit.sent && !edit.accepted; });
  const auto edit = std::ranges::find(edits_, false, &Edit::sent);
  if (edit == edits_.end() || (static_cast<std::size_t>(inFlight) >= kMaxInFlight && !edit->accepted)) return nullptr;
  edit->sent = true;
  return &edit->request;
}

void EditOutbox::replied(const v1::EditReply& reply) {
  const auto edit = find(reply.client_seq());
  if (edit == edits_.end() || edit->accepted) return;
  const auto callback = std::exchange(edit->callbacks.replied, nullptr);
  if (reply.has_accepted() && edit->callbacks.live) {
    edit->accepted = true;
  } else {
    edits_.erase(edit);
  }
  if (callback) callback(reply);
}

void EditOutbox::live(const v1::EditLive& live) {
  const auto edit = find(live.client_seq());
  if (edit == edits_.end() || !edit->accepted) return;
  const auto callback = std::move(edit->callbacks.live);
  edits_.erase(edit);
  callback(live);
}

void EditOutbox::connectionLost() {
  for (Edit& edit : edits_) edit.sent = false;
}

void EditOutbox::stateLost() { std::erase_if(edits_, &Edit::accepted); }

std::deque<EditOutbox::Edit>::iterator EditOutbox::find(std::uint64_t seq) {
  return std::ranges::find(edits_, seq, [](const Edit& edit) { return edit.request.client_seq(); });
}

}  // namespace haptics
