#include "graphics_client/mirror/edit_outbox.h"

#include <algorithm>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "common/clock/monotonic.h"

namespace haptics {
namespace {

/// Room in a frame for what stands around a transaction: envelope, numbers, lengths.
constexpr std::size_t kEnvelopeBytes = 64;

void reject(const EditCallbacks& callbacks, const char* field, const std::string& reason, std::uint64_t clientSeq = 0) {
  v1::EditReply reply;
  reply.set_client_seq(clientSeq);
  reply.mutable_rejected()->set_field(field);
  reply.mutable_rejected()->set_reason(reason);
  if (callbacks.replied) callbacks.replied(reply);
}

}  // namespace

void EditOutbox::submit(v1::Transaction transaction, EditCallbacks callbacks, std::uint64_t epoch) {
  if (const std::size_t bytes = transaction.ByteSizeLong(); bytes > frame_bytes_ - kEnvelopeBytes) {
    return reject(callbacks, "transaction",
                  "has " + std::to_string(bytes) + " bytes; a frame holds " +
                      std::to_string(frame_bytes_ - kEnvelopeBytes) + ": split it");
  }
  if (edits_.size() >= kMaxPendingEdits) {
    return reject(callbacks, "", std::to_string(kMaxPendingEdits) + " edits wait for the server; try again later");
  }
  Edit edit;
  edit.request.set_client_seq(++lastSeq_);
  edit.request.set_epoch(epoch);
  *edit.request.mutable_transaction() = std::move(transaction);
  edit.request.set_progress(callbacks.progress != nullptr);
  edit.callbacks = std::move(callbacks);
  edits_.push_back(std::move(edit));
}

const v1::EditRequest* EditOutbox::next() {
  const auto edit = std::ranges::find(edits_, false, &Edit::sent);
  if (edit == edits_.end() || waitingUntil_ns_ || inFlight() >= kMaxInFlight) return nullptr;
  edit->sent = true;
  return &edit->request;
}

void EditOutbox::replied(const v1::EditReply& reply, std::uint64_t now_ns) {
  const auto edit = find(reply.client_seq());
  if (edit == edits_.end() || edit->acceptedRevision != 0) return;
  if (const std::uint32_t wait_ms = reply.rejected().retry_after_ms(); wait_ms != 0) {
    if (edit->firstPutOff_ns == 0) edit->firstPutOff_ns = now_ns;
    if (now_ns - edit->firstPutOff_ns < kPatience_ns) {
      edit->sent = false;
      waitingUntil_ns_ = now_ns + std::min(wait_ms * kNanosecondsPerMillisecond, kPatience_ns);
      return;
    }
  }
  const auto callback = std::exchange(edit->callbacks.replied, nullptr);
  if (reply.has_accepted() && edit->callbacks.live) {
    edit->acceptedRevision = reply.accepted().revision();
  } else {
    edits_.erase(edit);
  }
  if (callback) callback(reply);
}

void EditOutbox::live(const v1::EditLive& live) {
  const auto edit = find(live.client_seq());
  if (edit == edits_.end() || edit->acceptedRevision == 0) return;
  const auto callback = std::move(edit->callbacks.live);
  edits_.erase(edit);
  callback(live);
}

void EditOutbox::progress(const v1::EditProgress& progress) {
  const auto edit = find(progress.client_seq());
  if (edit == edits_.end() || !edit->callbacks.progress || edit->acceptedRevision != 0) return;
  v1::EditProgress sound = progress;
  sound.set_share(progress.share() > 0 ? std::min(progress.share(), 1.0) : 0);
  edit->callbacks.progress(sound);
}

void EditOutbox::adopted(std::uint64_t revision, std::uint64_t tick) {
  for (;;) {
    const auto edit = std::ranges::find_if(
        edits_, [&](const Edit& e) { return e.acceptedRevision != 0 && e.acceptedRevision <= revision; });
    if (edit == edits_.end()) return;
    v1::EditLive message;
    message.set_client_seq(edit->request.client_seq());
    message.set_revision(edit->acceptedRevision);
    message.set_tick(tick);
    live(message);
  }
}

/// What was sent behind the edit that came too early has come too early as well; it is all sent again once the last of
/// those answers is here. Earlier, a later edit could overtake one whose refusal is still under way.
void EditOutbox::poll(std::uint64_t now_ns) {
  if (waitingUntil_ns_ && now_ns >= *waitingUntil_ns_ && inFlight() == 0) waitingUntil_ns_.reset();
}

void EditOutbox::answerUnreadable() {
  const auto edit =
      std::ranges::find_if(edits_, [](const Edit& each) { return each.sent && each.acceptedRevision == 0; });
  if (edit == edits_.end() || !std::exchange(edit->unreadableOnce, true)) return;
  const Edit abandoned = std::move(*edit);
  edits_.erase(edit);
  reject(abandoned.callbacks, "edit_reply", "cannot be read, twice; whether the edit was applied is not known",
         abandoned.request.client_seq());
}

void EditOutbox::connectionLost() {
  for (Edit& edit : edits_) edit.sent = edit.acceptedRevision != 0;
  waitingUntil_ns_.reset();
}

void EditOutbox::stateLost() {
  std::vector<std::function<void()>> callbacks;
  std::erase_if(edits_, [&](Edit& edit) {
    if (edit.acceptedRevision == 0) return false;
    if (edit.callbacks.stateLost) callbacks.push_back(std::move(edit.callbacks.stateLost));
    return true;
  });
  for (const auto& callback : callbacks) callback();
}

std::size_t EditOutbox::inFlight() const {
  return static_cast<std::size_t>(
      std::ranges::count_if(edits_, [](const Edit& edit) { return edit.sent && edit.acceptedRevision == 0; }));
}

std::deque<EditOutbox::Edit>::iterator EditOutbox::find(std::uint64_t seq) {
  return std::ranges::find(edits_, seq, [](const Edit& edit) { return edit.request.client_seq(); });
}

}  // namespace haptics
