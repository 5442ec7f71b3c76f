#include <gmock/gmock.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/text_format.h>

#include <string_view>

#include "common/wire/convert.h"
#include "haptics/v1/options.pb.h"

namespace haptics::convert_edit_test {
namespace {

using testing::HasSubstr;

v1::Transaction parse(const std::string& text) {
  v1::Transaction message;
  EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString(text, &message)) << text;
  return message;
}

std::string escaped(const std::string& bytes) {
  std::string text;
  for (const char b : bytes) {
    char digits[5];
    std::snprintf(digits, sizeof digits, "\\%03o", static_cast<unsigned char>(b));
    text += digits;
  }
  return text;
}

struct BadEdit {
  std::string text;    // a transaction
  std::string field;   // that is named
  std::string reason;  // part of what is said
};

void PrintTo(const BadEdit& bad, std::ostream* out) { *out << bad.text; }

class RefusedEdit : public testing::TestWithParam<BadEdit> {};

TEST_P(RefusedEdit, NamesItsFieldAndWhatWouldBeRight) {
  const auto transaction = fromWire(parse(GetParam().text));
  ASSERT_FALSE(transaction);
  EXPECT_EQ(transaction.error().field, GetParam().field);
  EXPECT_THAT(transaction.error().reason, HasSubstr(GetParam().reason));
}

const std::string kBox = " mesh { box { size_m { x: 1 y: 1 z: 1 } } } ";

std::string add(const std::string& rest) { return "operations { add { name: 'a' " + rest + " } }"; }
std::string mesh(const std::string& source) { return add("mesh { " + source + " }"); }
std::string material(const std::string& fields) { return add(kBox + " material { " + fields + " }"); }
std::string pose(const std::string& fields) { return add(kBox + " pose { " + fields + " }"); }

const std::string kMesh = "operations[0].add.mesh.", kPose = "operations[0].add.pose.",
                  kMaterial = "operations[0].add.material.";

INSTANTIATE_TEST_SUITE_P(
    Shape, RefusedEdit,
    testing::ValuesIn(std::vector<BadEdit>{
        {"", "operations", "at least one"},  //
        {"operations {}", "operations[0].op", "give add, remove"},
        {"operations { remove { object { id: 1 } } } operations { remove {} }", "operations[1].remove.object",
         "its id or its name"},
        {"operations { remove { object { id: 0 } } }", "operations[0].remove.object.id", "start at 1"},
        {"operations { remove { object { name: '' } } }", "operations[0].remove.object.name", "is missing"},
        {"operations { remesh { mesh { sphere { radius_m: 1 } } } }", "operations[0].remesh.object", "missing"},
        {"operations { remesh { object { id: 1 } } }", "operations[0].remesh.mesh.source", "is missing"},
        {"operations { set_pose { pose { position {} } } }", "operations[0].set_pose.object", "is missing"},
        {"operations { set_pose { object { id: 1 } } }", "operations[0].set_pose.pose", "position, rotation"},
        {"operations { set_material { object { id: 1 } } }", "operations[0].set_material.material", "is empty"},
        {"operations { set_material { object { id: 2 } material { stiffness_N_per_m: -1 } } }",
         "operations[0].set_material.material.stiffness_N_per_m", "more than 0"},
        {"preconditions {} operations { remove { object { id: 1 } } }", "preconditions[0].object", "is missing"},
        {"preconditions { object { id: 1 } expected_hash: 'short' } operations { remove { object { id: 1 } } }",
         "preconditions[0].expected_hash", "has 5 bytes"}}));

INSTANTIATE_TEST_SUITE_P(Name, RefusedEdit,
                         testing::ValuesIn(std::vector<BadEdit>{
                             {"operations { add { " + kBox + " } }", "operations[0].add.name", "is missing"},
                             {"operations { add { name: 'a b' " + kBox + " } }", "operations[0].add.name", "A-Z"},
                             {"operations { add { name: '../a/' " + kBox + " } }", "operations[0].add.name", "A-Z"},
                             {"operations { add { name: '" + std::string(65, 'x') + "' " + kBox + " } }",
                              "operations[0].add.name", "has 65 characters"}}));

INSTANTIATE_TEST_SUITE_P(
    Mesh, RefusedEdit,
    testing::ValuesIn(std::vector<BadEdit>{
        {add(""), kMesh + "source", "give file, asset, box"},
        {mesh("file: ''"), kMesh + "file", "is empty"},
        {mesh("file: '/etc/passwd'"), kMesh + "file", "absolute"},
        {mesh("file: '..'"), kMesh + "file", "leaves"},
        {mesh("file: 'a/../../b.obj'"), kMesh + "file", "leaves"},
        {mesh("file: 'a\\000.obj'"), kMesh + "file", "zero byte"},
        {mesh("file: '" + std::string(256, 'x') + "'"), kMesh + "file", "255"},
        {mesh("file: 'a.obj' unit_m: 0"), kMesh + "unit_m", "more than 0"},
        {mesh("file: 'a.obj' unit_m: nan"), kMesh + "unit_m", "nan"},
        {mesh("file: 'a.obj' largest_extent_m: -1"), kMesh + "largest_extent_m", "more than 0"},
        {mesh("file: 'a.obj' unit_m: 1 largest_extent_m: 1"), kMesh + "largest_extent_m", "one of them"},
        {mesh("sphere { radius_m: 1 } unit_m: 1"), kMesh + "unit_m", "files only"},
        {mesh("sphere { radius_m: 1 } largest_extent_m: 1"), kMesh + "largest_extent_m", "files only"},
        {mesh("file: 'a.glb' part: ''"), kMesh + "part", "1 to 1023"},
        {mesh("file: 'a.glb' part: '" + std::string(1024, 'x') + "'"), kMesh + "part", "has 1024 bytes"},
        {mesh("sphere { radius_m: 1 } part: 'a'"), kMesh + "part", "files only"},
        {mesh("asset: 'x'"), kMesh + "asset", "has 32"},
        {mesh("box {}"), kMesh + "box.size_m", "is missing"},
        {mesh("box { size_m { x: 1 y: 0 z: 1 } }"), kMesh + "box.size_m.y", "more than 0"},
        {mesh("box { size_m { x: 1 y: 1 z: inf } }"), kMesh + "box.size_m.z", "inf"},
        {mesh("box { size_m { x: -1 y: 1 z: 1 } }"), kMesh + "box.size_m.x", "more than 0"},
        {mesh("box { size_m { x: 1 y: 1 z: 1 } segments: 4000000000 }"), kMesh + "box.segments", "1 to 1024"},
        {mesh("sphere {}"), kMesh + "sphere.radius_m", "more than 0"},
        {mesh("sphere { radius_m: 1e-12 }"), kMesh + "sphere.radius_m", "at least 1e-09 m"},
        {mesh("sphere { radius_m: 1001 }"), kMesh + "sphere.radius_m", "at most 1000"},
        {mesh("sphere { radius_m: 1 segments: 1025 }"), kMesh + "sphere.segments", "1024"},
        {mesh("cylinder { radius_m: 1 }"), kMesh + "cylinder.height_m", "more than 0"},
        {mesh("cylinder { height_m: 1 }"), kMesh + "cylinder.radius_m", "more than 0"},
        {mesh("cylinder { radius_m: 1 height_m: 1 segments: 2 }"), kMesh + "cylinder.segments", "3 to"},
        {mesh("torus { minor_radius_m: 1 }"), kMesh + "torus.major_radius_m", "more than 0"},
        {mesh("torus { major_radius_m: 1 }"), kMesh + "torus.minor_radius_m", "more than 0"},
        {mesh("torus { major_radius_m: 1 minor_radius_m: 1 }"), kMesh + "torus.minor_radius_m", "below major_radius_m"},
        {mesh("torus { major_radius_m: 1 minor_radius_m: 0.1 major_segments: 2 }"), kMesh + "torus.major_segments",
         "3 to"},
        {mesh("torus { major_radius_m: 1 minor_radius_m: 0.1 minor_segments: 2 }"), kMesh + "torus.minor_segments",
         "3 to"},
        {mesh("sphere { radius_m: 1 } simplify { error: 1e-300 }"), kMesh + "simplify.error", "at least 0.001"},
        {mesh("sphere { radius_m: 1 } simplify {}"), kMesh + "simplify.error", "more than 0 and at most 10"},
        {mesh("sphere { radius_m: 1 } simplify { error: -1 }"), kMesh + "simplify.error", "1 is just noticeable"},
        {mesh("sphere { radius_m: 1 } simplify { error: 11 }"), kMesh + "simplify.error", "at most 10"},
        {mesh("file: 'a.ply' simplify { error: nan }"), kMesh + "simplify.error", "nan"}}));

INSTANTIATE_TEST_SUITE_P(PoseAndMaterial, RefusedEdit,
                         testing::ValuesIn(std::vector<BadEdit>{
                             {pose("position { x: nan }"), kPose + "position.x", "nan"},
                             {pose("position { y: -inf }"), kPose + "position.y", "-inf"},
                             {pose("position { z: 1001 }"), kPose + "position.z", "from -1000 to 1000"},
                             {pose("rotation {}"), kPose + "rotation", "length 0"},
                             {pose("rotation { w: 1 x: 1 }"), kPose + "rotation", "unit quaternion"},
                             {pose("rotation { w: 1.002 }"), kPose + "rotation", "unit quaternion"},
                             {pose("rotation { w: nan }"), kPose + "rotation", "nan"},
                             {material("stiffness_N_per_m: 0"), kMaterial + "stiffness_N_per_m", "more than 0"},
                             {material("stiffness_N_per_m: 1e-3"), kMaterial + "stiffness_N_per_m",
                              "at least 0.01 N/m"},
                             {material("stiffness_N_per_m: 100001"), kMaterial + "stiffness_N_per_m", "100000 N/m"},
                             {material("damping_Ns_per_m: -0.1"), kMaterial + "damping_Ns_per_m", "0 to 1000 N s/m"},
                             {material("color { red: 1.1 }"), kMaterial + "color.red", "0 to 1"},
                             {material("color { green: -0.1 }"), kMaterial + "color.green", "0 to 1"},
                             {material("color { blue: nan }"), kMaterial + "color.blue", "0 to 1"}}));

TEST(RefusedEdits, IncludeNumbersOfAMaterialBeyondWhatSceneProtoSays) {
  const Material plain;
  forEachMaterialScalar(
      [](std::string_view name, double initial) {
        const v1::Scalar& scalar = materialScalar(name).options().GetExtension(v1::scalar);
        EXPECT_EQ(initial, scalar.initial()) << name;
        const auto most = fromWire(parse(material(std::string(name) + ": " + std::to_string(scalar.most()))));
        ASSERT_TRUE(most) << name;
        forEachMaterialScalar(
            [&](std::string_view its, const std::optional<double>& value) {
              EXPECT_EQ(value, its == name ? std::optional(scalar.most()) : std::nullopt) << name;
            },
            std::get<AddObject>(most->operations[0]).material);
        for (const std::string bad : {"-1", "nan", "inf"}) {
          const auto transaction = fromWire(parse(material(std::string(name) + ": " + bad)));
          ASSERT_FALSE(transaction) << name << bad;
          EXPECT_EQ(transaction.error().field, kMaterial + std::string(name));
          EXPECT_THAT(transaction.error().reason, testing::AllOf(HasSubstr(bad), HasSubstr(scalar.unit())));
        }
      },
      plain);
}

TEST(RefusedEdits, IncludeMoreOperationsThanATransactionTakes) {
  v1::Transaction message;
  for (std::size_t i = 0; i < kMaxOperations; ++i)
    message.add_operations()->mutable_remove()->mutable_object()->set_id(1);
  EXPECT_TRUE(fromWire(message));
  message.add_operations()->mutable_remove()->mutable_object()->set_id(1);
  const auto tooMany = fromWire(message);
  ASSERT_FALSE(tooMany);
  EXPECT_EQ(tooMany.error().field, "operations");
}

TEST(RefusedEdits, IncludeMorePreconditionsThanATransactionTakes) {
  v1::Transaction message = parse("operations { remove { object { id: 1 } } }");
  for (std::size_t i = 0; i <= kMaxOperations; ++i) message.add_preconditions()->mutable_object()->set_id(1);
  const auto tooMany = fromWire(message);
  ASSERT_FALSE(tooMany);
  EXPECT_EQ(tooMany.error().field, "preconditions");
}

TEST(RefusedEdits, IncludeFieldsOfANewerClientAtAnyDepth) {
  v1::Transaction message = parse(add(kBox + "material { stiffness_N_per_m: 5 }"));
  v1::Material& m = *message.mutable_operations(0)->mutable_add()->mutable_material();
  m.GetReflection()->MutableUnknownFields(&m)->AddVarint(99, 1);
  const auto transaction = fromWire(message);
  ASSERT_FALSE(transaction);
  EXPECT_EQ(transaction.error().field, "operations[0].add.material.#99");
  EXPECT_THAT(transaction.error().reason, HasSubstr("newer than the server"));
}

TEST(Edits, MayBeAnythingWithinTheLimits) {
  const auto transaction =
      fromWire(parse(material("stiffness_N_per_m: 100000 damping_Ns_per_m: 0 color { red: 0 green: 1 blue: 0.5 }") +
                     pose("position { x: -1000 y: 1000 } rotation { z: -1 }")));
  ASSERT_TRUE(transaction) << transaction.error().text();
  const auto& first = std::get<AddObject>(transaction->operations[0]);
  EXPECT_EQ(first.material.stiffness_N_per_m, 100'000);
  EXPECT_EQ(first.material.damping_Ns_per_m, 0);
  EXPECT_EQ(first.material.color, (Color{0, 1, 0.5F}));
  const auto& second = std::get<AddObject>(transaction->operations[1]);
  EXPECT_EQ(second.pose.position, Vec3(-1000, 1000, 0));
  EXPECT_EQ(second.pose.rotation, Quat(0, 0, 0, -1));
}

TEST(Edits, LeaveWhatTheyDoNotNameToTheSequencer) {
  const auto transaction =
      fromWire(parse("operations { set_material { object { name: 'b' } material { damping_Ns_per_m: 2 } } }"
                     "operations { set_pose { object { id: 4 } pose { position { z: 3 } } } }"));
  ASSERT_TRUE(transaction) << transaction.error().text();
  const auto& setMaterial = std::get<SetMaterial>(transaction->operations[0]);
  EXPECT_EQ(setMaterial.object.text(), "object \"b\"");
  EXPECT_FALSE(setMaterial.material.stiffness_N_per_m);
  EXPECT_FALSE(setMaterial.material.color);
  EXPECT_EQ(setMaterial.material.damping_Ns_per_m, 2);
  const auto& setPose = std::get<SetPose>(transaction->operations[1]);
  EXPECT_EQ(setPose.object.text(), "object 4");
  EXPECT_EQ(setPose.pose.position, Vec3(0, 0, 3));
  EXPECT_FALSE(setPose.pose.rotation);
}

TEST(Edits, ComeOutWithRotationsOfUnitLength) {
  const auto transaction = fromWire(parse(pose("rotation { w: 0.6005 z: 0.8005 }")));
  ASSERT_TRUE(transaction) << transaction.error().text();
  EXPECT_NEAR(glm::length(*std::get<AddObject>(transaction->operations[0]).pose.rotation), 1, 1e-15);
}

TEST(Edits, KeepARotationThatWasNormalisedBitForBit) {
  int others = 0;  // that glm::normalize does not leave as they are
  for (int i = 0; i < 1000; ++i) {
    const Quat rotation = glm::normalize(Quat(1, 0.001 * i, 0.3, -0.007 * i));
    if (glm::normalize(rotation) != rotation) ++others;
    v1::Transaction message = parse(pose("rotation {}"));
    v1::Quaternion& given = *message.mutable_operations(0)->mutable_add()->mutable_pose()->mutable_rotation();
    given.set_w(rotation.w);
    given.set_x(rotation.x);
    given.set_y(rotation.y);
    given.set_z(rotation.z);
    const auto transaction = fromWire(message);
    ASSERT_TRUE(transaction) << transaction.error().text();
    EXPECT_EQ(*std::get<AddObject>(transaction->operations[0]).pose.rotation, rotation);
  }
  EXPECT_GT(others, 0);
}

TEST(Edits, CarryHowMuchMayBeFeltOfAMeshThatIsSimplified) {
  const auto transaction = fromWire(parse(mesh("file: 'a.ply' simplify { error: 0.5 }") + mesh("file: 'a.ply'")));
  ASSERT_TRUE(transaction) << transaction.error().text();
  EXPECT_EQ(std::get<AddObject>(transaction->operations[0]).mesh.simplifyError, 0.5);
  EXPECT_FALSE(std::get<AddObject>(transaction->operations[1]).mesh.simplifyError);
}

TEST(Edits, CarryEveryKindOfMesh) {
  const ContentHash hash = Hasher().add(std::uint64_t{1}).finish();
  const auto transaction = fromWire(
      parse(mesh("file: 'heads/josie.iv' largest_extent_m: 0.2") + mesh("file: 'a..b.stl' unit_m: 0.001") +
            mesh("asset: '" + escaped(hash.asBytes()) + "'") + mesh("box { size_m { x: 1 y: 2 z: 3 } segments: 4 }") +
            mesh("sphere { radius_m: 5 }") + mesh("cylinder { radius_m: 6 height_m: 7 segments: 8 }") +
            mesh("torus { major_radius_m: 9 minor_radius_m: 8 major_segments: 7 }")));
  ASSERT_TRUE(transaction) << transaction.error().text();
  const auto source = [&](std::size_t i) { return std::get<AddObject>(transaction->operations[i]).mesh; };
  EXPECT_EQ(std::get<FileSource>(source(0).source).path, "heads/josie.iv");
  EXPECT_EQ(source(0).largestExtent_m, 0.2);
  EXPECT_EQ(source(1).unit_m, 0.001);
  EXPECT_FALSE(source(1).largestExtent_m);
  EXPECT_EQ(std::get<AssetSource>(source(2).source).hash, hash);
  EXPECT_EQ(std::get<BoxSource>(source(3).source).size_m, Vec3(1, 2, 3));
  EXPECT_EQ(std::get<BoxSource>(source(3).source).segments, 4U);
  EXPECT_EQ(std::get<SphereSource>(source(4).source).segments, SphereSource{}.segments);
  EXPECT_EQ(std::get<CylinderSource>(source(5).source).height_m, 7);
  EXPECT_EQ(std::get<CylinderSource>(source(5).source).segments, 8U);
  EXPECT_EQ(std::get<TorusSource>(source(6).source).majorSegments, 7U);
  EXPECT_EQ(std::get<TorusSource>(source(6).source).minorSegments, TorusSource{}.minorSegments);
}

TEST(Edits, CarryPreconditionsWithOrWithoutHash) {
  const ContentHash hash = Hasher().add(std::uint64_t{2}).finish();
  const auto transaction =
      fromWire(parse("preconditions { object { id: 7 } expected_revision: 5 }"
                     "preconditions { object { name: 'x' } expected_revision: 6 expected_hash: '" +
                     escaped(hash.asBytes()) + "' } operations { remove { object { id: 7 } } }"));
  ASSERT_TRUE(transaction) << transaction.error().text();
  ASSERT_EQ(transaction->preconditions.size(), 2U);
  EXPECT_EQ(transaction->preconditions[0].expectedRevision, 5U);
  EXPECT_FALSE(transaction->preconditions[0].expectedHash);
  EXPECT_EQ(transaction->preconditions[1].object.text(), "object \"x\"");
  EXPECT_EQ(transaction->preconditions[1].expectedHash, hash);
}

}  // namespace
}  // namespace haptics::convert_edit_test
