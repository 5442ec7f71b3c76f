#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/haptic_server/net/session_world.h"

namespace haptics::session_roles_test {
namespace {

using namespace test;
using Kind = v1::Envelope;

class SessionRoles : public ::testing::Test, public SessionWorld {
 protected:
  SessionRoles() { edit(test::edit(add("a"))); }
  void hello(const std::string& token) {
    v1::Envelope envelope;
    envelope.mutable_hello()->set_session(kClientSession);
    envelope.mutable_hello()->set_token(token);
    client.send(envelope);
    link.settle();
  }
  [[nodiscard]] const v1::EditReply& editReply() {
    const auto replies = client.all(Kind::kEditReply);
    EXPECT_EQ(replies.size(), 1U);
    reply_ = replies.empty() ? v1::EditReply{} : replies[0].edit_reply();
    return reply_;
  }

 private:
  v1::EditReply reply_;
};

TEST_F(SessionRoles, ComeWithTheToken) {
  role = Role::kView;
  hello("my token");
  EXPECT_THAT(tokens, ::testing::ElementsAre("my token"));
  ASSERT_EQ(client.count(Kind::kWelcome), 1U);
  EXPECT_FALSE(client.all(Kind::kWelcome)[0].welcome().may_edit());
  EXPECT_EQ(client.count(Kind::kSnapshotEnd), 1U) << "a viewer sees the scene";
}

TEST_F(SessionRoles, AViewerDoesNotLeadTheHand) {
  role = Role::kView;
  hello("");
  v1::Envelope envelope;
  envelope.mutable_lead_hand()->set_lead(true);
  client.send(envelope);
  link.settle();
  const v1::HandLeader answer = client.all(v1::Envelope::kHandLeader).at(0).hand_leader();
  EXPECT_EQ(answer.refused().substr(0, 14), "role: is view;");
  EXPECT_FALSE(answer.led());
}

TEST_F(SessionRoles, AViewerAddsNoForce) {
  role = Role::kView;
  hello("");
  v1::Envelope envelope;
  envelope.mutable_add_wrench()->mutable_force_n()->set_x(1);
  client.send(envelope);
  link.settle();
  EXPECT_EQ(client.refusal().field(), "add_wrench");
}

TEST_F(SessionRoles, AViewerDoesNotMoveTheWorkspace) {
  role = Role::kView;
  hello("");
  v1::Envelope envelope;
  envelope.mutable_set_workspace()->set_scale(2);
  client.send(envelope);
  link.settle();
  EXPECT_EQ(client.refusal().field(), "set_workspace");
}

TEST_F(SessionRoles, EditorsMayEdit) {
  hello("");
  EXPECT_TRUE(client.all(Kind::kWelcome)[0].welcome().may_edit());
  client.moveObject(1, "a", 0.5);
  link.settle();
  EXPECT_TRUE(editReply().has_accepted());
}

TEST_F(SessionRoles, ViewersEditsAreAnsweredAndChangeNothing) {
  role = Role::kView;
  hello("");
  const ContentHash root = history()->version.root();
  client.moveObject(7, "a", 0.5);
  link.settle();
  EXPECT_EQ(editReply().client_seq(), 7U);
  EXPECT_EQ(editReply().rejected().field(), "role");
  EXPECT_EQ(history()->version.root(), root);
  EXPECT_FALSE(client.closed);
  EXPECT_TRUE(session.welcomed());
}

TEST_F(SessionRoles, ViewersUploadsAreAnsweredOnceAndHeldNowhere) {
  role = Role::kView;
  hello("");
  const ContentHash hash = Hasher().add(std::uint64_t{1}).finish();
  client.upload(hash, 100, 0, std::string(50, 'x'));
  client.upload(hash, 100, 50, std::string(50, 'x'));
  link.settle();
  const auto replies = client.all(Kind::kAssetUploadReply);
  ASSERT_EQ(replies.size(), 1U);
  EXPECT_EQ(replies[0].asset_upload_reply().hash(), hash.asBytes());
  EXPECT_FALSE(replies[0].asset_upload_reply().accepted());
  EXPECT_EQ(replies[0].asset_upload_reply().field(), "role");
  EXPECT_EQ(reserved, 0U);
  EXPECT_TRUE(building.empty());
  EXPECT_FALSE(client.closed);
}

TEST_F(SessionRoles, ViewersSayNothingLarge) {
  role = Role::kView;
  hello("");
  client.sendBytes(std::string("\0\0\x02\0", 4));  // 128 KiB
  link.settle();
  EXPECT_EQ(client.refusal().field(), "frame.length");
  EXPECT_THAT(client.refusal().reason(), ::testing::HasSubstr("editor.credentials"));
}

TEST_F(SessionRoles, ViewersSayLittle) {
  role = Role::kView;
  hello("");
  for (int i = 0; i < 200 && !client.closed; ++i) {  // each of them is small
    client.moveObject(1, std::string(2000, 'a'), 0.5);
    link.settle();
  }
  EXPECT_EQ(client.refusal().field(), "role");
  EXPECT_TRUE(client.closed);
}

TEST_F(SessionRoles, EditorsMaySayMuch) {
  hello("");
  for (int i = 0; i < 200; ++i) {
    client.moveObject(1, std::string(2000, 'a'), 0.5);
    link.settle();
  }
  EXPECT_FALSE(client.closed);
}

class SessionDumps : public SessionRoles {
 protected:
  void ask() {
    v1::Envelope envelope;
    envelope.mutable_dump_request();
    client.send(envelope);
    link.settle();
  }
  [[nodiscard]] v1::DumpReply reply() {
    const auto replies = client.all(Kind::kDumpReply);
    EXPECT_EQ(replies.size(), 1U);
    return replies.empty() ? v1::DumpReply{} : replies[0].dump_reply();
  }
};

TEST_F(SessionDumps, AreAnsweredWithTheirFileOrWhyThereIsNone) {
  hello("");
  ask();
  EXPECT_EQ(dumpsAsked, 1);
  EXPECT_EQ(client.count(Kind::kDumpReply), 0U) << "not written yet";
  session.dumped(std::string("/there/file"));
  link.settle();
  EXPECT_EQ(reply().file(), "/there/file");
  client.got.clear();
  session.dumped(haptics::refused("/there", "no space left"));
  link.settle();
  EXPECT_EQ(reply().file(), "");
  EXPECT_EQ(reply().reason(), "/there: no space left");
}

TEST_F(SessionDumps, AreNotForViewers) {
  role = Role::kView;
  hello("");
  ask();
  EXPECT_EQ(dumpsAsked, 0);
  EXPECT_THAT(reply().reason(), ::testing::HasSubstr("editor.credentials"));
}

TEST_F(SessionDumps, AreRefusedWhereNothingIsRecorded) {
  records = false;
  hello("");
  ask();
  EXPECT_THAT(reply().reason(), ::testing::HasSubstr("does not record"));
}

TEST_F(SessionRoles, WhoeverHasNoneIsRefusedBeforeAnythingIsSaid) {
  role = haptics::refused("hello.token", "is not one that this server knows");
  hello("guess");
  EXPECT_EQ(client.refusal().field(), "hello.token");
  EXPECT_EQ(client.got.size(), 1U);
  EXPECT_FALSE(session.welcomed());
  EXPECT_FALSE(claimed);
  EXPECT_TRUE(client.closed);
}

}  // namespace
}  // namespace haptics::session_roles_test
