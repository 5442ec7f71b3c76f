#include <algorithm>
#include <random>

#include "common/mesh/import.h"
#include "mesh_files.h"

namespace haptics::import_ply_test {
namespace {

using fixture::raw;
using fixture::tetrahedron;
using ::testing::HasSubstr;

using ImportPly = fixture::MeshFiles;

constexpr float kPoints[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
constexpr std::uint32_t kFaces[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};

std::string header(const std::string& format, const std::string& coordinate, const std::string& list) {
  return "ply\nformat " + format + " 1.0\ncomment by hand\nelement vertex 4\nproperty " + coordinate + " x\nproperty " +
         coordinate + " y\nproperty " + coordinate + " z\nelement face 4\nproperty list " + list +
         " vertex_indices\nend_header\n";
}

template <class T>
std::string bigEndian(T value) {
  std::string bytes = raw(value);
  std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

template <class Coordinate, class Count, class Index>
std::string binaryBody(bool big) {
  std::string body;
  const auto put = [&](auto value) { body += big ? bigEndian(value) : raw(value); };
  for (const auto& point : kPoints) {
    for (const float x : point) put(static_cast<Coordinate>(x));
  }
  for (const auto& face : kFaces) {
    put(Count{3});
    for (const std::uint32_t v : face) put(static_cast<Index>(v));
  }
  return body;
}

std::string textPly() {
  return header("ascii", "float", "uchar int") + "0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n";
}

std::string binaryPly() {
  return header("binary_little_endian", "float", "uchar int") + binaryBody<float, std::uint8_t, std::int32_t>(false);
}

TEST_F(ImportPly, ReadsTextAndBinaryOfEveryTypeToTheSameMesh) {
  EXPECT_EQ(import("t.ply", textPly())->mesh, tetrahedron());
  EXPECT_EQ(import("t.ply", binaryPly())->mesh, tetrahedron());
  EXPECT_EQ(import("t.ply", header("binary_big_endian", "float32", "uint8 uint32") +
                                binaryBody<float, std::uint8_t, std::uint32_t>(true))
                ->mesh,
            tetrahedron());
  EXPECT_EQ(import("t.ply", header("binary_little_endian", "double", "uint ushort") +
                                binaryBody<double, std::uint32_t, std::uint16_t>(false))
                ->mesh,
            tetrahedron());
  EXPECT_EQ(import("t.ply", header("binary_big_endian", "short", "ushort char") +
                                binaryBody<std::int16_t, std::uint16_t, std::int8_t>(true))
                ->mesh,
            tetrahedron());
}

TEST_F(ImportPly, SkipsPropertiesAndElementsThatAreNotGeometry) {
  const std::string ply =
      "ply\r\nformat ascii 1.0\r\nobj_info x\r\nelement camera 1\r\nproperty list uchar float poses\r\n"
      "element vertex 4\r\nproperty uchar red\r\nproperty float z\r\nproperty list uchar int marks\r\nproperty float "
      "x\r\n"
      "property float y\r\nelement face 4\r\nproperty float quality\r\nproperty list uchar int vertex_index\r\n"
      "property list uchar float texcoord\r\nelement edge 1\r\nproperty int vertex1\r\nend_header\r\n"
      "3 0.5 0.5 0.5\r\n"
      "9 0 0 0 0\r\n9 0 2 7 7 1 0\r\n9 0 0 0 1\r\n9 1 1 7 0 0\r\n"
      "0.5 3 0 2 1 0\r\n0.5 3 0 1 3 1 0.5\r\n0.5 3 1 2 3 0\r\n0.5 3 2 0 3 0\r\n0\r\n";
  const auto imported = import("t.ply", ply);
  ASSERT_TRUE(imported) << imported.error().text();
  EXPECT_EQ(imported->mesh, tetrahedron());
}

TEST_F(ImportPly, RefusesAFileThatIsCutOffAnywhere) {
  const std::string binary = binaryPly();
  for (std::size_t size = 1; size < binary.size(); ++size) {
    EXPECT_NE(refusal("t.ply", binary.substr(0, size)), "loaded") << size << " of " << binary.size() << " bytes";
  }
  const std::string text = textPly();
  for (std::size_t size = 1; size < text.size() - 1; ++size) {
    EXPECT_NE(refusal("t.ply", text.substr(0, size)), "loaded") << text.substr(0, size);
  }
  EXPECT_THAT(refusal("t.ply", binary.substr(0, binary.size() - 1)), HasSubstr("cut off"));
}

TEST_F(ImportPly, RefusesAHeaderThatClaimsMoreThanTheFileHolds) {
  for (const std::string& ply : {textPly(), binaryPly()}) {
    std::string vertices = ply, faces = ply;
    vertices.replace(ply.find("vertex 4"), 8, "vertex 300000000");
    faces.replace(ply.find("face 4"), 6, "face 18446744073709551615");
    EXPECT_THAT(refusal("t.ply", vertices), HasSubstr("claims 300000000 of \"vertex\""));
    EXPECT_NE(refusal("t.ply", faces), "loaded");
  }
}

TEST_F(ImportPly, RefusesAFaceThatClaimsMoreCornersThanTheFileHolds) {
  std::string ply = header("binary_little_endian", "float", "uint int");
  for (const auto& point : kPoints) {
    for (const float x : point) ply += raw(x);
  }
  ply += raw(std::uint32_t{4'000'000'000}) + std::string(60, '\0');
  EXPECT_THAT(refusal("t.ply", ply), HasSubstr("in face 0 (from 0) of 4"));
}

TEST_F(ImportPly, NamesTheVertexThatIsNotFinite) {
  std::string ply = textPly();
  ply.replace(ply.find("0 1 0\n"), 5, "0 nan 0");
  EXPECT_THAT(refusal("t.ply", ply), HasSubstr("vertex 2 (from 0) is not finite"));
  ply = header("binary_little_endian", "double", "uchar int") + binaryBody<double, std::uint8_t, std::int32_t>(false);
  ply.replace(ply.find("end_header\n") + 11 + 3 * 8 + 8, 8, raw(1e300));
  EXPECT_THAT(refusal("t.ply", ply), HasSubstr("vertex 1 (from 0) does not fit into float32"));
}

TEST_F(ImportPly, CountsFacesThatItCannotUse) {
  std::string ply = textPly();
  ply.replace(ply.find("3 0 1 3\n"), 7, "4 0 1 3 4");
  ply.replace(ply.find("3 2 0 3\n"), 7, "2 0 3");
  const auto imported = import("t.ply", ply);
  EXPECT_EQ(imported->report.droppedOutOfRange, 2U);
  EXPECT_EQ(imported->report.droppedDegenerate, 1U);
  EXPECT_EQ(imported->report.kept, 2U);
  ply.replace(ply.find("3 0 2 1\n"), 7, "3 -1 2 1");
  EXPECT_EQ(import("t.ply", ply)->report.droppedOutOfRange, 3U);
}

TEST_F(ImportPly, SkipsHeaderLinesThatBeginWithNoKeyword) {
  std::string ply = textPly();
  ply.insert(ply.find("element face"), "author somebody\nscanned 1999\n");
  const auto imported = import("t.ply", ply);
  EXPECT_EQ(imported->mesh, import("t.ply", textPly())->mesh);
  EXPECT_EQ(imported->report.headerLinesSkipped, 2U);
  EXPECT_THAT(imported->report.text(), HasSubstr("2 header lines skipped"));
}

TEST_F(ImportPly, TakesALineFeedAfterAHeaderOfCarriageReturnsForTheBodys) {
  std::string head = header("binary_little_endian", "float", "uchar int");
  head.replace(head.find("property float x"), 0, "property uchar red\n");
  std::replace(head.begin(), head.end(), '\n', '\r');
  std::string body;
  for (const auto& point : kPoints) {
    body += '\n';
    for (const float x : point) body += raw(x);
  }
  const std::string vertices = binaryBody<float, std::uint8_t, std::int32_t>(false);
  EXPECT_EQ(import("t.ply", head + body + vertices.substr(4 * 12))->mesh, tetrahedron());
}

TEST_F(ImportPly, ReadsStripsOfTriangles) {
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
      "element tristrips 2\nproperty list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n";
  const TriMesh expected =
      canonicalise({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 2, 1}, {1, 2, 3}, {1, 3, 0}, {3, 2, 0}}, {})
          ->mesh;
  EXPECT_EQ(import("t.ply", head + "5 0 2 1 3 0\n4 -1 3 2 0\n")->mesh.triangles.size(), 4U);
  EXPECT_EQ(import("t.ply", head + "8 0 2 1 -1 1 2 3 -1\n7 1 3 0 -1 3 2 0\n")->mesh, expected);
  EXPECT_TRUE(import("t.ply", head + "5 0 2 1 3 0\n4 -1 3 2 0\n")->report.closed());
}

TEST_F(ImportPly, ReadsFacesAndStrips) {
  const auto imported =
      import("t.ply",
             "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
             "element face 2\nproperty list uchar int vertex_indices\nelement tristrips 1\nproperty list int int "
             "vertex_indices\n"
             "end_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n4 1 2 3 0\n");
  ASSERT_TRUE(imported) << imported.error().text();
  EXPECT_EQ(imported->report.kept, 4U);
  EXPECT_TRUE(imported->report.closed());
}

TEST_F(ImportPly, TakesNoFractionForAnIndex) {
  std::string ply = textPly();
  ply.replace(ply.find("uchar int"), 9, "uchar float");
  EXPECT_EQ(import("t.ply", ply)->mesh, tetrahedron());
  ply.replace(ply.find("3 0 2 1"), 7, "3 0.7 2 1");
  const auto imported = import("t.ply", ply);
  ASSERT_TRUE(imported) << imported.error().text();
  EXPECT_EQ(imported->report.droppedOutOfRange, 1U);
}

TEST_F(ImportPly, NamesTheLineOfAFaceThatItsCountsTakeForAVertex) {
  const std::string head = "ply\nformat ascii 1.0\nelement vertex ";
  const std::string rest =
      "\nproperty float x\nproperty float y\nproperty float z\nelement face 4\nproperty list uchar int vertex_indices\n"
      "end_header\n";
  const std::string faces = "4 3 2 1 0\n3 0 1 3\n3 1 2 3\n3 2 0 3\n";
  EXPECT_THAT(refusal("t.ply", head + "5" + rest + "0 0 0\n1 0 0\n0 1 0\n0 0 1\n" + faces),
              HasSubstr("line 14: is a face, where the 5 vertices end"));
  EXPECT_THAT(refusal("t.ply", head + "4" + rest + "0 0\n1 0 0\n0 1 0\n0 0 1\n" + faces),
              HasSubstr("line 14: is a face, where the 4 vertices end"));
}

TEST_F(ImportPly, TakesListsThatAreCountedInFloatsAndWhatFollowsTheLastFace) {
  std::string ply = textPly();
  ply.replace(ply.find("list uchar"), 10, "list float");
  const auto imported = import("t.ply", ply + "made by hand\n");
  ASSERT_TRUE(imported) << imported.error().text();
  EXPECT_EQ(imported->mesh, tetrahedron());
  EXPECT_EQ(imported->report.bytesAtEnd, std::string("\nmade by hand\n").size());
  ply.replace(ply.rfind("\n3 ") + 1, 1, "2.5");
  EXPECT_THAT(refusal("t.ply", ply), HasSubstr("has \"2.5\" as the length of a list"));
}

TEST_F(ImportPly, NamesTheListThatItCannotChoose) {
  std::string ply = textPly();
  ply.replace(ply.find("vertex_indices"), 14, "corners\nproperty list uchar int neighbours");
  EXPECT_THAT(refusal("t.ply", ply),
              HasSubstr("no list \"vertex_indices\"; its properties are \"corners\", \"neighbours\""));
}

TEST_F(ImportPly, RefusesHeadersThatMakeNoMesh) {
  const auto without = [](const std::string& line) {
    std::string ply = textPly();
    return ply.erase(ply.find(line), line.size());
  };
  EXPECT_THAT(refusal("t.ply", without("ply\n")), HasSubstr("does not begin with \"ply\""));
  EXPECT_THAT(refusal("t.ply", without("end_header\n")), HasSubstr("no \"end_header\""));
  EXPECT_THAT(refusal("t.ply", without("property float y\n")), HasSubstr("no property \"y\""));
  EXPECT_THAT(refusal("t.ply", without("element face 4\nproperty list uchar int vertex_indices\n")),
              HasSubstr("point cloud"));
  EXPECT_THAT(refusal("t.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"), HasSubstr("end_header"));
  EXPECT_THAT(refusal("t.ply", "ply\nformat gzip 1.0\nend_header\n"), HasSubstr("\"gzip\""));
  EXPECT_THAT(refusal("t.ply", "ply\nproperty float x\nend_header\n"), HasSubstr("before the first element"));
  EXPECT_THAT(refusal("t.ply", "ply\nelement vertex 3\nproperty quad x\nend_header\n"), HasSubstr("\"quad\""));
  EXPECT_THAT(refusal("t.ply", "ply\nelement face 3\nproperty list half int x\nend_header\n"), HasSubstr("\"half\""));
}

TEST_F(ImportPly, ThatIsDamagedIsRefusedOrReportedButNeverFails) {
  std::mt19937 random(11);
  for (const std::string& good : {textPly(), binaryPly()}) {
    for (int round = 0; round < 200; ++round) {
      std::string bad = good;
      for (int k = 0; k < 2; ++k) bad[random() % bad.size()] = static_cast<char>(random());
      const auto imported = import("t.ply", bad);
      if (imported) {
        EXPECT_TRUE(checkMesh(imported->mesh));
      }
    }
  }
}

}  // namespace
}  // namespace haptics::import_ply_test
