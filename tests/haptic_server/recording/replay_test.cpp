#include "haptic_server/recording/replay.h"

#include <gtest/gtest.h>

#include <functional>
#include <future>
#include <limits>

#include "haptic_server/recording/recording_reader.h"
#include "haptic_server/recording/recording_writer.h"
#include "haptic_server/recording/state_image.h"
#include "recorded_servo.h"

namespace haptics::replay_test {
namespace {

using namespace test;

/// The parts of a recording, changed: a function that returns false leaves the part out.
std::string changed(const std::string& recording, const std::function<bool(v1::RecordingPart&)>& change) {
  auto reader = RecordingReader::open(recording).value();
  v1::RecordingPart head;
  *head.mutable_head() = toMessage(reader.facts());
  head.mutable_head()->set_state_layout(stateLayout());
  std::string parts(kRecordingHead);
  RecordWriter chain(kRecordingHead);
  chain.append(parts, head.SerializeAsString());
  for (auto next = reader.next(); *next != nullptr; next = reader.next()) {
    v1::RecordingPart part = **next;
    if (change(part)) chain.append(parts, part.SerializeAsString());
  }
  return parts;
}

/// What a replay gives of each tick, as bytes.
std::string outputOf(const std::string& recording, ReplayOutcome& outcome) {
  std::string bytes;
  const auto put = [&bytes](const auto& value) { bytes.append(reinterpret_cast<const char*>(&value), sizeof value); };
  MotionState motion;
  outcome = replay(recording, [&](const ReplayedTick& tick) {
              put(tick.sample.tick);
              for (const Vec3 v : {tick.sample.hip, tick.sample.ihip, tick.sample.stickingPoint,
                                   tick.sample.force.written, tick.sample.force.friction, tick.sample.force.texture})
                put(v);
              put(tick.sample.energyGiven_J);
              put(tick.sample.frictionState);
              if (tick.motion != nullptr) motion = *tick.motion;
              for (const BodyState& body : motion.bodies()) put(body.pose);
              for (const ObjectDent& dent : motion.dents()) put(dent.dent);
              put(motion.tool.torque_Nm);
              put(tick.scene == nullptr ? 0 : tick.scene->scene->number);
              return true;
            }).value();
  return bytes;
}

constexpr int kWhile = 2000;  // ticks: the hand comes round everything

/// Edits of each kind, under the stylus and beside it.
void runWithEdits(RecordedServo& servo) {
  servo.run(kWhile);
  servo.apply(R"(operations { set_material { object { name: "slab" } material { stiffness_N_per_m: 1500 } } })");
  servo.run(kWhile);
  servo.apply(R"(operations { set_pose { object { name: "ball" } pose { position { x: 0.025 z: 0.006 } } } })");
  servo.run(300);
  servo.apply(
      R"(operations { remesh { object { name: "slab" } mesh { box { size_m { x: 0.2 y: 0.2 z: 0.021 } segments: 4 } } } })");
  servo.apply(
      R"(operations { set_material { object { name: "ball" } material { shading {} friction { mu_static: 1 mu_dynamic: 0.5 } } } })");
  servo.run(kWhile);
  servo.skip(7);
  servo.apply(R"(operations { remove { object { name: "ball" } } })");
  servo.run(kWhile);
  servo.apply(R"(operations { add { name: "late" mesh { torus { major_radius_m: 0.03 minor_radius_m: 0.01 } } } })");
  servo.run(kWhile);
}

TEST(Replay, MakesEveryForceAgainBitForBitAcrossEditsTexturesFrictionAndShading) {
  RecordedServo servo;
  runWithEdits(servo);
  const auto outcome = replay(servo.recording());
  ASSERT_TRUE(outcome) << outcome.error().text();
  EXPECT_FALSE(outcome->refusal) << outcome->refusal->text();
  EXPECT_EQ(outcome->ticks, 10'300U);
  EXPECT_EQ(outcome->missed, 7U);
  EXPECT_EQ(outcome->differing, 0U);
  EXPECT_FALSE(outcome->cutOff);
  EXPECT_TRUE(outcome->sameStep);
  EXPECT_EQ(outcome->ticksAhead, 5'300U) << "from the states at ticks 5,000 and 10,000";
  EXPECT_EQ(outcome->contactTicks, servo.contactTicks());
  EXPECT_GT(outcome->contactTicks, 4000U) << "the hand must feel something";
}

TEST(Replay, MakesTheForcesOfBodiesThatMoveAgain) {
  RecordedServo servo(kScene + kBlock);
  runWithEdits(servo);
  const auto outcome = replay(servo.recording());
  ASSERT_TRUE(outcome) << outcome.error().text();
  EXPECT_FALSE(outcome->refusal) << outcome->refusal->text();
  EXPECT_EQ(outcome->differing, 0U);
  EXPECT_GT(servo.state().moving.count, 0U);
  EXPECT_NE(servo.state().bodies[servo.state().moving[0].body].current,
            servo.scene().objects[servo.state().moving[0].body].pose)
      << "the block must have been pushed";
}

TEST(Replay, MakesTheForcesOfBodiesThatMeetAgain) {
  RecordedServo servo(kScene + kBricks);
  runWithEdits(servo);
  const auto outcome = replay(servo.recording());
  ASSERT_TRUE(outcome) << outcome.error().text();
  EXPECT_EQ(outcome->differing, 0U);
  EXPECT_GT(servo.state().pairs.places.count, 0U);
  EXPECT_GT(outcome->contactTicks, 1000U);
}

/// The slab swells and sinks by lattices; the stream pauses, ends by an edit, and begins anew.
void runWithShapes(RecordedServo& servo, const std::function<void(int)>& run) {
  const auto sample = [](double top_m) {
    std::string text =
        "operations { set_deformation { object { name: \"slab\" } kinematic: true deformation { lattice { "
        "points_x: 2 points_y: 2 points_z: 2";
    for (int i = 0; i < 8; ++i) {
      for (const double x : {i % 2 == 0 ? -0.1 : 0.1, i / 2 % 2 == 0 ? -0.1 : 0.1, i / 4 == 0 ? -0.01 : 0.01 + top_m})
        text += " control_m: " + std::to_string(x);
    }
    return text + " } } } }";
  };
  run(700);
  for (int i = 0; i < 500; ++i) {
    if (i % 100 < 80) servo.submit(sample(0.004 * std::sin(0.1 * i)));
    if (i % 7 == 0) servo.submit(sample(0.004 * std::sin(0.1 * i + 0.05)));  // of two at once one is adopted
    run(i % 3 == 0 ? 1 : 16);
    if (i == 250)
      servo.submit("operations { set_deformation { object { name: \"slab\" } deformation { lattice {} } } }");
    if (i == 350)
      servo.submit("operations { set_material { object { name: \"slab\" } material { damping_Ns_per_m: 1 } } }");
  }
}

TEST(Replay, MakesTheForcesOfShapesThatAreDrivenAgain) {
  RecordedServo servo;
  runWithShapes(servo, [&](int ticks) { servo.run(ticks); });
  EXPECT_GT(servo.state().reshaped.count, 0U);
  const std::string recording = servo.recording();
  const auto outcome = replay(recording);
  ASSERT_TRUE(outcome) << outcome.error().text();
  EXPECT_FALSE(outcome->refusal) << outcome->refusal->text();
  EXPECT_EQ(outcome->differing, 0U);
  EXPECT_EQ(outcome->differingStates, 0U) << outcome->differingField;
  EXPECT_GT(outcome->ticksAhead, 0U) << "from the state in the middle of the stream";
  EXPECT_GT(outcome->contactTicks, 1000U);
  ReplayOutcome all, without;
  EXPECT_TRUE(outputOf(recording, all) ==
              outputOf(changed(recording, [](const auto& part) { return !part.has_state(); }), without));
}

TEST(Replay, MakesTheForcesOfTwoHandsOnAShapeThatIsDrivenAgain) {
  RecordedServo servo(kScene, 2);
  runWithShapes(servo, [&](int ticks) { servo.runBoth(ticks); });
  const auto outcome = replay(servo.recording());
  ASSERT_TRUE(outcome) << outcome.error().text();
  EXPECT_FALSE(outcome->refusal) << outcome->refusal->text();
  EXPECT_EQ(outcome->differing, 0U);
  EXPECT_EQ(outcome->differingStates, 0U) << outcome->differingField;
  EXPECT_GT(outcome->contactTicks, 500U);
}

TEST(Replay, MakesForcesAndTorquesOfAToolThatTheDeviceTurnsAgain) {
  RecordedServo servo(kScene + kBlock + kTool);
  servo.run(kWhile);
  double largest_Nm = 0;
  for (int i = 0; i < 2 * kWhile; ++i) {
    servo.runTurning(1);
    largest_Nm = std::max(largest_Nm, glm::length(writtenTorque_Nm(servo.state())));
  }
  EXPECT_GT(largest_Nm, 0.01) << "something must turn the hand";
  servo.apply(
      R"(operations { set_motion { object { name: "bar" } motion { tool { spacing_m: 0.003 torsion_Nm_per_rad: 1 } } } })");
  servo.runTurning(kWhile);
  servo.apply(R"(operations { remove { object { name: "bar" } } })");
  servo.runTurning(kWhile);
  const auto outcome = replay(servo.recording());
  ASSERT_TRUE(outcome) << outcome.error().text();
  EXPECT_FALSE(outcome->refusal) << outcome->refusal->text();
  EXPECT_EQ(outcome->ticks, 5U * kWhile);
  EXPECT_EQ(outcome->differing, 0U);
  EXPECT_EQ(outcome->largestDifference_Nm, 0);
}

TEST(Replay, MakesTheMomentOfJawsOnTheGripperAgain) {
  RecordedServo servo(kForceps);
  double largest_Nm = 0;
  for (int i = 0; i < 2 * kWhile; ++i) {
    servo.runGripping(1);
    largest_Nm = std::max(largest_Nm, writtenGrip_Nm(servo.state()));
  }
  EXPECT_GT(largest_Nm, 0.01) << "something must open the gripper";
  double replayed_Nm = 0;
  const auto outcome = replay(servo.recording(), [&](const ReplayedTick& replayed) {
    if (replayed.motion != nullptr && replayed.motion->tool.grip)
      replayed_Nm = std::max(replayed_Nm, replayed.motion->tool.grip->written_Nm);
    return true;
  });
  ASSERT_TRUE(outcome) << outcome.error().text();
  EXPECT_FALSE(outcome->refusal) << outcome->refusal->text();
  EXPECT_EQ(outcome->ticks, 2U * kWhile);
  EXPECT_EQ(outcome->differing, 0U);
  EXPECT_EQ(outcome->differingStates, 0U) << outcome->differingField;
  EXPECT_EQ(replayed_Nm, largest_Nm);
}

TEST(Replay, GivesWhatAClientAddedAgain) {
  RecordedServo servo;
  servo.run(100);
  servo.runAdding(kWhile);
  servo.run(100);
  int added = 0;
  const auto outcome = replay(servo.recording(), [&](const ReplayedTick& replayed) {
    added += replayed.sample.added_N != Vec3(0);
    return true;
  });
  ASSERT_TRUE(outcome) << outcome.error().text();
  EXPECT_FALSE(outcome->refusal) << outcome->refusal->text();
  EXPECT_EQ(outcome->ticks, 200U + kWhile);
  EXPECT_EQ(outcome->differing, 0U);
  EXPECT_NEAR(added, 2 * kWhile / 3, 100);
}

/// States between ticks let parts of a recording be computed at the same time: nothing else may come of them.
TEST(Replay, GivesWhatTheHandleMeasuredAndTheForcesThatAClutchTookAwayAgain) {
  RecordedServo servo;
  servo.run(100);
  servo.runClutching(kWhile);
  servo.run(100);
  std::uint64_t tick = 0, clutched = 0, marked = 0;
  const auto outcome = replay(servo.recording(), [&](const ReplayedTick& replayed) {
    const TelemetrySample& sample = replayed.sample;
    const bool measures = tick >= 100 && tick < 100U + kWhile;
    EXPECT_EQ(sample.device.buttons, measures ? 1U << (tick % 32) : 0U) << tick;
    const auto number = static_cast<double>(tick);
    const HandleReading handle{{number, 1, 2}, {3, -number, 4}, 0.1 * number, tick % 8};
    EXPECT_EQ(sample.handle, measures ? handle : HandleReading{}) << tick;
    clutched += sample.device.does(HandAction::kClutch);
    marked += sample.device.does(HandAction::kMark);
    ++tick;
    return true;
  });
  ASSERT_TRUE(outcome) << outcome.error().text();
  EXPECT_FALSE(outcome->refusal) << outcome->refusal->text();
  EXPECT_EQ(outcome->ticks, 200U + kWhile);
  EXPECT_EQ(outcome->differing, 0U);
  EXPECT_EQ(clutched, kWhile / 2U);
  EXPECT_EQ(marked, kWhile / 4U);
}

TEST(Replay, GivesTheSameOfEveryTickWithAndWithoutTheStatesInARecording) {
  RecordedServo pushed(kScene + kBricks), yielding(kScene + kCushion), held(kScene + kBlock + kTool),
      grasping(kScene + kBricks);
  runWithEdits(pushed);
  runWithEdits(yielding);
  held.runTurning(10'300);
  grasping.runGrasping(10'300);
  int grasped = 0;
  (void)replay(grasping.recording(), [&](const ReplayedTick& tick) {
    grasped += tick.sample.grasped != 0;
    return true;
  });
  EXPECT_GT(grasped, 300);
  for (RecordedServo* servo : {&pushed, &yielding, &held, &grasping}) {
    const std::string recording = servo->recording();
    const std::string without = changed(recording, [](const auto& part) { return !part.has_state(); });
    ReplayOutcome outcome, outcomeWithout;
    EXPECT_TRUE(outputOf(recording, outcome) == outputOf(without, outcomeWithout));
    EXPECT_EQ(outcome.ticksAhead, 5'300U);
    EXPECT_EQ(outcomeWithout.ticksAhead, 0U);
    EXPECT_EQ(outcome.ticks, outcomeWithout.ticks);
    EXPECT_EQ(outcome.missed, outcomeWithout.missed);
    EXPECT_EQ(outcome.contactTicks, outcomeWithout.contactTicks);
    EXPECT_EQ(outcome.differing + outcomeWithout.differing, 0U);
  }
}

TEST(Replay, DoesNotGoByAStateThatTheTicksBeforeItDoNotComeTo) {
  RecordedServo servo(kScene + kBricks);
  runWithEdits(servo);
  const std::string recording = servo.recording();
  std::vector<v1::RecordedState> states;
  static_cast<void>(changed(recording, [&](const auto& part) {
    if (part.has_state()) states.push_back(part.state());
    return true;
  }));
  ASSERT_EQ(states.size(), 2U);
  const std::string images[] = {stateImage(HapticState(servo.config())), states[0].image(), "no image"};
  for (const std::string& image : images) {
    const bool isEmpty = image == images[0];
    const auto outcome = replay(changed(recording, [&](v1::RecordingPart& part) {
      if (!part.has_state() || part.state().scene() == states[0].scene()) return true;
      part.mutable_state()->set_image(image);
      if (isEmpty) part.mutable_state()->set_scene(0);
      return true;
    }));
    ASSERT_TRUE(outcome) << outcome.error().text();
    EXPECT_EQ(outcome->differing, 0U);
    EXPECT_EQ(outcome->ticks, 10'300U);
    EXPECT_EQ(outcome->ticksAhead, 5'000U) << "from the first state, not from the second";
    EXPECT_EQ(outcome->differingStates, 1U) << differenceIn(*outcome);
  }
}

TEST(Replay, GoesOnFromTheStateInARecordingOfTheLastSeconds) {
  RecordedServo servo(kScene + kBricks);
  servo.run(9000);
  runWithEdits(servo);
  std::promise<std::filesystem::path> written;
  servo.recorder().start();
  servo.recorder().request("a test", [&](const auto& file) { written.set_value(file.value()); });
  const auto outcome = replay(bytesOf(written.get_future().get()));
  ASSERT_TRUE(outcome) << outcome.error().text();
  EXPECT_FALSE(outcome->refusal) << outcome->refusal->text();
  EXPECT_GE(outcome->ticks, 10'000U);
  EXPECT_LT(outcome->ticks, 12'000U);
  EXPECT_EQ(outcome->differing, 0U);
  EXPECT_GT(outcome->contactTicks, 4000U);
  EXPECT_EQ(outcome->facts.why, "a test");
}

TEST(Replay, ARecordingThatCannotBeWrittenLeavesNoFile) {
  RecordedServo servo;  // has no tick yet
  std::promise<bool> written;
  servo.recorder().start();
  servo.recorder().request("a test", [&](const auto& file) { written.set_value(file.has_value()); });
  EXPECT_FALSE(written.get_future().get());
  EXPECT_TRUE(std::filesystem::is_empty(servo.folder() / "last"));
}

/// As no servo had it: where the one that it holds on to had been let go, it would be a scene that is no more.
TEST(Replay, RefusesASceneThatIsOlderThanThatOfTheStateBefore) {
  RecordedServo servo;
  servo.run(2000);
  servo.apply(R"(operations { set_material { object { name: "slab" } material { stiffness_N_per_m: 1500 } } })");
  servo.run(4000);
  servo.apply(R"(operations { remove { object { name: "ball" } } })");
  servo.run(100);
  bool isAfter = false;
  const auto outcome = replay(changed(servo.recording(), [&](v1::RecordingPart& part) {
    isAfter = isAfter || part.has_state();
    if (!part.has_ticks()) return true;
    std::string ticks = part.ticks().ticks();
    for (std::size_t at = 2 * sizeof(std::uint64_t); at < ticks.size(); at += kTickBytes)
      ticks[at] = ticks[at] == 3 ? 1 : ticks[at];
    part.mutable_ticks()->set_ticks(ticks);
    return isAfter;
  }));
  ASSERT_TRUE(outcome) << outcome.error().text();
  ASSERT_TRUE(outcome->refusal);
  EXPECT_EQ(outcome->refusal->text(), "ticks.scene: 1 comes after 2");
}

TEST(Recording, OneThatIsBegunInItsPlaceIsNotWhatItsReadersRead) {
  RecordedServo servo;
  servo.run(100);
  const std::string good = servo.recording();
  const auto file = servo.folder() / "read";
  std::ofstream(file, std::ios::binary) << good;
  auto reader = RecordingReader::open(RecordingBytes::open(file).value()).value();
  const auto facts = RecordingReader::open(good).value().facts();
  ASSERT_TRUE(RecordingWriter::create(file, facts));
  EXPECT_LT(bytesOf(file).size(), good.size());
  while (reader.next().value() != nullptr) {
  }
  EXPECT_FALSE(reader.cutOff());
  EXPECT_EQ(reader.share(), 1);
}

TEST(Recording, OneThatIsCutShortWhileItIsReadEndsThere) {
  RecordedServo servo;
  servo.run(10'000);
  const std::string good = servo.recording();
  const auto file = servo.folder() / "read";
  std::ofstream(file, std::ios::binary) << good;
  const auto bytes = RecordingBytes::open(file).value();
  std::filesystem::resize_file(file, good.size() / 2);
  const auto outcome = replay(bytes);
  ASSERT_TRUE(outcome) << outcome.error().text();
  EXPECT_TRUE(outcome->cutOff);
  EXPECT_LT(outcome->ticks, 10'000U);
}

TEST(Replay, SaysWhichForceDiffersFirstAndByHowMuch) {
  RecordedServo servo;
  servo.run(500);
  servo.tick({Vec3(0, 0, -0.001), DeviceState::kReady, {}});
  const Vec3 felt = servo.last().force.written;
  servo.run(500);
  const std::string good = servo.recording();
  RecordingFacts facts;
  {
    const auto reader = RecordingReader::open(good);
    facts = reader->facts();
  }
  // The same recording with another limit: whatever was limited differs.
  ASSERT_GT(glm::length(felt), 0.2);
  facts.config.maxForce_N = 0.1;
  auto writer = RecordingWriter::create(servo.folder() / "other", facts);
  std::string parts(kRecordingHead);
  RecordWriter chain(kRecordingHead);
  v1::RecordingPart head;
  *head.mutable_head() = toMessage(facts);
  chain.append(parts, head.SerializeAsString());
  auto reader = RecordingReader::open(good);
  for (auto part = reader->next(); *part != nullptr; part = reader->next())
    chain.append(parts, (*part)->SerializeAsString());
  const auto outcome = replay(parts);
  ASSERT_TRUE(outcome);
  ASSERT_TRUE(outcome->first);
  EXPECT_GT(outcome->differing, 0U);
  EXPECT_LE(outcome->first->tick, 500U);
  EXPECT_NEAR(glm::length(outcome->first->now_N), 0.1, 1e-12);
  EXPECT_GT(glm::length(outcome->first->recorded_N), 0.1);
  EXPECT_GE(outcome->largestDifference_N, glm::length(felt) - 0.1 - 1e-12);
}

TEST(Replay, TakesARecordingThatWasCutOffAnywhereAsFarAsItIsWhole) {
  RecordedServo servo;
  servo.run(200);
  const std::string whole = servo.recording();
  std::uint64_t before = 0;
  for (std::size_t size = 0; size < whole.size(); size += 1 + size / 40) {
    const auto outcome = replay(whole.substr(0, size));
    if (!outcome) continue;  // not so much as its head
    EXPECT_FALSE(outcome->refusal) << outcome->refusal->text();
    EXPECT_EQ(outcome->differing, 0U);
    EXPECT_GE(outcome->ticks, before);
    before = outcome->ticks;
  }
}

TEST(Replay, NamesWhereARecordingIsDamaged) {
  RecordedServo servo;
  servo.run(200);
  const std::string whole = servo.recording();
  for (std::size_t at = 0; at < whole.size(); at += 1 + whole.size() / 60) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
    const auto outcome = replay(damaged);
    if (!outcome) {
      EXPECT_FALSE(outcome.error().reason.empty());
      continue;
    }
    ASSERT_TRUE(outcome->refusal || outcome->cutOff) << at;
    EXPECT_EQ(outcome->differing, 0U) << "what is replayed is what was written";
  }
}

TEST(Replay, RefusesWhatIsNoRecording) {
  EXPECT_NE(replay("").error().reason.find("haptics recording 1"), std::string::npos);
  EXPECT_NE(replay("haptics state 1\n").error().reason.find("no recording"), std::string::npos);
  EXPECT_NE(replay(kRecordingHead).error().reason.find("ends before"), std::string::npos);
}

TEST(Replay, RefusesAnObserverThatIsToCallWhatIsSoftHard) {
  RecordingFacts facts{.server = "s", .stepSources = "s", .device = "d", .rate_Hz = 1000, .why = "w", .config = {}};
  facts.config.period_s = 1e-3;
  facts.config.observer = ObserverSettings{.softUpTo_N_per_m = 900, .hardFrom_N_per_m = 2000};
  EXPECT_TRUE(factsFrom(toMessage(facts)));
  for (const double hardFrom : {900.0, 0.0, std::numeric_limits<double>::quiet_NaN()}) {
    facts.config.observer->hardFrom_N_per_m = hardFrom;
    EXPECT_EQ(factsFrom(toMessage(facts)).error().field, "head.lead.hard_from_N_per_m") << hardFrom;
  }
}

TEST(Replay, OfTwoHandsGivesEveryForceOfBothBitForBitFromItsStartAndFromAKeyframe) {
  RecordedServo servo(kScene + kBlock, 2);
  servo.runBoth(4'000);
  servo.apply(R"(operations { set_pose { object { name: "block" } pose { position { x: 0.031 z: 0.002 } } } })");
  servo.runBoth(4'000);
  ASSERT_GT(servo.contactTicks(), 100U) << "both touch";
  std::promise<std::filesystem::path> written;
  servo.recorder().request("now", [&](const Result<std::filesystem::path>& file) { written.set_value(*file); });
  const std::string whole = servo.recording();
  for (const std::string& recording : {whole, bytesOf(written.get_future().get())}) {
    std::uint64_t seconds = 0;
    const auto outcome = replay(recording, [&](const ReplayedTick& tick) {
      seconds += tick.secondSample != nullptr ? 1 : 0;
      return true;
    });
    ASSERT_TRUE(outcome) << outcome.error().text();
    EXPECT_FALSE(outcome->refusal) << outcome->refusal->text();
    EXPECT_GT(outcome->ticks, 7'000U);
    EXPECT_EQ(seconds, outcome->ticks);
    EXPECT_EQ(outcome->differing, 0U);
  }
}

/// A part that has the ticks of one hand alone does not go with a head of two.
TEST(Replay, OfTwoHandsRefusesPartsThatHaveOne) {
  RecordedServo two(kScene, 2), one;
  two.runBoth(50);
  one.run(50);
  const std::string recordings[] = {two.recording(), one.recording()};
  const auto refusalOf = [&](int head, int rest) {
    auto heads = RecordingReader::open(recordings[head]).value();
    v1::RecordingPart part;
    *part.mutable_head() = toMessage(heads.facts());
    RecordWriter chain(kRecordingHead);
    std::string mixed(kRecordingHead);
    chain.append(mixed, part.SerializeAsString());
    auto rests = RecordingReader::open(recordings[rest]).value();
    for (auto next = rests.next(); next && *next != nullptr; next = rests.next())
      chain.append(mixed, (*next)->SerializeAsString());
    const auto outcome = replay(mixed);
    return outcome && outcome->refusal ? outcome->refusal->text() : std::string();
  };
  EXPECT_NE(refusalOf(0, 1).find("second_hand"), std::string::npos) << refusalOf(0, 1);
  EXPECT_NE(refusalOf(1, 0).find("second_hand"), std::string::npos) << refusalOf(1, 0);
}

}  // namespace
}  // namespace haptics::replay_test
