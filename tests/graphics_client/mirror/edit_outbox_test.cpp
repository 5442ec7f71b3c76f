#include "graphics_client/mirror/edit_outbox.h"

#include <gtest/gtest.h>

#include <limits>

#include "common/wire/framing.h"
#include "tests/graphics_client/mirror/fake_server.h"

namespace haptics::edit_outbox_test {
namespace {

constexpr std::uint64_t kEpoch = 1001;
constexpr std::uint64_t kNow_ns = 1'000'000'000'000;
constexpr std::uint64_t kMillisecond_ns = 1'000'000;

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
                },
            .stateLost = [this] { lines.push_back("lost"); }};
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

v1::EditReply tooEarly(std::uint64_t seq) {
  v1::EditReply reply = rejected(seq);
  reply.mutable_rejected()->set_retry_after_ms(100);
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

v1::EditProgress progress(std::uint64_t seq, double share) {
  v1::EditProgress message;
  message.set_client_seq(seq);
  message.set_stage(v1::EditProgress::STAGE_BUILDING);
  message.set_share(share);
  return message;
}

TEST(EditOutbox, AsksForProgressWhereSomebodyListensAndPassesItOnUntilTheReply) {
  EditOutbox outbox;
  std::vector<double> shares;
  Log log;
  EditCallbacks callbacks = log.callbacks();
  callbacks.progress = [&](const v1::EditProgress& message) { shares.push_back(message.share()); };
  outbox.submit({}, callbacks, kEpoch);
  outbox.submit({}, log.callbacks(), kEpoch);
  EXPECT_TRUE(outbox.next()->progress());
  EXPECT_FALSE(outbox.next()->progress());
  for (const double share : {0.5, std::numeric_limits<double>::quiet_NaN(), -1.0, 1e300}) {
    outbox.progress(progress(1, share));
  }
  outbox.progress(progress(2, 0.5));
  outbox.progress(progress(3, 0.5));
  EXPECT_EQ(shares, (std::vector<double>{0.5, 0, 0, 1})) << "whatever a server says";
  outbox.replied(accepted(1, 5), kNow_ns);
  outbox.progress(progress(1, 0.75));
  EXPECT_EQ(shares.size(), 4U);
}

TEST(EditOutbox, NumbersEditsFromOneInTheirOrder) {
  EditOutbox outbox;
  outbox.submit(removal(5), {}, kEpoch);
  outbox.submit(removal(6), {}, kEpoch);
  EXPECT_EQ(sendAll(outbox), (Lines{"1:5", "2:6"}));
  EXPECT_EQ(sendAll(outbox), Lines{});
}

TEST(EditOutbox, ReportsTheReplyAndThenThatItIsLive) {
  EditOutbox outbox;
  Log log;
  outbox.submit(removal(5), log.callbacks(), kEpoch);
  (void)sendAll(outbox);
  outbox.replied(accepted(1, 12), kNow_ns);
  outbox.live(live(1, 900));
  EXPECT_EQ(log.lines, (Lines{"1 accepted 12", "1 live 900"}));
}

TEST(EditOutbox, IsPutOffForNoLongerThanItsPatience) {
  EditOutbox outbox;
  outbox.submit(removal(5), {}, kEpoch);
  (void)sendAll(outbox);
  v1::EditReply inWeeks = tooEarly(1);
  inWeeks.mutable_rejected()->set_retry_after_ms(UINT32_MAX);
  outbox.replied(inWeeks, kNow_ns);
  outbox.poll(kNow_ns + EditOutbox::kPatience_ns);
  EXPECT_EQ(sendAll(outbox), Lines{"1:5"});
}

TEST(EditOutbox, SendsUnansweredEditsAgainUnchangedAndInOrder) {
  EditOutbox outbox;
  Log log;
  for (const std::uint64_t object : {5, 6, 7}) outbox.submit(removal(object), log.callbacks(), kEpoch);
  (void)sendAll(outbox);
  outbox.replied(rejected(2), kNow_ns);
  outbox.connectionLost();
  EXPECT_EQ(sendAll(outbox), (Lines{"1:5", "3:7"}));
}

TEST(EditOutbox, LearnsFromTheServosRevisionThatAnAcceptedEditIsLive) {
  EditOutbox outbox;
  Log log;
  for (const std::uint64_t object : {5, 6, 7}) outbox.submit(removal(object), log.callbacks(), kEpoch);
  (void)sendAll(outbox);
  outbox.replied(accepted(1, 12), kNow_ns);
  outbox.replied(accepted(2, 14), kNow_ns);
  outbox.connectionLost();
  EXPECT_EQ(sendAll(outbox), Lines{"3:7"}) << "only what was not answered is sent again";
  outbox.adopted(11, 800);
  outbox.adopted(13, 900);
  outbox.adopted(14, 950);
  EXPECT_EQ(log.lines, (Lines{"1 accepted 12", "2 accepted 14", "1 live 900", "2 live 950"}));
}

TEST(EditOutbox, SendsWhatCameTooEarlyAgainInOrderOnceAllAnswersAreHere) {
  EditOutbox outbox;
  Log log;
  for (const std::uint64_t object : {5, 6, 7}) outbox.submit(removal(object), log.callbacks(), kEpoch);
  (void)sendAll(outbox);
  outbox.replied(accepted(1, 12), kNow_ns);
  outbox.replied(tooEarly(2), kNow_ns);
  outbox.submit(removal(8), log.callbacks(), kEpoch);
  EXPECT_EQ(sendAll(outbox), Lines{}) << "would overtake";
  outbox.poll(kNow_ns + 200 * kMillisecond_ns);
  EXPECT_EQ(sendAll(outbox), Lines{}) << "the third edit's answer is still under way";
  outbox.replied(tooEarly(3), kNow_ns + 250 * kMillisecond_ns);
  outbox.poll(kNow_ns + 349 * kMillisecond_ns);
  EXPECT_EQ(sendAll(outbox), Lines{});
  outbox.poll(kNow_ns + 350 * kMillisecond_ns);
  EXPECT_EQ(sendAll(outbox), (Lines{"2:6", "3:7", "4:8"}));
  EXPECT_EQ(log.lines, Lines{"1 accepted 12"});
}

TEST(EditOutbox, ANewConnectionNeedNotWaitAsTheOldOneHadTo) {
  EditOutbox outbox;
  outbox.submit(removal(5), {}, kEpoch);
  (void)sendAll(outbox);
  outbox.replied(tooEarly(1), kNow_ns);
  outbox.connectionLost();
  EXPECT_EQ(sendAll(outbox), Lines{"1:5"});
}

TEST(EditOutbox, LosesPatienceWithAServerThatIsAlwaysBusy) {
  EditOutbox outbox;
  Log log;
  outbox.submit(removal(5), log.callbacks(), kEpoch);
  (void)sendAll(outbox);
  std::uint64_t now_ns = kNow_ns;
  for (; log.lines.empty() && now_ns < kNow_ns + 2 * EditOutbox::kPatience_ns; now_ns += 1000 * kMillisecond_ns) {
    outbox.replied(tooEarly(1), now_ns);
    outbox.poll(now_ns + 500 * kMillisecond_ns);
    (void)sendAll(outbox);
  }
  EXPECT_EQ(log.lines, Lines{"1 rejected"});
  EXPECT_NEAR(static_cast<double>(now_ns - kNow_ns), EditOutbox::kPatience_ns, 2e9);
}

TEST(EditOutbox, DoesNotWaitForLiveWhenNobodyAsked) {
  EditOutbox outbox;
  outbox.submit(removal(5), {}, kEpoch);
  (void)sendAll(outbox);
  outbox.replied(accepted(1, 12), kNow_ns);
  outbox.connectionLost();
  EXPECT_EQ(sendAll(outbox), Lines{});
}

TEST(EditOutbox, IgnoresAnswersToWhatItDidNotAsk) {
  EditOutbox outbox;
  Log log;
  outbox.submit(removal(5), log.callbacks(), kEpoch);
  (void)sendAll(outbox);
  outbox.replied(accepted(2, 12), kNow_ns);
  outbox.live(live(1, 900));  // live before it was accepted
  outbox.replied(rejected(1), kNow_ns);
  outbox.replied(rejected(1), kNow_ns);
  outbox.live(live(1, 900));
  EXPECT_EQ(log.lines, Lines{"1 rejected"});
}

TEST(EditOutbox, TellsOfAcceptedEditsThatAServerLostWithItsState) {
  EditOutbox outbox;
  Log log;
  outbox.submit(removal(5), log.callbacks(), kEpoch);
  outbox.submit(removal(6), log.callbacks(), kEpoch);
  (void)sendAll(outbox);
  outbox.replied(accepted(1, 12), kNow_ns);
  outbox.connectionLost();
  outbox.stateLost();
  EXPECT_EQ(sendAll(outbox), Lines{"2:6"});
  EXPECT_EQ(log.lines, (Lines{"1 accepted 12", "lost"}));
}

TEST(EditOutbox, KeepsFewInFlight) {
  EditOutbox outbox;
  for (std::size_t i = 0; i < EditOutbox::kMaxInFlight + 5; ++i) outbox.submit(removal(i), {}, kEpoch);
  EXPECT_EQ(sendAll(outbox).size(), EditOutbox::kMaxInFlight);
  outbox.replied(accepted(1, 1), kNow_ns);
  EXPECT_EQ(sendAll(outbox).size(), 1U);
}

TEST(EditOutbox, RejectsOneEditTooManyAtOnce) {
  EditOutbox outbox;
  Log log;
  for (std::size_t i = 0; i < EditOutbox::kMaxPendingEdits; ++i) outbox.submit(removal(i), {}, kEpoch);
  outbox.submit(removal(1), log.callbacks(), kEpoch);
  EXPECT_EQ(log.lines, Lines{"0 rejected"});
}

TEST(EditOutbox, RejectsAnEditLargerThanAFrameAtOnceAndTakesTheLargest) {
  EditOutbox outbox;
  Log log;
  v1::Transaction transaction = removal(1);
  std::string& name = *transaction.add_operations()->mutable_add()->mutable_name();
  name.resize(kMaxFrameBytes);
  outbox.submit(transaction, log.callbacks(), kEpoch);
  EXPECT_EQ(log.lines, Lines{"0 rejected"});
  name.resize(name.size() - (transaction.ByteSizeLong() - kMaxFrameBytes) - 64);
  outbox.submit(transaction, log.callbacks(), kEpoch);
  const v1::EditRequest* request = outbox.next();
  ASSERT_NE(request, nullptr);
  v1::Envelope envelope;
  envelope.set_protocol_version(kProtocolVersion);
  envelope.set_message_id(~0ULL);
  *envelope.mutable_edit_request() = *request;
  EXPECT_LE(envelope.ByteSizeLong(), kMaxFrameBytes);
}

TEST(EditOutbox, GivesUpTheOldestEditWhoseAnswerCannotBeReadTwice) {
  EditOutbox outbox;
  Log log;
  outbox.answerUnreadable();
  for (const std::uint64_t object : {5, 6, 7}) outbox.submit(removal(object), log.callbacks(), kEpoch);
  (void)sendAll(outbox);
  outbox.replied(accepted(1, 1), kNow_ns);
  for (const Lines& again : {Lines{"2:6", "3:7"}, Lines{"3:7"}}) {
    outbox.answerUnreadable();
    outbox.connectionLost();
    if (again.size() == 2) outbox.answerUnreadable();  // nothing is sent: it is the answer to none
    EXPECT_EQ(sendAll(outbox), again);
  }
  EXPECT_EQ(log.lines, (Lines{"1 accepted 1", "2 rejected"}));
}

TEST(EditOutbox, LetsACallbackSubmitTheNextEdit) {
  EditOutbox outbox;
  Log log;
  outbox.submit(removal(5),
                {.replied = [&](const v1::EditReply&) { outbox.submit(removal(6), log.callbacks(), kEpoch); },
                 .live = [&](const v1::EditLive&) { outbox.submit(removal(7), log.callbacks(), kEpoch); }},
                kEpoch);
  (void)sendAll(outbox);
  outbox.replied(accepted(1, 1), kNow_ns);
  outbox.live(live(1, 1));
  EXPECT_EQ(sendAll(outbox), (Lines{"2:6", "3:7"}));
}

}  // namespace
}  // namespace haptics::edit_outbox_test
