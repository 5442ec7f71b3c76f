#include "graphics_client/audience/stored_session.h"

#include <gtest/gtest.h>

#include "tests/graphics_client/audience/published_session.h"

namespace haptics::stored_session_test {
namespace {

TEST(StoredSession, IsTheSnapshotWithTheCommitsBehindIt) {
  PublishedSession published;
  published.storeSnapshot();
  for (const char* name : {"c", "d"}) {
    published.store(published.subjects.commit, published.commit(name).SerializeAsString());
  }
  const auto session = published.read();
  ASSERT_TRUE(session) << session.error().text();
  EXPECT_EQ(session->scene.root(), published.server.scene.root());
  EXPECT_EQ(session->lastSequence, published.stored.size());
}

TEST(StoredSession, GoesOnFromTheOneBeforeWhereASnapshotWasLeftUnfinished) {
  PublishedSession published;
  published.storeSnapshot();
  const std::size_t whole = published.stored.size();
  published.storeSnapshot();
  published.stored.resize(whole + 1);
  published.store(published.subjects.commit, published.commit("c").SerializeAsString());
  const auto session = published.read();
  ASSERT_TRUE(session) << session.error().text();
  EXPECT_EQ(session->scene.root(), published.server.scene.root());
}

TEST(StoredSession, TakesACommitOnceHoweverOftenItIsStored) {
  PublishedSession published;
  published.storeSnapshot();
  const std::string commit = published.commit("c").SerializeAsString();
  published.store(published.subjects.commit, commit);
  published.store(published.subjects.commit, commit);
  const auto session = published.read();
  ASSERT_TRUE(session) << session.error().text();
  EXPECT_EQ(session->scene.root(), published.server.scene.root());
}

TEST(StoredSession, IsRefusedWhereACommitIsMissingOrForged) {
  PublishedSession published;
  published.storeSnapshot();
  (void)published.commit("lost");
  published.store(published.subjects.commit, published.commit("c").SerializeAsString());
  EXPECT_FALSE(published.read());

  PublishedSession forged;
  forged.storeSnapshot();
  auto commit = forged.commit("c");
  commit.mutable_commit()->mutable_put(0)->set_stiffness_n_per_m(1);
  forged.store(forged.subjects.commit, commit.SerializeAsString());
  EXPECT_FALSE(forged.read());
}

TEST(StoredSession, IsRefusedWhereTheSnapshotIsNotTheOneThatItsRootNames) {
  for (const int change : {0, 1, 2, 3}) {
    PublishedSession published;
    published.storeSnapshot();
    v1::SnapshotPart part;
    const std::size_t at = change == 0 ? 0 : change == 3 ? published.stored.size() - 1 : 1;
    ASSERT_TRUE(part.ParseFromString(published.stored[at].bytes));
    if (change == 0) part.mutable_begin()->set_object_count(1);
    if (change == 1) part.mutable_objects()->mutable_object(0)->set_name("else");
    if (change == 2) part.set_epoch(7);
    if (change == 3) part.mutable_end()->mutable_root()->assign(32, 'x');
    published.stored[at].bytes = part.SerializeAsString();
    EXPECT_FALSE(published.read()) << change;
  }
  PublishedSession huge;
  v1::SnapshotPart begin;
  begin.set_protocol_version(kProtocolVersion);
  begin.set_epoch(huge.server.epoch);
  begin.mutable_begin()->set_object_count(1ULL << 40);
  huge.store(huge.subjects.snapshot, begin.SerializeAsString());
  EXPECT_FALSE(huge.read());
}

TEST(StoredSession, NeedsAWholeSnapshotOfTheEpochThatTheLatestNames) {
  PublishedSession nothing;
  EXPECT_FALSE(nothing.read());
  PublishedSession restarted;
  restarted.storeSnapshot();
  ++restarted.server.epoch;
  EXPECT_FALSE(restarted.read());
  restarted.storeSnapshot();
  EXPECT_TRUE(restarted.read());
}

}  // namespace
}  // namespace haptics::stored_session_test
