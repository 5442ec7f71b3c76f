#include "graphics_client/mirror/edit_outbox.h"

#include <gtest/gtest.h>

#include "common/wire/framing.h"
#include "tests/graphics_client/mirror/fake_server.h"

namespace haptics {
namespace {

/// What came of edits, in words: "1 accepted 5", "2 rejected", "1 live 900".
struct Log {
  EditCallbacks callbacks() {
    return {.replied =
                [this](const v1::EditReply& reply) {
                  const std::string seq = std::to_string(reply.client_seq());
                  lines.push_back(reply.has_accepted()
                                      ? seq + " accepted " + std::to_string(reply.accepted().revision())
                                      : seq + (reply.has_conflict() ? " conflict" : " rejected"));
                },
            .live =
                [this](const v1::EditLive& live) {
                  lines.push_back(std::to_string(live.client_seq()) + " live " + std::to_string(live.tick()));
                }};
  }
  std::vector<std::string> lines;
};

v1::EditReply accepted(std::uint64_t seq, std::uint64_t revision) {
  v1::EditReply reply;
  reply.set_client_seq(seq);
  reply.mutable_accepted()->set_revision(revision);
  return reply;
}

v1::EditReply rejected(std::uint64_t seq) {
  v1::EditReply reply;
  reply.set_client_seq(seq);
  reply.mutable_rejected();
  return reply;
}

v1::EditLive live(std::uint64_t seq, std::uint64_t tick) {
  v1::EditLive message;
  message.set_client_seq(seq);
  message.set_tick(tick);
  return message;
}

/// Takes everything that is to be sent: each edit as "number:object".
std::vector<std::string> sendAll(EditOutbox& outbox) {
  std::vector<std::string> sent;
  while (const v1::EditRequest* request = outbox.next()) {
    sent.push_back(std::to_string(request->client_seq()) + ":" +
                   std::to_string(request->transaction().operations(0).remove().object().id()));
  }
  return sent;
}

using Lines = std::vector<std::string>;

TEST(EditOutbox, NumbersEditsFromOneInTheirOrder) {
  EditOutbox outbox;
  outbox.submit(removal(5), {});
  outbox.submit(removal(6), {});
  EXPECT_EQ(sendAll(outbox), (Lines{"1:5", "2:6"}));
  EXPECT_EQ(sendAll(outbox), Lines{});
}

TEST(EditOutbox, ReportsTheReplyAndThenThatItIsLive) {
  EditOutbox outbox;
  Log log;
  outbox.submit(removal(5), log.callbacks());
  (void)sendAll(outbox);
  outbox.replied(accepted(1, 12));
  outbox.live(live(1, 900));
  EXPECT_EQ(log.lines, (Lines{"1 accepted 12", "1 live 900"}));
}

TEST(EditOutbox, SendsUnansweredEditsAgainUnchangedAndInOrder) {
  EditOutbox outbox;
  Log log;
  for (const std::uint64_t object : {5, 6, 7}) outbox.submit(removal(object), log.callbacks());
  (void)sendAll(outbox);
  outbox.replied(rejected(2));
  outbox.connectionLost();
  EXPECT_EQ(sendAll(outbox), (Lines{"1:5", "3:7"}));
}

TEST(EditOutbox, AsksAgainWhenAnAcceptedEditIsLive) {
  EditOutbox outbox;
  Log log;
  outbox.submit(removal(5), log.callbacks());
  (void)sendAll(outbox);
  outbox.replied(accepted(1, 12));
  outbox.connectionLost();
  EXPECT_EQ(sendAll(outbox), Lines{"1:5"});
  outbox.replied(accepted(1, 12));  // the server's remembered answer
  outbox.live(live(1, 900));
  EXPECT_EQ(log.lines, (Lines{"1 accepted 12", "1 live 900"}));
  outbox.connectionLost();
  EXPECT_EQ(sendAll(outbox), Lines{});
}

TEST(EditOutbox, StillAwaitsLiveWhenTheServerHasForgottenItsAnswer) {
  EditOutbox outbox;
  Log log;
  outbox.submit(removal(5), log.callbacks());
  (void)sendAll(outbox);
  outbox.replied(accepted(1, 12));
  outbox.connectionLost();
  (void)sendAll(outbox);
  outbox.replied(rejected(1));
  outbox.live(live(1, 900));
  EXPECT_EQ(log.lines, (Lines{"1 accepted 12", "1 live 900"}));
}

TEST(EditOutbox, DoesNotWaitForLiveWhenNobodyAsked) {
  EditOutbox outbox;
  outbox.submit(removal(5), {});
  (void)sendAll(outbox);
  outbox.replied(accepted(1, 12));
  outbox.connectionLost();
  EXPECT_EQ(sendAll(outbox), Lines{});
}

TEST(EditOutbox, IgnoresAnswersToWhatItDidNotAsk) {
  EditOutbox outbox;
  Log log;
  outbox.submit(removal(5), log.callbacks());
  (void)sendAll(outbox);
  outbox.replied(accepted(2, 12));
  outbox.live(live(1, 900));  // live before it was accepted
  outbox.replied(rejected(1));
  outbox.replied(rejected(1));
  outbox.live(live(1, 900));
  EXPECT_EQ(log.lines, Lines{"1 rejected"});
}

TEST(EditOutbox, ForgetsAcceptedEditsOfAServerThatLostItsState) {
  EditOutbox outbox;
  Log log;
  outbox.submit(removal(5), log.callbacks());
  outbox.submit(removal(6), log.callbacks());
  (void)sendAll(outbox);
  outbox.replied(accepted(1, 12));
  outbox.connectionLost();
  outbox.stateLost();
  EXPECT_EQ(sendAll(outbox), Lines{"2:6"});
}

TEST(EditOutbox, KeepsFewInFlight) {
  EditOutbox outbox;
  for (std::size_t i = 0; i < EditOutbox::kMaxInFlight + 5; ++i) outbox.submit(removal(i), {});
  EXPECT_EQ(sendAll(outbox).size(), EditOutbox::kMaxInFlight);
  outbox.replied(accepted(1, 1));
  EXPECT_EQ(sendAll(outbox).size(), 1U);
}

TEST(EditOutbox, RejectsOneEditTooManyAtOnce) {
  EditOutbox outbox;
  Log log;
  for (std::size_t i = 0; i < EditOutbox::kMaxPendingEdits; ++i) outbox.submit(removal(i), {});
  outbox.submit(removal(1), log.callbacks());
  EXPECT_EQ(log.lines, Lines{"0 rejected"});
}

TEST(EditOutbox, RejectsAnEditLargerThanAFrameAtOnceAndTakesTheLargest) {
  EditOutbox outbox;
  Log log;
  v1::Transaction transaction = removal(1);
  std::string& name = *transaction.add_operations()->mutable_add()->mutable_name();
  name.resize(kMaxFrameBytes);
  outbox.submit(transaction, log.callbacks());
  EXPECT_EQ(log.lines, Lines{"0 rejected"});
  name.resize(name.size() - (transaction.ByteSizeLong() - kMaxFrameBytes) - 64);
  outbox.submit(transaction, log.callbacks());
  const v1::EditRequest* request = outbox.next();
  ASSERT_NE(request, nullptr);
  v1::Envelope envelope;
  envelope.set_protocol_version(kProtocolVersion);
  envelope.set_message_id(~0ULL);
  *envelope.mutable_edit_request() = *request;
  EXPECT_LE(envelope.ByteSizeLong(), kMaxFrameBytes);
}

TEST(EditOutbox, LetsACallbackSubmitTheNextEdit) {
  EditOutbox outbox;
  Log log;
  outbox.submit(removal(5), {.replied = [&](const v1::EditReply&) { outbox.submit(removal(6), log.callbacks()); },
                             .live = [&](const v1::EditLive&) { outbox.submit(removal(7), log.callbacks()); }});
  (void)sendAll(outbox);
  outbox.replied(accepted(1, 1));
  outbox.live(live(1, 1));
  EXPECT_EQ(sendAll(outbox), (Lines{"2:6", "3:7"}));
}

}  // namespace
}  // namespace haptics
