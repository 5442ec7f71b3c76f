#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <string>
#include <vector>

#include "haptic_server/state/saved_state.h"
#include "tests/haptic_server/scene/scene_edits.h"

namespace haptics::damaged_log_test {
namespace {

using namespace test;
using ::testing::HasSubstr;

/// A log of a checkpoint and edits, in memory, and which state each of its records led to.
class LogOfEdits final : public EditJournal {
 public:
  static constexpr std::size_t kEdits = 60;

  LogOfEdits() {
    for (std::uint64_t i = 1; i <= kEdits / 2; ++i) sequencer_.submit(1 + i % 5, i, someEdit(i));
    bytes = kLogHead;
    writer_.append(bytes, checkpointRecord(sequencer_.state()));
    note();
    SequencerState state = sequencer_.state();
    sequencer_.resume(std::move(state), assets(), *this);
    for (std::uint64_t i = kEdits / 2 + 1; i <= kEdits; ++i) {
      sequencer_.submit(1 + i % 5, i, someEdit(i));
      note();
    }
  }

  Result<void> keep(const SequencerState&, const Edits& edits, const Assets&) override {
    for (const auto& edit : edits) writer_.append(bytes, editRecord(*edit));
    return {};
  }
  void resetTo(const SequencerState&, const Assets&) override {}

  struct Mark {
    std::size_t end;  ///< Bytes of the log up to here.
    SequencerState state;
  };
  [[nodiscard]] const Mark& lastMarkUpTo(std::size_t size) const {
    auto at = marks.begin();
    while (std::next(at) != marks.end() && std::next(at)->end <= size) ++at;
    return *at;
  }

  std::string bytes;
  std::vector<Mark> marks;  ///< After the checkpoint and after each edit.

 private:
  BoxResolver resolver_;
  Sequencer sequencer_{77, resolver_};
  RecordWriter writer_;

  static Transaction someEdit(std::uint64_t i) {
    if (i % 10 == 1) return edit(add(numbered("o", i)), add(numbered("p", i)), remove(numbered("p", i)));
    return edit(moveTo(numbered("o", i - (i - 1) % 10), {double(i), 0, 0}));
  }
  void note() { marks.push_back({bytes.size(), sequencer_.state()}); }
  [[nodiscard]] Sequencer::Assets assets() const {
    Sequencer::Assets assets;
    for (const auto& object : sequencer_.history()->version.objects())
      assets[object->id] = sequencer_.assetsOf(object->id);
    return assets;
  }
};

/// Equal in everything that a client can find out.
void expectEqual(const SequencerState& a, const SequencerState& b) {
  ASSERT_EQ(a.history->epoch, b.history->epoch);
  ASSERT_EQ(a.history->version.revision(), b.history->version.revision());
  ASSERT_EQ(a.history->version.root(), b.history->version.root());
  ASSERT_EQ(a.nextId, b.nextId);
  ASSERT_EQ(a.history->edits.size(), b.history->edits.size());
  for (std::size_t i = 0; i < a.history->edits.size(); ++i) {
    ASSERT_EQ(a.history->edits[i]->commit.root, b.history->edits[i]->commit.root);
    ASSERT_EQ(a.history->edits[i]->reports, b.history->edits[i]->reports);
  }
  for (SessionId session = 1; session <= 5; ++session) {
    for (std::uint64_t seq = 1; seq <= LogOfEdits::kEdits; ++seq) {
      const auto x = a.memory.find(session, seq), y = b.memory.find(session, seq);
      ASSERT_EQ(x.answer, y.answer) << session << ' ' << seq;
      ASSERT_EQ(x.result.revision, y.result.revision);
      ASSERT_EQ(x.result.root, y.result.root);
    }
  }
}

class DamagedLog : public ::testing::Test {
 protected:
  static const LogOfEdits& log() {
    static const LogOfEdits log;
    return log;
  }
  static std::size_t checkpointEnd() { return log().marks.front().end; }

  /// The log is read as damaged, and leads to the state after the last record that ends at or before `good`.
  static void expectDamageAfter(const std::string& bytes, std::size_t good, bool torn) {
    const auto saved = readLog(bytes);
    ASSERT_TRUE(saved);
    ASSERT_TRUE(saved->damage);
    EXPECT_EQ(saved->damage->torn, torn) << saved->damage->reason;
    const auto& mark = log().lastMarkUpTo(good);
    EXPECT_EQ(saved->damage->offset, mark.end);
    EXPECT_EQ(saved->damage->dropped, bytes.size() - mark.end);
    expectEqual(saved->state, mark.state);
  }
};

TEST_F(DamagedLog, IsReadAsItWasWrittenWhenItIsWhole) {
  const auto saved = readLog(log().bytes);
  ASSERT_TRUE(saved) << saved.error().text();
  EXPECT_FALSE(saved->damage);
  EXPECT_EQ(saved->state.history->version.revision(), LogOfEdits::kEdits);
  expectEqual(saved->state, log().marks.back().state);
}

TEST_F(DamagedLog, CanBeWrittenOn) {
  auto saved = readLog(std::string_view(log().bytes).substr(0, log().marks[3].end));
  ASSERT_TRUE(saved);
  std::string bytes = log().bytes.substr(0, log().marks[3].end);
  const auto& edits = log().marks[4].state.history->edits;
  saved->writer.append(bytes, editRecord(*edits.back()));
  EXPECT_EQ(bytes, log().bytes.substr(0, log().marks[4].end));
}

TEST_F(DamagedLog, CutOffAtAnyByteItIsTheStateOfTheRecordsBefore) {
  for (std::size_t size = checkpointEnd(); size < log().bytes.size(); ++size) {
    const std::string cut = log().bytes.substr(0, size);
    if (log().lastMarkUpTo(size).end == size) {
      const auto saved = readLog(cut);
      ASSERT_TRUE(saved && !saved->damage) << size;
      expectEqual(saved->state, log().lastMarkUpTo(size).state);
    } else {
      expectDamageAfter(cut, size, true);
    }
    if (HasFatalFailure() || HasNonfatalFailure()) FAIL() << "cut to " << size;
  }
}

TEST_F(DamagedLog, CutOffWithinItsCheckpointItIsThatOfTheCopy) {
  const std::string beginning = log().bytes.substr(0, checkpointEnd());
  for (std::size_t size = 0; size < checkpointEnd(); ++size) {
    const auto cut = std::string_view(log().bytes).substr(0, size);
    ASSERT_FALSE(readLog(cut)) << size;
    const auto repaired = readLogBehind(beginning, cut);
    ASSERT_TRUE(repaired && repaired->damage && !repaired->damage->torn) << size;
    ASSERT_EQ(repaired->state.history->version.root(), log().marks[0].state.history->version.root());
  }
}

TEST_F(DamagedLog, DoesNotFollowTheBeginningOfAnother) {
  std::string other(kLogHead);
  SequencerState state = log().marks[0].state;
  auto history = std::make_shared<SceneHistory>(*state.history);
  history->epoch = 78;
  state.history = history;
  RecordWriter().append(other, checkpointRecord(state));
  ASSERT_EQ(other.size(), checkpointEnd());
  const auto saved = readLogBehind(other, log().bytes);
  ASSERT_TRUE(saved && saved->damage);
  EXPECT_EQ(saved->damage->offset, checkpointEnd());
  EXPECT_FALSE(saved->damage->torn);
}

TEST_F(DamagedLog, ABitThatFlippedAnywhereIsFound) {
  std::mt19937 random(4);
  int inCheckpoint = 0;
  for (int i = 0; i < 1000; ++i) {
    std::string flipped = log().bytes;
    const std::size_t at = random() % flipped.size();
    flipped[at] = static_cast<char>(flipped[at] ^ 1U << random() % 8);
    if (at < checkpointEnd()) {
      ASSERT_FALSE(readLog(flipped)) << at;
      const auto repaired = readLogBehind(log().bytes.substr(0, checkpointEnd()), flipped);
      ASSERT_TRUE(repaired && !repaired->damage) << at;
      expectEqual(repaired->state, log().marks.back().state);
      ++inCheckpoint;
    } else {
      expectDamageAfter(flipped, at, false);
    }
    if (HasFatalFailure() || HasNonfatalFailure()) FAIL() << "flipped at " << at;
  }
  EXPECT_GT(inCheckpoint, 100);
  EXPECT_LT(inCheckpoint, 900);
}

TEST_F(DamagedLog, EveryBitOfALengthIsGuarded) {
  for (std::size_t bit = 0; bit < 64; ++bit) {
    std::string flipped = log().bytes;
    char& byte = flipped[log().marks[5].end + bit / 8];
    byte = static_cast<char>(byte ^ 1U << bit % 8);
    expectDamageAfter(flipped, log().marks[5].end, false);
    if (HasFatalFailure() || HasNonfatalFailure()) FAIL() << "bit " << bit;
  }
}

TEST_F(DamagedLog, ARecordThatIsMissingOrDoubleOrMovedIsFound) {
  const auto& marks = log().marks;
  const auto record = [&](std::size_t i) {
    return log().bytes.substr(marks[i - 1].end, marks[i].end - marks[i - 1].end);
  };
  const std::string head = log().bytes.substr(0, marks[4].end);
  expectDamageAfter(head + record(6) + record(7), marks[4].end, false);
  expectDamageAfter(head + record(4) + record(5), marks[4].end, false);
  expectDamageAfter(head + record(6) + record(5), marks[4].end, false);
}

TEST_F(DamagedLog, ZerosInPlaceOfItsEndAreWhatACrashLeaves) {
  expectDamageAfter(log().bytes + std::string(4096, '\0'), log().bytes.size(), true);
  const auto& marks = log().marks;
  for (std::size_t size = marks[4].end; size < marks[5].end; ++size) {
    expectDamageAfter(log().bytes.substr(0, size) + std::string(marks[5].end - size, '\0'), marks[4].end, true);
    if (HasFatalFailure() || HasNonfatalFailure()) FAIL() << "zeros from " << size;
  }
}

TEST_F(DamagedLog, AnythingElseBehindItIsNot) {
  expectDamageAfter(log().bytes + std::string(300, '\x5a'), log().bytes.size(), false);
}

TEST_F(DamagedLog, ARecordThatDoesNotFollowIsNotApplied) {
  const auto& marks = log().marks;
  auto saved = readLog(std::string_view(log().bytes).substr(0, marks[4].end));
  std::string bytes = log().bytes.substr(0, marks[4].end);
  saved->writer.append(bytes, editRecord(*marks[6].state.history->edits.back()));
  expectDamageAfter(bytes, marks[4].end, false);
}

TEST(ReadLog, SaysThatAnotherFormatIsNotItsOwn) {
  const auto saved = readLog("haptics state 2\nwho knows what");
  ASSERT_FALSE(saved);
  EXPECT_THAT(saved.error().text(), HasSubstr("version"));
}

}  // namespace
}  // namespace haptics::damaged_log_test
