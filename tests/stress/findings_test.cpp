// That the judge finds what it is there to find: each case is a run that went well, with one thing wrong.
#include "tests/stress/findings.h"

#include <gtest/gtest.h>

namespace haptics::stress::findings_test {
namespace {

constexpr std::uint64_t kSecond_ns = 1'000'000'000;

/// Two clients, each with three edits; every second one is an increment.
Evidence goodRun() {
  Evidence evidence;
  evidence.lives = {{0, 1, false, false, {}}, {1, 1, true, false, {}}};
  std::uint64_t revision = 10, counter = 0;
  for (std::uint64_t number = 1; number <= 3; ++number) {
    for (ClientLife& life : evidence.lives) {
      const bool increments = revision % 2 == 0;
      if (increments) ++counter;
      Record record{.time_ns = revision * kSecond_ns, .kind = Record::Kind::kSubmitted, .number = number};
      record.value = increments ? counter : 0;
      life.records.push_back(record);
      record.kind = Record::Kind::kAccepted;
      record.revision = ++revision;
      life.records.push_back(record);
      Auditor::Commit commit{.time_ns = record.time_ns, .revision = revision, .root = {}, .marks = {}, .counter = {}};
      commit.marks = {{markName(life.client), {1, number}}};
      if (increments) commit.counter = counter;
      evidence.commits.push_back(commit);
    }
  }
  return evidence;
}

TEST(JudgeEdits, FindsNothingWrongWithAGoodRun) {
  const Edits edits = judgeEdits(goodRun());
  EXPECT_EQ(edits.accepted, 6);
  EXPECT_EQ(edits.increments, 3);
  EXPECT_EQ(edits.counter, 3);
  EXPECT_EQ(edits.lostAcked + edits.duplicated + edits.lostIncrements + edits.gaps + edits.unanswered, 0);
}

TEST(JudgeEdits, FindsAnAcknowledgedEditThatIsInNoCommit) {
  Evidence evidence = goodRun();
  evidence.commits[2].marks.clear();
  EXPECT_EQ(judgeEdits(evidence).lostAcked, 1);
}

TEST(JudgeEdits, FindsAnEditThatWasAppliedTwice) {
  Evidence evidence = goodRun();
  evidence.commits.push_back(evidence.commits[3]);
  evidence.commits.back().revision += 10;
  EXPECT_EQ(judgeEdits(evidence).duplicated, 1);
}

TEST(JudgeEdits, FindsAnIncrementThatOverwroteAnother) {
  Evidence evidence = goodRun();
  for (auto& commit : evidence.commits) {
    if (commit.counter == 3U) commit.counter = 2;
  }
  const Edits edits = judgeEdits(evidence);
  EXPECT_EQ(edits.lostIncrements, 1);
  EXPECT_NE(edits.increments, edits.counter);
}

TEST(JudgeEdits, FindsARevisionThatWentBackwards) {
  Evidence evidence = goodRun();
  for (const std::uint64_t revision : {12, 13, 12}) {
    evidence.lives[0].records.push_back({.kind = Record::Kind::kView, .revision = revision});
  }
  EXPECT_EQ(judgeEdits(evidence).gaps, 1);
}

TEST(JudgeEdits, CountsWhatAKilledClientNeverHeardOf) {
  Evidence evidence = goodRun();
  evidence.lives[0].records.pop_back();
  const Edits edits = judgeEdits(evidence);
  EXPECT_EQ(edits.unanswered, 1);
  EXPECT_EQ(edits.lostAcked + edits.duplicated, 0);
}

TEST(JudgeServo, TellsQuietFromAttackAndLeavesTheStartOut) {
  RunPlan plan;
  plan.seconds = 40;
  plan.began_ns = 100 * kSecond_ns;
  Evidence evidence;
  for (std::uint64_t ms = 0; ms < 40'000; ms += 5) {
    const std::uint64_t now_ns = plan.began_ns + ms * 1'000'000;
    const std::uint64_t start = ms < 1'000 ? ms : 1'000;  // a tick missed each millisecond of the start
    const std::uint64_t later = plan.attackAt(now_ns) ? 7 : 0;
    const std::uint64_t before = evidence.pulses.empty() ? 0 : evidence.pulses.back().missedTicks;
    evidence.pulses.push_back({now_ns, ms, std::max(before + later, start), 1, now_ns});
  }
  const Punctuality servo = judgeServo(evidence, plan);
  EXPECT_EQ(servo.quiet.missed, 0);
  EXPECT_GT(servo.attack.missed, 1'000);
  EXPECT_NEAR(static_cast<double>(servo.attack.missed), 7.0 * static_cast<double>(servo.attack.bursts), 1);
  EXPECT_LT(servo.pBursts, 1e-6);
}

}  // namespace
}  // namespace haptics::stress::findings_test
