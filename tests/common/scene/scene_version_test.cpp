#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <random>
#include <set>
#include <string_view>

#include "common/scene/scene.h"

namespace haptics::scene_version_test {
namespace {

ObjectRecord object(ObjectId id, const std::string& name, std::uint64_t revision = 1) {
  ObjectRecord record;
  record.id = id;
  record.name = name;
  record.revision = revision;
  record.mesh = Hasher().add(id).finish();
  return record;
}

Commit commit(std::uint64_t revision, std::vector<ObjectRecord> put, std::vector<ObjectId> removed = {}) {
  Commit c;
  c.revision = revision;
  c.put = std::move(put);
  c.removed = std::move(removed);
  return c;
}

std::vector<ObjectId> ids(const SceneVersion& scene) {
  std::vector<ObjectId> out;
  for (const auto& o : scene.objects()) out.push_back(o->id);
  return out;
}

TEST(SceneVersion, StartsEmptyAtRevisionZeroWithARoot) {
  const SceneVersion scene;
  EXPECT_EQ(scene.revision(), 0U);
  EXPECT_TRUE(scene.objects().empty());
  EXPECT_FALSE(scene.root().isZero());
  EXPECT_EQ(scene.root(), SceneVersion::fromSnapshot(0, {})->root());
}

TEST(SceneVersion, KeepsObjectsInOrderOfIdWhateverTheOrderOfArrival) {
  const auto scene = SceneVersion().apply(commit(1, {object(5, "e"), object(2, "b"), object(9, "i")}));
  ASSERT_TRUE(scene);
  EXPECT_EQ(ids(*scene), (std::vector<ObjectId>{2, 5, 9}));
}

TEST(SceneVersion, HasTheSameRootForEveryOrderOfASnapshotsObjects) {
  std::vector<ObjectRecord> objects = {object(1, "a"), object(2, "b"), object(3, "c"), object(4, "d")};
  const ContentHash root = SceneVersion::fromSnapshot(4, objects)->root();
  const auto byId = [](const ObjectRecord& a, const ObjectRecord& b) { return a.id < b.id; };
  while (std::ranges::next_permutation(objects, byId).found) {
    EXPECT_EQ(SceneVersion::fromSnapshot(4, objects)->root(), root);
  }
}

TEST(SceneVersion, ReachesTheSameRootByCommitsAndBySnapshot) {
  std::mt19937_64 random(7);
  SceneVersion scene;
  std::map<ObjectId, ObjectRecord> model;
  for (std::uint64_t revision = 1; revision <= 200; ++revision) {
    Commit c = commit(revision, {});
    for (std::uint64_t i = random() % 3; i-- > 0;) {
      const ObjectId id = 1 + random() % 20;
      ObjectRecord record = object(id, "object" + std::to_string(id), revision);
      record.pose.position.x = static_cast<double>(random() % 1000);
      c.put.push_back(record);
    }
    if (!model.empty() && random() % 3 == 0) c.removed.push_back(model.begin()->first);
    for (const ObjectId id : c.removed) model.erase(id);
    for (const ObjectRecord& record : c.put) model[record.id] = record;

    auto next = scene.apply(c);
    ASSERT_TRUE(next) << next.error().text();
    scene = *next;
    std::vector<ObjectRecord> records;
    records.reserve(model.size());
    for (const auto& [id, record] : model) records.push_back(record);
    ASSERT_EQ(scene.root(), SceneVersion::fromSnapshot(revision, records)->root()) << "revision " << revision;
  }
}

TEST(SceneVersion, IsNotChangedByApplying) {
  const SceneVersion before = *SceneVersion().apply(commit(1, {object(1, "a")}));
  const ContentHash root = before.root();
  ASSERT_TRUE(before.apply(commit(2, {object(1, "a", 2), object(2, "b", 2)})));
  EXPECT_EQ(before.root(), root);
  EXPECT_EQ(before.objects().size(), 1U);
}

TEST(SceneVersion, SharesTheObjectsThatACommitDoesNotTouch) {
  const SceneVersion before = *SceneVersion().apply(commit(1, {object(1, "a"), object(2, "b")}));
  const SceneVersion after = *before.apply(commit(2, {object(2, "b", 2)}));
  EXPECT_EQ(after.find(1), before.find(1));
  EXPECT_NE(after.find(2), before.find(2));
}

TEST(SceneVersion, ChangesItsRootWithTheRevisionAlone) {
  EXPECT_NE(SceneVersion::fromSnapshot(1, {})->root(), SceneVersion::fromSnapshot(2, {})->root());
}

TEST(SceneVersion, RefusesARevisionThatDoesNotFollow) {
  for (const std::uint64_t revision : {0, 1, 3, 100}) {
    const auto scene = SceneVersion::fromSnapshot(1, {})->apply(commit(revision, {}));
    ASSERT_FALSE(scene) << revision;
    EXPECT_EQ(scene.error().field, "revision");
  }
}

TEST(SceneVersion, RefusesToRemoveWhatIsNotThere) {
  const SceneVersion scene = *SceneVersion().apply(commit(1, {object(2, "b")}));
  for (const ObjectId id : {0, 1, 3}) {
    const auto next = scene.apply(commit(2, {}, {id}));
    ASSERT_FALSE(next) << id;
    EXPECT_EQ(next.error().field, "removed");
  }
  EXPECT_FALSE(scene.apply(commit(2, {}, {2, 2})));
}

TEST(SceneVersion, RefusesANameThatAnotherObjectHas) {
  const SceneVersion scene = *SceneVersion().apply(commit(1, {object(1, "a")}));
  const auto next = scene.apply(commit(2, {object(2, "a")}));
  ASSERT_FALSE(next);
  EXPECT_EQ(next.error().field, "put.name");
  EXPECT_FALSE(scene.apply(commit(2, {object(2, "b"), object(3, "b")})));
}

TEST(SceneVersion, RefusesObjectsWithoutIdOrName) {
  const auto withoutId = SceneVersion().apply(commit(1, {object(0, "a")}));
  ASSERT_FALSE(withoutId);
  EXPECT_EQ(withoutId.error().field, "put.id");
  const auto withoutName = SceneVersion().apply(commit(1, {object(1, "")}));
  ASSERT_FALSE(withoutName);
  EXPECT_EQ(withoutName.error().field, "put.name");
  EXPECT_FALSE(SceneVersion::fromSnapshot(1, {object(0, "a")}));
  EXPECT_FALSE(SceneVersion::fromSnapshot(1, {object(1, "")}));
}

TEST(SceneVersion, RefusesSnapshotsWithDoubleIdsOrNames) {
  EXPECT_FALSE(SceneVersion::fromSnapshot(1, {object(1, "a"), object(2, "b"), object(1, "c")}));
  EXPECT_FALSE(SceneVersion::fromSnapshot(1, {object(1, "a"), object(2, "a")}));
}

TEST(SceneVersion, GivesAFreedNameToANewObjectInTheSameCommit) {
  const SceneVersion scene = *SceneVersion().apply(commit(1, {object(1, "a")}));
  const auto next = scene.apply(commit(2, {object(2, "a", 2)}, {1}));
  ASSERT_TRUE(next);
  EXPECT_EQ(next->find(std::string("a"))->id, 2U);
}

TEST(SceneVersion, FindsByIdAndByName) {
  const SceneVersion scene = *SceneVersion().apply(commit(1, {object(3, "c"), object(7, "g")}));
  EXPECT_EQ(scene.find(7)->name, "g");
  EXPECT_EQ(scene.find(std::string("c"))->id, 3U);
  for (const ObjectId id : {0, 1, 4, 8}) EXPECT_EQ(scene.find(id), nullptr);
  EXPECT_EQ(scene.find(std::string("h")), nullptr);
}

TEST(ObjectRecord, HashesEveryField) {
  const ObjectRecord plain = object(1, "a");
  const std::vector<std::function<void(ObjectRecord&)>> changes = {
      [](ObjectRecord& r) { r.id = 2; },
      [](ObjectRecord& r) { r.name = "b"; },
      [](ObjectRecord& r) { r.revision = 2; },
      [](ObjectRecord& r) { r.mesh = {}; },
      [](ObjectRecord& r) { r.pose.rotation.w = 0.5; },
      [](ObjectRecord& r) { r.pose.rotation.x = 0.5; },
      [](ObjectRecord& r) { r.pose.rotation.y = 0.5; },
      [](ObjectRecord& r) { r.pose.rotation.z = 0.5; },
      [](ObjectRecord& r) { r.pose.position.x = 0.5; },
      [](ObjectRecord& r) { r.pose.position.y = 0.5; },
      [](ObjectRecord& r) { r.pose.position.z = 0.5; },
      [](ObjectRecord& r) { r.material.color.red = 0.1F; },
      [](ObjectRecord& r) { r.material.color.green = 0.1F; },
      [](ObjectRecord& r) { r.material.color.blue = 0.1F; },
  };
  std::set<ContentHash> hashes{plain.hash()};
  ObjectRecord other = plain;
  forEachMaterialScalar(
      [&](std::string_view name, double& value) {
        value += 0.25;
        EXPECT_TRUE(hashes.insert(other.hash()).second) << name;
      },
      other.material);
  std::map<ContentHash, std::size_t> seen{{plain.hash(), changes.size()}};
  for (std::size_t i = 0; i < changes.size(); ++i) {
    ObjectRecord changed = plain;
    changes[i](changed);
    EXPECT_TRUE(seen.emplace(changed.hash(), i).second) << "change " << i << " gives a hash seen before";
  }
}

TEST(PoseEdit, KeepsWhatItDoesNotName) {
  const Pose before{Quat(0, 1, 0, 0), {1, 2, 3}};
  EXPECT_EQ(edited(before, {}), before);
  EXPECT_EQ(edited(before, {Vec3(4, 5, 6), {}}), (Pose{before.rotation, {4, 5, 6}}));
  EXPECT_EQ(edited(before, {{}, Quat(1, 0, 0, 0)}), (Pose{Quat(1, 0, 0, 0), before.position}));
}

TEST(MaterialEdit, KeepsWhatItDoesNotName) {
  const Material before{100, 2, {0, 1, 0}};
  EXPECT_EQ(edited(before, {}), before);
  EXPECT_EQ(edited(before, {.stiffness_N_per_m = 7, .damping_Ns_per_m = {}, .color = {}}), (Material{7, 2, {0, 1, 0}}));
  EXPECT_EQ(edited(before, {.stiffness_N_per_m = {}, .damping_Ns_per_m = 0, .color = {}}),
            (Material{100, 0, {0, 1, 0}}));
}

TEST(ObjectRef, SaysHowTheObjectWasNamed) {
  EXPECT_EQ(ObjectRef{ObjectId{7}}.text(), "object 7");
  EXPECT_EQ(ObjectRef{std::string("torus")}.text(), "object \"torus\"");
}

}  // namespace
}  // namespace haptics::scene_version_test
