#include <gmock/gmock.h>

#include <fstream>

#include "common/wire/convert.h"
#include "tests/common/temporary_folder.h"

namespace haptics::scene_text_test {
namespace {

using testing::HasSubstr;

Error errorOf(const std::string& text) {
  const auto transaction = parseSceneText(text, "demo.scene");
  EXPECT_FALSE(transaction) << text;
  return transaction ? Error{} : transaction.error();
}

TEST(SceneText, IsATransaction) {
  const auto transaction = parseSceneText(R"(
    # A comment.
    operations { add { name: "torus" mesh { torus { major_radius_m: 0.05 minor_radius_m: 0.02 } } } }
    operations { set_material { object { id: 3 } material { stiffness_N_per_m: 500 } } })",
                                          "demo.scene");
  ASSERT_TRUE(transaction) << transaction.error().text();
  EXPECT_EQ(transaction->operations_size(), 2);
  EXPECT_EQ(transaction->operations(1).set_material().material().stiffness_n_per_m(), 500);
}

TEST(SceneText, NamesAnUnknownFieldItsPlaceAndTheFieldsThatThereAre) {
  const Error error = errorOf("operations {\n  set_material {\n    material { stifness: 5 }\n  }\n}\n");
  EXPECT_EQ(error.field, "demo.scene:3:24");
  EXPECT_THAT(error.reason, HasSubstr("Material has no field \"stifness\""));
  EXPECT_THAT(error.reason, HasSubstr("its fields are stiffness_N_per_m, damping_Ns_per_m, color"));
  EXPECT_THAT(error.reason, HasSubstr("the line reads: material { stifness: 5 }"));
}

TEST(SceneText, ListsTheOperationsForAnUnknownOne) {
  EXPECT_THAT(errorOf("operations { move { } }").reason, HasSubstr("add, remove, remesh, set_pose, set_material"));
}

TEST(SceneText, ListsTheTopLevelFields) {
  EXPECT_THAT(errorOf("objects { }").reason, HasSubstr("preconditions, operations"));
}

TEST(SceneText, SaysWhereAndWhatTypeWasExpected) {
  const Error error = errorOf("operations { add {\n  name: 5\n} }");
  EXPECT_THAT(error.field, testing::StartsWith("demo.scene:2:"));
  EXPECT_THAT(error.reason, HasSubstr("Expected string"));
  EXPECT_THAT(error.reason, HasSubstr("name: 5"));
  EXPECT_THAT(errorOf("operations { add { mesh { sphere { radius_m: 'big' } } } }").reason, HasSubstr("double"));
  EXPECT_THAT(errorOf("operations { add { mesh { sphere { segments: -4 } } } }").reason, HasSubstr("integer"));
}

TEST(SceneText, RefusesAFieldGivenTwice) {
  EXPECT_THAT(errorOf("operations { add { name: 'a' name: 'b' } }").field, testing::StartsWith("demo.scene:1:"));
}

TEST(SceneText, RefusesTwoMeshSourcesAtOnce) {
  EXPECT_THAT(errorOf("operations { add { mesh { file: 'a.obj' asset: 'x' } } }").field,
              testing::StartsWith("demo.scene:1:"));
}

TEST(SceneText, NamesThePlaceOfATruncatedScene) {
  EXPECT_THAT(errorOf("operations { add {\n name: 'a'\n").field, testing::StartsWith("demo.scene:"));
}

TEST(SceneText, MayHaveAByteOrderMarkAndAnyLineEnds) {
  const std::string ends[] = {"\n", "\r\n", "\r"};
  for (const std::string& end : ends) {
    const std::string text = "\xef\xbb\xbf# one" + end + "operations { remove { object { id: 1 } } }" + end + "# two" +
                             end + "operations { remove { object { id: 2 } } }" + end + '\x1a' + std::string(3, '\0');
    const auto transaction = parseSceneText(text, "demo.scene");
    ASSERT_TRUE(transaction) << transaction.error().text();
    EXPECT_EQ(transaction->operations_size(), 2);
    EXPECT_THAT(errorOf(end + end + "operations { ad {} }").field, testing::StartsWith("demo.scene:3:"));
  }
  using namespace std::string_literals;
  EXPECT_THAT(errorOf("\xff\xfeo\0p\0"s).reason, HasSubstr("UTF-16"));
  EXPECT_THAT(errorOf("\0o\0p\0e"s).reason, HasSubstr("UTF-16"));
  EXPECT_THAT(errorOf("\xff\xfe\0\0o\0\0\0"s).reason, HasSubstr("UTF-32"));
}

TEST(SceneText, NamesACharacterThatOnlyLooksRight) {
  EXPECT_TRUE(parseSceneText("# \u201c\u00a0\xa0\noperations { add { name: '\u201c\u00a0' } }", "demo.scene"));
  EXPECT_THAT(errorOf("operations {\n\t\tadd\u00a0{ } }").text(),
              HasSubstr("demo.scene:2:20: holds U+00A0, a special blank"));
  EXPECT_THAT(errorOf("operations { add { name: \u201ca\u201d } }").reason,
              HasSubstr("U+201C, a typographic quotation"));
  EXPECT_THAT(errorOf("\u00fc { }").reason, HasSubstr("U+00FC; only strings and comments"));
  EXPECT_THAT(errorOf("operations\xa0{ }").reason, HasSubstr("the byte 0xa0, which is no UTF-8"));
}

TEST(SceneText, NamesTheBraceThatIsOpen) {
  const std::string text =
      "operations {\n  add {\n    name: '}{'  # }{\n    pose {\n      position { x: 1 }\n    }\n    material {\n"
      "      damping_Ns_per_m: 1\n    }\n  }\n}\noperations {\n  remove { object { id: 1 } }\n}\n";
  ASSERT_TRUE(parseSceneText(text, "demo.scene"));
  const int opened[] = {5, 4, 7, 2, 1, 13, 13, 12};  // lines, in the order in which they are closed
  std::size_t at = text.find("}{\n");
  for (const int line : opened) {
    at = text.find('}', at + 1);
    EXPECT_THAT(errorOf(std::string(text).erase(at, 1)).reason,
                HasSubstr("the \"{\" of line " + std::to_string(line) + " ("));
  }
  EXPECT_THAT(errorOf(text + "}").reason, testing::Not(HasSubstr("open at the end")));
}

TEST(SceneText, SurvivesBinaryRubbish) {
  std::string rubbish;
  for (int i = 0; i < 5'000; ++i) rubbish += static_cast<char>(i * 7919 >> 3);
  EXPECT_FALSE(errorOf(rubbish).reason.empty());
}

TEST(SceneText, MayBeEmptyAsFarAsItsFormGoes) { EXPECT_TRUE(parseSceneText("# nothing yet\n", "demo.scene")); }

TEST(SceneText, HasALargestSize) {
  EXPECT_THAT(errorOf(std::string(kMaxSceneTextBytes + 1, ' ')).reason, HasSubstr("4 MiB"));
}

TEST(SceneText, HasADeepestNesting) {
  std::string text = "operations { set_material { material { texture { field { ";
  for (int i = 0; i < 100'000; ++i) text += "layers { layer { field { ";
  EXPECT_THAT(errorOf(text).reason, HasSubstr("too deep"));
}

class SceneFile : public testing::Test {
 protected:
  const test::TemporaryFolder folder_;
};

TEST_F(SceneFile, IsReadByItsPath) {
  const auto path = folder_ / "one.scene";
  std::ofstream(path) << "operations { remove { object { id: 1 } } }";
  const auto transaction = readSceneFile(path);
  ASSERT_TRUE(transaction) << transaction.error().text();
  EXPECT_EQ(transaction->operations_size(), 1);
}

TEST_F(SceneFile, IsNamedWhenItIsMissing) {
  const auto path = (folder_ / "none.scene").string();
  const auto transaction = readSceneFile(path);
  ASSERT_FALSE(transaction);
  EXPECT_EQ(transaction.error().text(), path + ": there is no such file");
}

TEST_F(SceneFile, IsNotADirectory) {
  const auto transaction = readSceneFile(folder_.path());
  ASSERT_FALSE(transaction);
  EXPECT_THAT(transaction.error().text(), HasSubstr("is a directory"));
}

TEST_F(SceneFile, IsNamedWithThePlaceOfItsError) {
  const auto path = folder_ / "bad.scene";
  std::ofstream(path) << "\n\noperations { ad {} }";
  const auto transaction = readSceneFile(path);
  ASSERT_FALSE(transaction);
  EXPECT_THAT(transaction.error().field, testing::StartsWith(path.string() + ":3:"));
}

}  // namespace
}  // namespace haptics::scene_text_test
