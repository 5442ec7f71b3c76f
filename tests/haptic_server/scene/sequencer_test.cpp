#include "haptic_server/scene/sequencer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "common/deform/free_form.h"
#include "common/mesh/mesh_asset.h"
#include "haptic_server/engine/step/servo_scene.h"
#include "haptic_server/scene/edit_price.h"
#include "haptic_server/scene/scene_limits.h"
#include "tests/haptic_server/scene/scene_edits.h"

namespace haptics::sequencer_test {
namespace {

using namespace test;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::SizeIs;

constexpr SessionId kAlice = 11;
constexpr SessionId kBob = 12;
constexpr std::uint64_t kEpoch = 5;

class SequencerTest : public ::testing::Test {
 protected:
  EditOutcome submit(const Transaction& transaction) { return sequencer.submit(kAlice, ++seq, transaction); }
  Accepted accept(const Transaction& transaction) {
    const EditOutcome outcome = submit(transaction);
    if (const auto* error = std::get_if<Error>(&outcome)) ADD_FAILURE() << error->text();
    return std::get<Accepted>(outcome);
  }
  Error reject(const Transaction& transaction) {
    const auto before = sequencer.history();
    const EditOutcome outcome = submit(transaction);
    EXPECT_EQ(sequencer.history(), before) << "a rejected edit left a trace";
    return std::get<Error>(outcome);
  }
  [[nodiscard]] const SceneVersion& version() const { return sequencer.history()->version; }

  BoxResolver resolver;
  Sequencer sequencer{kEpoch, resolver};
  std::uint64_t seq = 0;
};

TEST_F(SequencerTest, GivesEachAcceptedTransactionOneRevision) {
  const ContentHash empty = version().root();
  const auto first = accept(edit(add("a"), add("b"), moveTo("a", {0, 0, 1})));
  EXPECT_EQ(first->commit.revision, 1U);
  EXPECT_EQ(first->commit.prevRoot, empty);
  EXPECT_EQ(first->commit.root, version().root());
  EXPECT_THAT(first->reports, ElementsAre("a: made", "b: made"));
  EXPECT_THAT(first->commit.put, SizeIs(2));
  EXPECT_EQ(first->commit.put[0].name, "a");
  EXPECT_EQ(first->commit.put[0].pose.position, Vec3(0, 0, 1));

  const auto second = accept(edit(remove("a")));
  EXPECT_EQ(second->commit.revision, 2U);
  EXPECT_EQ(second->commit.prevRoot, first->commit.root);
  EXPECT_THAT(second->commit.removed, ElementsAre(first->commit.put[0].id));
}

TEST_F(SequencerTest, AMirrorThatAppliesTheCommitsHasTheSameRoots) {
  SceneVersion mirror;
  for (const Transaction& t :
       {edit(add("a"), add("b", box(0.2))), edit(moveTo("b", {1, 2, 3}), remove("a")),
        edit(add("a", box(0.3)), RemeshObject{named("b"), box(0.4)}),
        edit(SetMaterial{named("a"), {900.0, std::nullopt, Color{1, 0, 0}}}), edit(add("c"), remove("c"))}) {
    const auto edit = accept(t);
    ASSERT_EQ(mirror.root(), edit->commit.prevRoot);
    mirror = mirror.apply(edit->commit).value();
    ASSERT_EQ(mirror.root(), edit->commit.root);
  }
  EXPECT_EQ(mirror.objects().size(), 2U);
}

TEST_F(SequencerTest, GivesAndTakesMotionsAndRemembersWhenAPoseWasSet) {
  accept(edit(add("a"), add("b")));
  const ObjectId a = version().find("a")->id;
  EXPECT_EQ(sequencer.posedAt(a), 0U);
  accept(edit(SetMotion{named("a"), MotionProperties{.mass_kg = 0.2}}));
  EXPECT_EQ(version().find("a")->motion, MotionProperties{.mass_kg = 0.2});
  EXPECT_EQ(sequencer.posedAt(a), 0U);
  const Vec3 same = version().find("a")->pose.position;
  accept(edit(moveTo("a", same)));
  EXPECT_EQ(sequencer.posedAt(a), 3U) << "also to the same pose";
  reject(edit(moveTo("a", {1, 0, 0}), remove("nobody")));
  EXPECT_EQ(sequencer.posedAt(a), 3U);
  accept(edit(SetMotion{named("a"), std::nullopt}));
  EXPECT_FALSE(version().find("a")->motion);
  accept(edit(remove("a")));
  EXPECT_EQ(sequencer.posedAt(a), 0U);
}

TEST_F(SequencerTest, BoundsWhatATickMayHaveToLookAtOfPaths) {
  Effect guide{.kind = Effect::Kind::kGuide, .stiffness_N_per_m = 100};
  for (std::size_t i = 0; i < kMaxPathPoints; ++i) guide.path_m.emplace_back(1e-4 * static_cast<double>(i), 0, 0);
  accept(edit(add("a"), add("b")));
  accept(edit(SetEffects{named("a"), {guide, guide}}));
  accept(edit(SetEffects{named("a"), {guide, guide}}));
  const Error refused = reject(edit(SetEffects{named("b"), {guide}}));
  EXPECT_EQ(refused.field, "operations[0].set_effects.effects");
  EXPECT_THAT(refused.reason,
              HasSubstr("paths of 4096 points, and other objects of 8192; those of a scene have at most 8192"));
  accept(edit(SetEffects{named("b"), {{.kind = Effect::Kind::kSpringToPoint, .stiffness_N_per_m = 100}}}));
  accept(edit(SetEffects{named("a"), {}}, SetEffects{named("b"), {guide}}));
}

TEST_F(SequencerTest, OnlyAClosedMeshHasAnInside) {
  TriMesh open = makeBox(Vec3(0.1), 1).value();
  open.triangles.pop_back();
  auto surface = buildCollisionMesh(open.vertices, open.triangles);
  const auto kept = resolver.store().intern(std::move(open), std::move(surface));
  const MeshSource sheet{AssetSource{kept->name.hash}};
  const std::vector<Effect> fluid{
      {.kind = Effect::Kind::kSpringToPoint, .stiffness_N_per_m = 100},
      {.kind = Effect::Kind::kViscosity, .damping_Ns_per_m = 1, .region = Effect::Region::kInside}};
  accept(edit(add("a"), add("b", sheet)));
  accept(edit(SetEffects{named("a"), fluid}));
  const Error refused = reject(edit(SetEffects{named("b"), fluid}));
  EXPECT_EQ(refused.field, "operations[0].set_effects.effects[1].region");
  EXPECT_THAT(refused.reason, HasSubstr("the mesh is not closed; close its holes"));
  const Error remeshed = reject(edit(RemeshObject{named("a"), sheet}));
  EXPECT_EQ(remeshed.field, "operations[0].remesh.mesh");
  EXPECT_THAT(remeshed.reason, HasSubstr("effects[1].region, which is EFFECT_REGION_INSIDE"));
  accept(edit(RemeshObject{named("a"), sheet}, SetEffects{named("a"), {fluid[0]}}));
}

TEST_F(SequencerTest, GivesAndTakesEffectsOfWhichASceneHas32) {
  const Effect spring{.kind = Effect::Kind::kSpringToPoint, .stiffness_N_per_m = 100};
  SceneVersion mirror;
  const auto follow = [&](const Accepted& edit) {
    mirror = mirror.apply(edit->commit).value();
    ASSERT_EQ(mirror.root(), edit->commit.root);
  };
  auto a = std::get<AddObject>(add("a"));
  a.effects = {spring};
  follow(accept(edit(a, add("b"))));
  const ContentHash with = version().find("a")->hash();
  follow(accept(edit(SetEffects{named("b"), std::vector<Effect>(31, spring)})));
  const Error refused = reject(edit(add("c"), SetEffects{named("c"), {spring}}));
  EXPECT_EQ(refused.field, "operations[1].set_effects.effects");
  EXPECT_THAT(refused.reason, HasSubstr("other objects have 32; a scene has at most 32"));
  follow(accept(edit(remove("b"), SetEffects{named("a"), {spring, spring}})));
  EXPECT_THAT(version().find("a")->effects, SizeIs(2));
  follow(accept(edit(SetEffects{named("a"), {}})));
  EXPECT_THAT(version().find("a")->effects, SizeIs(0));
  EXPECT_NE(version().find("a")->hash(), with);
}

TEST_F(SequencerTest, RefusesMorePathsThanASnapshotHolds) {
  Sequencer small(kEpoch, resolver, {.details_bytes = 5000});
  Effect guide{.kind = Effect::Kind::kGuide, .stiffness_N_per_m = 100};
  for (int i = 0; i < 300; ++i) guide.path_m.emplace_back(i, 0, 0);
  const EditOutcome refused = small.submit(kAlice, 1, edit(add("a"), SetEffects{named("a"), {guide}}));
  ASSERT_TRUE(std::holds_alternative<Error>(refused));
  EXPECT_EQ(std::get<Error>(refused).field, "operations[1].set_effects.effects");
}

TEST_F(SequencerTest, DrivesObjectsWithoutARevision) {
  accept(edit(add("a"), add("b")));
  const auto before = sequencer.history();
  const ObjectId a = version().find("a")->id;
  const auto drive = [](const std::string& name, Vec3 to) { return SetPose{named(name), {to, std::nullopt}, true}; };
  const auto first = accept(edit(drive("a", {0, 0, 1})));
  EXPECT_EQ(sequencer.history(), before);
  EXPECT_EQ(first->commit.revision, version().revision());
  EXPECT_EQ(first->commit.root, version().root());
  EXPECT_EQ(sequencer.kinematicOf(a).pose.position, Vec3(0, 0, 1));
  const std::uint64_t number = sequencer.kinematicOf(a).number;
  accept(edit(drive("a", {0, 0, 1}), drive("b", {0, 1, 0})));
  EXPECT_GT(sequencer.kinematicOf(a).number, number) << "each sample counts, also to the same place";

  accept(edit(moveTo("b", {0, 0, 0})));
  EXPECT_EQ(sequencer.kinematicOf(a).pose.position, Vec3(0, 0, 1));
  EXPECT_EQ(sequencer.kinematicOf(version().find("b")->id), KinematicPose{});
  accept(edit(remove("a")));
  EXPECT_EQ(sequencer.kinematicOf(a), KinematicPose{});
}

TEST_F(SequencerTest, ASampleThatIsSentAgainAfterALaterEditIsAnsweredAndNotApplied) {
  accept(edit(add("a")));
  const Transaction sample = edit(SetPose{named("a"), {Vec3(0, 0, 1), std::nullopt}, true});
  const std::uint64_t itsSeq = ++seq;
  static_cast<void>(sequencer.submit(kAlice, itsSeq, sample));
  accept(edit(moveTo("a", {0, 0, 2})));
  EXPECT_TRUE(std::holds_alternative<Accepted>(sequencer.submit(kAlice, itsSeq, sample)));
  EXPECT_EQ(sequencer.kinematicOf(version().find("a")->id), KinematicPose{});
}

TEST_F(SequencerTest, RefusesToDriveWhatMovesByItselfWhatIsNotThereAndBesideOtherEdits) {
  MotionProperties moving;
  moving.mass_kg = 0.1;
  accept(edit(add("a"), add("ball"), SetMotion{named("ball"), moving}));
  const auto drive = [](const std::string& name) { return SetPose{named(name), {Vec3(0), std::nullopt}, true}; };
  EXPECT_THAT(reject(edit(drive("ball"))).text(),
              HasSubstr("operations[0].set_pose.kinematic: is for objects without"));
  EXPECT_THAT(reject(edit(drive("c"))).text(), HasSubstr("there is no"));
  EXPECT_THAT(reject(edit(drive("a"), remove("a"))).text(), HasSubstr("operations[1]"));
  for (std::size_t i = 0; i < kMaxMovingBodies; ++i) accept(edit(add("more" + std::to_string(i))));
  for (std::size_t i = 0; i + 1 < kMaxMovingBodies; ++i) accept(edit(drive("more" + std::to_string(i))));
  EXPECT_THAT(reject(edit(drive("a"))).text(), HasSubstr("at most 32"));
  EXPECT_THAT(reject(edit(SetMotion{named("a"), moving})).text(), HasSubstr("33 objects that move or are driven"));
  accept(edit(moveTo("more0", {0, 0, 1}), SetMotion{named("a"), moving}));
}

TEST_F(SequencerTest, RefusesWhatClientsAndTheJournalCouldNotReadAgain) {
  AddObject large = std::get<AddObject>(add("large"));
  large.mesh.source = BoxSource{Vec3(1200), 2};
  accept(edit(large));
  const Lattice lattice{.points = {2, 2, 2}, .control_m = std::vector<Vec3f>(8, Vec3f(0.01F))};
  const SetDeformation set{named("large"), {.softness = {}, .lattice = std::optional(lattice), .latticeOfMesh = true}};
  EXPECT_THAT(reject(edit(set)).text(), HasSubstr("\"large\" an object of which nobody can read"));
  EXPECT_EQ(version().revision(), 1U);
}

TEST_F(SequencerTest, RefusesMotionsThatNoBodyHasAndMoreBodiesThanTheServoMoves) {
  accept(edit(add("a")));
  const MotionProperties impossible{.mass_kg = 1, .inertia = GivenInertia{{}, {1, 1, 3}, {}}};
  EXPECT_EQ(reject(edit(SetMotion{named("a"), impossible})).field, "operations[0].set_motion.motion.inertia");
  Transaction many;
  for (std::size_t i = 0; i < kMaxMovingBodies; ++i) {
    many.operations.push_back(AddObject{numbered("m", i), box(), {}, {}, MotionProperties{.mass_kg = 1}});
  }
  accept(many);
  const Error error = reject(edit(SetMotion{named("a"), MotionProperties{.mass_kg = 1}}));
  EXPECT_EQ(error.field, "operations[0].set_motion.motion");
  EXPECT_THAT(error.reason, HasSubstr("33 objects move; at most 32"));
  accept(edit(remove("m0"), SetMotion{named("a"), MotionProperties{.mass_kg = 1}}));
}

TEST_F(SequencerTest, TakesSeveralToolsAndRefusesOneOfTooManyPoints) {
  accept(edit(add("a")));
  accept(edit(add("b")));
  const auto tool = [](double spacing_m) { return MotionProperties{.tool = ToolProperties{spacing_m}}; };
  const Error tooFine = reject(edit(SetMotion{named("a"), tool(1e-5)}));
  EXPECT_EQ(tooFine.field, "operations[0].set_motion.motion.tool.spacing_m");
  EXPECT_THAT(tooFine.reason, HasSubstr("more than 8192 points"));
  accept(edit(SetMotion{named("a"), tool(0.05)}));
  accept(edit(SetMotion{named("a"), tool(0.06)}));
  accept(edit(SetMotion{named("b"), tool(0.05)}));
}

TEST_F(SequencerTest, RefusesAToolThatNoHandHolds) {
  accept(edit(add("a", box(1.1))));
  const auto tool = SetMotion{named("a"), MotionProperties{.tool = ToolProperties{0.05}}};
  accept(edit(tool));  // half its diagonal: 0.95 m
  const Error large = reject(edit(add("b", box(1.2)), SetMotion{named("a"), std::nullopt},
                                  SetMotion{named("b"), MotionProperties{.tool = ToolProperties{0.05}}}));
  EXPECT_EQ(large.field, "operations[2].set_motion.motion.tool");
  EXPECT_THAT(large.reason, HasSubstr("reaches 1.03"));
  EXPECT_EQ(reject(edit(RemeshObject{named("a"), box(2)})).field, "operations[0].remesh.mesh");
}

TEST_F(SequencerTest, AppliesAllOperationsOrNone) {
  accept(edit(add("a")));
  const Error error = reject(edit(moveTo("a", {1, 1, 1}), add("b"), remove("a"), moveTo("a", {2, 2, 2})));
  EXPECT_EQ(error.field, "operations[3].set_pose.object");
  EXPECT_EQ(version().find("a")->pose.position, Vec3(0));
  EXPECT_EQ(version().find("b"), nullptr);
}

TEST_F(SequencerTest, ARejectedMeshLeavesNoTrace) {
  accept(edit(add("a")));
  const Error error = reject(edit(moveTo("a", {1, 1, 1}), add("b", box()), add("c", file("head.iv"))));
  EXPECT_EQ(error.field, "operations[2].add.mesh.file");
  EXPECT_EQ(reject(edit(RemeshObject{named("a"), file("head.iv")})).field, "operations[0].remesh.mesh.file");
}

TEST_F(SequencerTest, MakesNoMeshForATransactionThatIsWrongElsewhere) {
  reject(edit(add("a"), remove("nobody")));
  EXPECT_EQ(resolver.resolved, 0);
}

TEST_F(SequencerTest, NamesEveryBadField) {
  accept(edit(add("torus"), add("box")));
  EXPECT_EQ(reject({}).field, "operations");
  EXPECT_EQ(reject(edit(add(""))).field, "operations[0].add.name");
  EXPECT_EQ(reject(edit(add("two words"))).field, "operations[0].add.name");
  EXPECT_EQ(reject(edit(add(std::string(65, 'x')))).field, "operations[0].add.name");
  EXPECT_EQ(reject(edit(add("c"), add("torus"))).field, "operations[1].add.name");
  EXPECT_EQ(reject(edit(add("c"), add("c"))).field, "operations[1].add.name");
  EXPECT_EQ(reject(edit(remove("x"))).field, "operations[0].remove.object");
  EXPECT_EQ(reject(edit(RemeshObject{named("x"), box()})).field, "operations[0].remesh.object");
  EXPECT_EQ(reject(edit(moveTo("x", {}))).field, "operations[0].set_pose.object");
  EXPECT_EQ(reject(edit(SetMaterial{named("x"), {}})).field, "operations[0].set_material.object");
  EXPECT_EQ(reject(edit(RemoveObject{ObjectRef{ObjectId{99}}})).field, "operations[0].remove.object");
}

TEST_F(SequencerTest, AnUnknownObjectIsAnsweredWithTheKnownOnes) {
  EXPECT_THAT(reject(edit(remove("torus"))).reason, HasSubstr("the scene is empty"));
  accept(edit(add("torus"), add("box")));
  EXPECT_THAT(reject(edit(remove("box"), remove("box"))).reason,
              HasSubstr("there is no object \"box\"; there are torus"));
}

TEST_F(SequencerTest, ANameIsFreeAgainWithinTheTransactionThatRemovesIt) {
  const auto first = accept(edit(add("a")));
  const auto second = accept(edit(remove("a"), add("a", box(0.2))));
  EXPECT_THAT(second->commit.removed, ElementsAre(first->commit.put[0].id));
  EXPECT_EQ(second->commit.put[0].name, "a");
}

TEST_F(SequencerTest, NeverGivesAnIdTwice) {
  std::vector<ObjectId> ids;
  for (int i = 0; i < 20; ++i) {
    ids.push_back(accept(edit(add("a")))->commit.put[0].id);
    accept(edit(remove("a")));
    accept(edit(add("b"), remove("b")));
  }
  for (std::size_t i = 1; i < ids.size(); ++i) EXPECT_GT(ids[i], ids[i - 1]);
}

TEST_F(SequencerTest, HoldsAsManyObjectsAsTheServoAndNoMore) {
  Transaction full;
  for (std::size_t i = 0; i < kMaxServoObjects; ++i) full.operations.push_back(add(numbered("o", i)));
  accept(full);
  EXPECT_EQ(reject(edit(add("more"))).field, "operations[0].add");
  accept(edit(remove("o7"), add("more")));
}

TEST_F(SequencerTest, AFailedPreconditionIsAConflictThatShowsTheObject) {
  const auto added = accept(edit(add("a"), add("b")));
  accept(edit(moveTo("a", {1, 0, 0})));
  Transaction stale = edit(moveTo("a", {2, 0, 0}));
  stale.preconditions.push_back({named("b"), 1, {}});
  stale.preconditions.push_back({named("a"), added->commit.revision, {}});
  const auto conflict = std::get<EditConflict>(submit(stale));
  ASSERT_THAT(conflict.current, SizeIs(1));
  EXPECT_EQ(*conflict.current[0], *version().find("a"));
  EXPECT_THAT(conflict.reason, HasSubstr("stands at revision 2, expected was 1"));
  EXPECT_EQ(version().revision(), 2U);

  stale.preconditions.back() = {named("a"), 2, version().find("b")->hash()};
  EXPECT_TRUE(std::holds_alternative<EditConflict>(submit(stale)));
  stale.preconditions.back() = {named("gone"), 2, {}};
  EXPECT_THAT(std::get<EditConflict>(submit(stale)).current, SizeIs(0));
  stale.preconditions.back() = {named("a"), 2, version().find("a")->hash()};
  accept(stale);
}

TEST_F(SequencerTest, AResentEditIsAnsweredAgainAndNotAppliedAgain) {
  const auto first = std::get<Accepted>(sequencer.submit(kAlice, 1, edit(add("a"))));
  std::get<Accepted>(sequencer.submit(kBob, 1, edit(add("b"))));
  const auto again = std::get<Accepted>(sequencer.submit(kAlice, 1, edit(add("a"))));
  EXPECT_EQ(again->commit.revision, first->commit.revision);
  EXPECT_EQ(again->commit.root, first->commit.root);
  EXPECT_EQ(again->commit.put, first->commit.put);
  EXPECT_EQ(again->reports, first->reports);
  EXPECT_EQ(version().revision(), 2U);
}

TEST_F(SequencerTest, AResentEditIsRecognisedAfterTheHistoryHasForgottenIt) {
  const auto first = std::get<Accepted>(sequencer.submit(kBob, 1, edit(add("a"))));
  for (std::size_t i = 0; i < kRememberedEdits + 1; ++i) accept(edit(moveTo("a", {1e-3 * double(i), 0, 0})));
  EXPECT_EQ(sequencer.history()->edits.size(), kRememberedEdits);
  const auto again = std::get<Accepted>(sequencer.submit(kBob, 1, edit(add("a"))));
  EXPECT_EQ(again->commit.revision, first->commit.revision);
  EXPECT_EQ(again->commit.root, first->commit.root);
}

TEST_F(SequencerTest, ARejectionIsNotRemembered) {
  EXPECT_TRUE(std::holds_alternative<Error>(sequencer.submit(kBob, 1, edit(moveTo("a", {})))));
  accept(edit(add("a")));
  EXPECT_TRUE(std::holds_alternative<Accepted>(sequencer.submit(kBob, 1, edit(moveTo("a", {})))));
}

TEST_F(SequencerTest, AnEditIsNotAppliedAfterALaterOneOfItsSession) {
  const auto refusedBefore = [this](std::uint64_t number, const Transaction& transaction) {
    return std::get<Error>(sequencer.submit(kBob, number, transaction)).field == "client_seq";
  };
  EXPECT_TRUE(std::holds_alternative<Error>(sequencer.submit(kBob, 1, edit(moveTo("a", {1, 0, 0})))));
  const auto outcomes = sequencer.submit(std::vector<Submission>{
      {kBob, 2, edit(moveTo("a", {2, 0, 0}))}, {kBob, 3, edit(add("a"))}, {kBob, 2, edit(moveTo("a", {2, 0, 0}))}});
  EXPECT_EQ(std::get<Error>(outcomes[2]).field, "client_seq") << "passed over within the batch";
  EXPECT_TRUE(refusedBefore(1, edit(moveTo("a", {1, 0, 0}))));
  EXPECT_TRUE(std::holds_alternative<Accepted>(sequencer.submit(kAlice, 1, edit(moveTo("a", {3, 0, 0})))));
  EXPECT_EQ(version().revision(), 2U);

  Transaction stale = edit(moveTo("a", {1, 0, 0}));
  stale.preconditions.push_back({named("a"), 7, {}});
  EXPECT_TRUE(std::holds_alternative<EditConflict>(sequencer.submit(kBob, 1, stale))) << "a conflict stays one";
}

TEST_F(SequencerTest, RefusesNumbersThatItCannotKnowToBeNew) {
  EXPECT_EQ(std::get<Error>(sequencer.submit(kBob, 0, edit(add("a")))).field, "client_seq");
  for (std::uint64_t i = 1; i <= EditDeduplicator::kResultsPerSession + 1; ++i) {
    std::get<Accepted>(sequencer.submit(kBob, i, edit(add(numbered("n", i)))));
  }
  EXPECT_EQ(std::get<Error>(sequencer.submit(kBob, 1, edit(add("again")))).field, "client_seq");
  EXPECT_EQ(version().find("again"), nullptr);
}

TEST_F(SequencerTest, ResumesOnlyFromStatesThatItHasBeenIn) {
  const ContentHash empty = version().root();
  accept(edit(add("a")));
  const ContentHash one = version().root();
  accept(edit(add("b")));
  const SceneHistory& history = *sequencer.history();
  EXPECT_TRUE(history.canResumeFrom(kEpoch, 0, empty));
  EXPECT_TRUE(history.canResumeFrom(kEpoch, 1, one));
  EXPECT_TRUE(history.canResumeFrom(kEpoch, 2, version().root()));
  EXPECT_FALSE(history.canResumeFrom(kEpoch + 1, 1, one));
  EXPECT_FALSE(history.canResumeFrom(kEpoch, 1, empty));
  EXPECT_FALSE(history.canResumeFrom(kEpoch, 2, one));
  EXPECT_FALSE(history.canResumeFrom(kEpoch, 3, one));
  for (std::size_t i = 0; i < kRememberedEdits; ++i) accept(edit(moveTo("a", {1e-3 * double(i), 0, 0})));
  EXPECT_FALSE(sequencer.history()->canResumeFrom(kEpoch, 1, one));
}

TEST_F(SequencerTest, HoldsTheMeshesOfItsVersionAndLetsOthersGo) {
  accept(edit(add("a", box(0.1)), add("b", box(0.2)), add("c", box(0.1))));
  EXPECT_EQ(resolver.store().size(), 2U);
  const ObjectId b = version().find("b")->id;
  EXPECT_EQ(sequencer.assetsOf(b).mesh->name.hash, version().find("b")->mesh);
  accept(edit(RemeshObject{named("b"), box(0.3)}));
  EXPECT_EQ(sequencer.assetsOf(b).mesh->name.hash, hashOf(makeBox(Vec3(0.3), 1).value()));
  EXPECT_EQ(resolver.store().size(), 2U);
  accept(edit(remove("b")));
  EXPECT_EQ(resolver.store().size(), 1U);
}

TEST_F(SequencerTest, TheSameSubmissionsGiveTheSameHistory) {
  BoxResolver otherResolver;
  Sequencer other(kEpoch, otherResolver);
  std::mt19937 random(7);
  for (std::uint64_t i = 0; i < 300; ++i) {
    Transaction t;
    for (auto n = random() % 4; n > 0; --n) {
      const std::string name = numbered("o", random() % 6);
      switch (random() % 4) {
        case 0:
          t.operations.push_back(add(name, box(0.1 + 0.1 * double(random() % 3))));
          break;
        case 1:
          t.operations.push_back(remove(name));
          break;
        case 2:
          t.operations.push_back(moveTo(name, {double(random() % 10), 0, 0}));
          break;
        default:
          t.operations.emplace_back(RemeshObject{named(name), box(0.5)});
      }
    }
    const std::uint64_t number = 1 + i / 2 + random() % 2;  // some again, some behind the next
    const auto mine = sequencer.submit(kAlice, number, t);
    const auto its = other.submit(kAlice, number, t);
    ASSERT_EQ(mine.index(), its.index());
    ASSERT_EQ(version().root(), other.history()->version.root());
  }
  EXPECT_GT(version().revision(), 20U);
}

TEST(Sequencer, ShowsVersionsThatWereMadeElsewhereAsEditsWhereTheyFollow) {
  BoxResolver resolver;
  Sequencer made(1, resolver), shown(2, resolver);
  made.submit(kAlice, 1, edit(add("a"), add("b")));
  shown.show(made.history()->version, {});
  const std::uint64_t epoch = shown.history()->epoch;
  EXPECT_EQ(epoch, 2U);
  made.submit(kAlice, 2, edit(moveTo("a", {1, 0, 0}), remove("b")));
  shown.show(made.history()->version, {});
  shown.show(made.history()->version, {});  // nothing new
  EXPECT_EQ(shown.history()->epoch, epoch);
  EXPECT_EQ(shown.history()->version.root(), made.history()->version.root());
  const auto edit2 = shown.history()->find(2);
  ASSERT_TRUE(edit2);
  EXPECT_EQ(edit2->commit.put.size(), 1U);
  EXPECT_EQ(edit2->commit.removed, std::vector<ObjectId>{2});
  EXPECT_EQ(edit2->commit.root, made.history()->version.root());

  made.submit(kAlice, 3, edit(moveTo("a", {2, 0, 0})));
  made.submit(kAlice, 4, edit(moveTo("a", {3, 0, 0})));
  shown.show(made.history()->version, {});
  EXPECT_EQ(shown.history()->epoch, epoch);
  EXPECT_EQ(shown.history()->version.root(), made.history()->version.root());
  const auto passed = shown.history()->find(3), edit4 = shown.history()->find(4);
  ASSERT_TRUE(passed && edit4) << "who watches goes through each revision";
  EXPECT_TRUE(passed->commit.put.empty());
  EXPECT_EQ(passed->commit.root, edit4->commit.prevRoot);
  EXPECT_EQ(edit4->commit.root, made.history()->version.root());

  Sequencer other(3, resolver);
  other.submit(kAlice, 1, edit(add("c")));
  shown.show(other.history()->version, {});
  EXPECT_NE(shown.history()->epoch, epoch) << "no edit leads there";
  EXPECT_EQ(shown.history()->version.root(), other.history()->version.root());
  for (std::uint64_t i = 2; i < 2000; ++i) other.submit(kAlice, i, edit(moveTo("c", {1e-3 * double(i), 0, 0})));
  shown.show(other.history()->version, {});
  EXPECT_EQ(shown.history()->version.root(), other.history()->version.root()) << "more than are remembered";
  EXPECT_FALSE(shown.history()->find(2));
}

TEST_F(SequencerTest, RefusesWorkWithItsPriceBeforeAnythingIsMade) {
  accept(edit(add("a")));
  const auto refusal = [&](const Transaction& transaction) {
    resolver.resolved = 0;
    const EditOutcome outcome = submit(transaction);
    const auto* error = std::get_if<Error>(&outcome);
    return error != nullptr ? error->text() : std::string();
  };
  Transaction many;
  for (int i = 0; i < 1000; ++i)
    many.operations.push_back(RemeshObject{named("a"), {SphereSource{0.03 + 1e-6 * i, 64}}});
  EXPECT_THAT(refusal(many), HasSubstr("operations: take up to 138 s of a processor and 7.38 GB together"));
  EXPECT_EQ(resolver.resolved, 0);
  many.operations.resize(250);
  EXPECT_THAT(refusal(many), Not(HasSubstr("take up to"))) << "but a sphere is no box";
  EXPECT_EQ(resolver.resolved, 1);
  MeshSource simplified{SphereSource{0.05, 400}};
  simplified.simplifyError = 1;
  EXPECT_THAT(refusal(edit(add("b", simplified))), HasSubstr("take up to"));
  const Lattice lattice{Vec3(-1), Vec3(2), {2, 2, 2}, std::vector<Vec3f>(8)};
  AddObject bent{"b", {SphereSource{0.05, 1024}}, {}, {}};
  bent.deformation.lattice = lattice;
  EXPECT_THAT(refusal(edit(Operation(bent))), HasSubstr("take up to"));
  EXPECT_EQ(resolver.resolved, 0);
}

TEST(EditPrice, TakesTheLargestMeshWithAMass) {
  MotionProperties motion;
  motion.mass_kg = 1;
  const MeshNumbers largest = numbersOf(MeshRecipe(SphereSource{0.05, 1024}));
  Price price = priceOfDeciding(1, 1);
  price += priceOfMesh(largest);
  price += priceOfLooking(largest);
  price += priceOfBody(largest, motion);
  EXPECT_TRUE(checkPrice(price)) << price.time_s << " s, " << price.memory_bytes() << " bytes";
  const Lattice lattice{Vec3(-1), Vec3(2), {2, 2, 2}, std::vector<Vec3f>(8)};
  price += priceOfShape(largest, {.softness = {}, .lattice = lattice});
  EXPECT_FALSE(checkPrice(price));
}

TEST(EditPrice, TellsALatticeThatMayFoldFromOneThatBends) {
  const MeshNumbers mesh{.triangles = 6000, .vertices = 3000};
  const Vec3 low(-0.1), size(0.2);
  const std::array points{3U, 2U, 4U};
  const auto timeOf_s = [&](Vec3f times, Vec3f turn) {
    Lattice lattice{low, size, points, FreeForm::atRest(low, size, points)};
    for (Vec3f& control : lattice.control_m) control = times * control + turn * control.z;
    return priceOfShape(mesh, {.softness = {}, .lattice = std::move(lattice)}).time_s;
  };
  const double bent_s = timeOf_s({1, 1, 1}, {0, 0, 0});
  EXPECT_EQ(timeOf_s({1.5F, 1, 0.5F}, {0.5F, 0, 0}), bent_s);
  EXPECT_GT(timeOf_s({-1, 1, 1}, {0, 0, 0}), 50 * bent_s) << "inside out";
  EXPECT_GT(timeOf_s({1, 1, 0}, {0, 0, 0}), 50 * bent_s) << "flat";
}

TEST(EditPrice, CountsLongTrianglesWhereALatticeMayMakeThem) {
  const Vec3 low(-0.1), size(0.2);
  const std::array points{3U, 3U, 3U};
  MeshNumbers mesh{.triangles = 6000, .vertices = 3000, .longest_m = 0.1};
  const auto time_s = [&](Vec3f times, float torn) {
    Lattice lattice{low, size, points, FreeForm::atRest(low, size, points)};
    for (Vec3f& control : lattice.control_m) control *= times;
    lattice.control_m.back() += Vec3f(torn);
    return priceOfShape(mesh, {.softness = {}, .lattice = std::move(lattice)}).time_s;
  };
  const double torn_s = time_s({-1e-3F, 1e-3F, 1e-3F}, 1);
  EXPECT_LT(3 * time_s({-1, 1, 1}, 0), torn_s) << "turned over, and no triangle is longer beside the whole";
  mesh.closed = mesh.closedAndPlain = false;
  EXPECT_LT(3 * time_s({-1e-3F, 1e-3F, 1e-3F}, 1), torn_s) << "what is open has no inside that could be outside";
}

TEST(EditDeduplicator, ForgetsTheSessionThatEditedLongestAgo) {
  EditDeduplicator memory;
  for (SessionId s = 1; s <= EditDeduplicator::kSessions; ++s) memory.remember(s, {1, s, {}});
  memory.remember(1, {2, 9000, {}});
  memory.remember(9999, {1, 9001, {}});
  EXPECT_EQ(memory.find(1, 1).answer, EditDeduplicator::Answer::kApplied);
  EXPECT_EQ(memory.find(2, 1).answer, EditDeduplicator::Answer::kNew);
  EXPECT_EQ(memory.find(3, 1).answer, EditDeduplicator::Answer::kApplied);
  EXPECT_EQ(memory.find(9999, 1).result.revision, 9001U);
}

TEST_F(SequencerTest, RefusesAnEditWhoseAnswerFitsNoFrame) {
  Transaction start;
  Transaction all;
  for (std::uint64_t i = 0; i < 20; ++i) {
    start.operations.push_back(add(numbered("o", i)));
    all.operations.push_back(moveTo(numbered("o", i), {1, 0, 0}));
  }
  Sequencer small(kEpoch, resolver, {.answer_bytes = 2000});
  ASSERT_TRUE(std::holds_alternative<Accepted>(small.submit(kServerSession, 1, start))) << "nobody is sent its commit";

  const EditOutcome refused = small.submit(kAlice, 1, all);
  ASSERT_TRUE(std::holds_alternative<Error>(refused));
  EXPECT_EQ(std::get<Error>(refused).field, "operations");
  EXPECT_THAT(std::get<Error>(refused).reason, HasSubstr("change fewer"));
  all.operations.resize(5);
  EXPECT_TRUE(std::holds_alternative<Accepted>(small.submit(kAlice, 2, all)));
}

TEST_F(SequencerTest, RefusesAnObjectThatFitsNoFrameWhoeverMakesIt) {
  Lattice lattice{.low_m = Vec3(-1), .size_m = Vec3(2), .points = {8, 8, 8}, .control_m = {}};
  lattice.control_m.resize(512, Vec3f(0.5F));
  DeformationEdit deformation;
  deformation.lattice = lattice;
  Sequencer small(kEpoch, resolver, {.answer_bytes = 5000});
  const Transaction transaction{{}, {add("a"), SetDeformation{named("a"), deformation}}};
  for (const SessionId session : {kServerSession, kAlice}) {
    const EditOutcome refused = small.submit(session, 1, transaction);
    ASSERT_TRUE(std::holds_alternative<Error>(refused));
    EXPECT_EQ(std::get<Error>(refused).field, "operations");
    EXPECT_THAT(std::get<Error>(refused).reason, HasSubstr("object \"a\""));
  }
}

}  // namespace
}  // namespace haptics::sequencer_test
