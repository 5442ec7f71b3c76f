#include <nlohmann/json.hpp>
#include <numbers>
#include <utility>
#include <vector>

#include "file_imports.h"

// Files that are made field by field; the judge is the solid in memory, or what the specification makes of it by hand.
namespace haptics::import_gltf_test {
namespace {

using fixture::raw;
using fixture::tetrahedron;
using ::testing::HasSubstr;

using nlohmann::json;

constexpr int kUint8 = 5121, kUint16 = 5123, kFloat32 = 5126;

std::string base64(const std::string& bytes, std::string_view last = "+/") {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789" + std::string(last);
  std::string text;
  std::uint32_t bits = 0;
  int count = 0;
  for (const char c : bytes) {
    bits = bits << 8 | static_cast<unsigned char>(c);
    for (count += 8; count >= 6; count -= 6) text += digits[bits >> (count - 6) & 63];
  }
  if (count > 0) text += digits[bits << (6 - count) & 63];
  return text;
}

/// The tetrahedron, and what a test adds.
struct File {
  json root = {{"asset", {{"version", "2.0"}}},
               {"scene", 0},
               {"scenes", {{{"nodes", {0}}}}},
               {"nodes", {{{"mesh", 0}}}},
               {"meshes", {{{"primitives", {{{"attributes", {{"POSITION", 0}}}, {"indices", 1}}}}}}},
               {"accessors", json::array()},
               {"bufferViews", json::array()}};
  std::string bytes;

  File() {
    add<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}, kFloat32, "VEC3", 4);
    add<std::uint16_t>({0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3}, kUint16, "SCALAR", 12);
  }
  /// The number of its accessor.
  template <class T>
  int add(const std::vector<T>& values, int type, const char* shape, int count) {
    std::string own;
    for (const T value : values) own += raw(value);
    root["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", own.size()}});
    bytes += own;
    bytes.resize((bytes.size() + 3) / 4 * 4, '\0');
    root["accessors"].push_back(
        {{"bufferView", root["bufferViews"].size() - 1}, {"componentType", type}, {"type", shape}, {"count", count}});
    return static_cast<int>(root["accessors"].size()) - 1;
  }
  [[nodiscard]] std::string text(std::string_view last = "+/") const {
    json whole = root;
    if (!whole.contains("buffers")) {
      whole["buffers"] = {
          {{"byteLength", bytes.size()}, {"uri", "data:application/octet-stream;base64," + base64(bytes, last)}}};
    }
    return whole.dump();
  }
};

class ImportGltf : public fixture::FileImports {
 protected:
  void expectPoints(const File& file, std::vector<Vec3> points) const {
    const auto imported = import("t.gltf", file.text());
    ASSERT_TRUE(imported) << imported.error().text();
    EXPECT_EQ(imported->mesh.triangles.size(), 4U);
    EXPECT_EQ(imported->report.leftOut.skins + imported->report.leftOut.morphs, 0U);
    ASSERT_EQ(imported->mesh.vertices.size(), points.size());
    for (const Vec3& point : points) {
      double nearest = 1;
      for (const Vec3f& vertex : imported->mesh.vertices)
        nearest = std::min(nearest, glm::distance(Vec3(vertex), point));
      EXPECT_LT(nearest, 1e-6) << point.x << ' ' << point.y << ' ' << point.z;
    }
  }
};

/// Two joints: one 2 m along x, one turned by 90 degrees about z at the origin; both bound at (0, 1, 0).
File skinned() {
  File file;
  json& primitive = file.root["meshes"][0]["primitives"][0];
  primitive["attributes"]["JOINTS_0"] =
      file.add<std::uint8_t>({0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0}, kUint8, "VEC4", 4);
  primitive["attributes"]["WEIGHTS_0"] =
      file.add<float>({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0.25, 0.75, 0, 0}, kFloat32, "VEC4", 4);
  std::vector<float> bound;
  for (int joint = 0; joint < 2; ++joint) {
    for (const float x : {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -1, 0, 1}) bound.push_back(x);
  }
  const double half = std::numbers::sqrt2 / 2;
  file.root["skins"] = {{{"joints", {1, 3}}, {"inverseBindMatrices", file.add(bound, kFloat32, "MAT4", 2)}}};
  file.root["nodes"] = {{{"mesh", 0}, {"skin", 0}, {"translation", {100, 100, 100}}},
                        {{"translation", {2, 0, 0}}},
                        {{"translation", {0, 0, 3}}, {"children", {3}}},
                        {{"rotation", {0, 0, half, half}}}};
  file.root["scenes"][0]["nodes"] = {0, 1, 2};
  return file;
}

TEST_F(ImportGltf, PosesSkinsAsTheNodesPlaceTheJoints) {
  // Joint 0: p + (2, -1, 0). Joint 1: (x, y - 1, z) turned to (1 - y, x, z), and 3 m along z.
  expectPoints(skinned(), {{2, -1, 0}, {1, 1, 3}, {2, 0, 0}, 0.25 * Vec3(2, -1, 1) + 0.75 * Vec3(1, 0, 4)});
  File missing = skinned();
  missing.root["skins"][0]["joints"] = {1};
  EXPECT_THAT(refusal("t.gltf", missing.text()), HasSubstr("accessors[2] names joint 1, from 0, of 1"));
  missing.root["skins"][0]["joints"] = {1, 9};
  EXPECT_THAT(refusal("t.gltf", missing.text()), HasSubstr("skins[0].joints has 9, which is no node"));
}

TEST_F(ImportGltf, MovesTargetsByTheirWeights) {
  File file;
  const int target = file.add<float>({0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2}, kFloat32, "VEC3", 4);
  file.root["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", target}}};
  file.root["meshes"][0]["weights"] = {0.5};
  expectPoints(file, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 2}});
  file.root["nodes"][0] = {{"mesh", 0}, {"weights", {1}}, {"translation", {1, 0, 0}}};
  expectPoints(file, {{1, 0, 0}, {2, 0, 0}, {1, 1, 0}, {1, 0, 3}});
  file.root["nodes"][0]["weights"] = {0};
  const auto imported = import("t.gltf", file.text());
  EXPECT_EQ(imported->mesh.vertices.size(), 4U);
  EXPECT_EQ(imported->report.leftOut.morphs, 1U);
}

TEST_F(ImportGltf, ReadsWhatOthersWriteALittleOtherwise) {
  std::vector<File> files(6);
  files[0].root.erase("scene");
  files[1].root.erase("scenes"), files[1].root.erase("scene"), files[1].root.erase("nodes");
  files[2].root["accessors"][0]["count"] = 4.0;
  files[3].root["asset"]["version"] = 2.0;
  files[4].root["nodes"][0]["rotation"] = {0, 0, 0, 3};  // of another length
  files[5].root["meshes"][0]["primitives"][0]["material"] = nullptr, files[5].root["nodes"][0]["name"] = 7;
  for (const File& file : files) {
    const auto imported = import("t.gltf", file.text());
    ASSERT_TRUE(imported) << file.text() << imported.error().text();
    EXPECT_EQ(imported->mesh, tetrahedron()) << file.text();
  }
  File early;
  early.root["meshes"] = {{"mesh", early.root["meshes"][0]}}, early.root["asset"]["version"] = 0.8;
  EXPECT_THAT(refusal("t.gltf", early.text()),
              ::testing::HasSubstr("is glTF of version 0.8 (asset.version); \"2.0\" and"));
  for (const nlohmann::json& version : {nlohmann::json("1.0"), nlohmann::json(1)}) {
    early.root["asset"]["version"] = version;
    EXPECT_THAT(refusal("t.gltf", early.text()), ::testing::Not(::testing::HasSubstr("is glTF of version"))) << version;
  }
  File url;  // by the letters of RFC 4648, section 5
  for (int i = 0; i < 4; ++i) url.bytes[static_cast<std::size_t>(i)] = raw(-1.25e-5F)[static_cast<std::size_t>(i)];
  ASSERT_NE(url.text(), url.text("-_"));
  EXPECT_EQ(import("t.gltf", url.text("-_"))->mesh, import("t.gltf", url.text())->mesh);
}

TEST_F(ImportGltf, FindsTheBufferOfABinaryFileBehindOtherChunks) {
  File file;
  file.root["buffers"] = {{{"byteLength", file.bytes.size()}}};
  std::string text = file.text();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  const auto chunk = [](const std::string& bytes, const char* type) {
    return raw(static_cast<std::uint32_t>(bytes.size())) + std::string(type, 4) + bytes;
  };
  const std::string chunks = chunk(text, "JSON") + chunk("abcd", "MORE") + chunk(file.bytes, "BIN\0") + "end";
  const std::string head = "glTF" + raw(std::uint32_t{2}) + raw(static_cast<std::uint32_t>(12 + chunks.size()));
  const auto imported = import("t.glb", head + chunks);
  ASSERT_TRUE(imported) << imported.error().text();
  EXPECT_EQ(imported->mesh, tetrahedron());
  EXPECT_THAT(refusal("t.glb", head + chunk(file.bytes, "BIN\0") + chunk(text, "JSON")),
              HasSubstr("whose first chunk is not \"JSON\""));
}

TEST_F(ImportGltf, CountsATriangleThatIsNotComplete) {
  File file;
  file.root["accessors"][1]["count"] = 11;
  EXPECT_EQ(import("t.gltf", file.text())->report.droppedOutOfRange, 1U);
}

TEST_F(ImportGltf, ReadsSparseAccessors) {
  for (const bool isQuantized : {false, true}) {
    File file;
    if (isQuantized) {
      const int points = file.add<std::uint8_t>({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}, kUint8, "VEC3", 4);
      file.root["accessors"][0] = file.root["accessors"][static_cast<std::size_t>(points)];
    }
    const int at = file.add<std::uint16_t>({3}, kUint16, "SCALAR", 1);
    const int to = isQuantized ? file.add<std::uint8_t>({0, 0, 2}, kUint8, "VEC3", 1)
                               : file.add<float>({0, 0, 2}, kFloat32, "VEC3", 1);
    const auto viewOf = [&](int accessor) {
      return file.root["accessors"][static_cast<std::size_t>(accessor)]["bufferView"];
    };
    file.root["accessors"][0]["sparse"] = {{"count", 1},
                                           {"indices", {{"bufferView", viewOf(at)}, {"componentType", kUint16}}},
                                           {"values", {{"bufferView", viewOf(to)}}}};
    expectPoints(file, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 2}});
    file.bytes[file.root["bufferViews"][viewOf(at).get<std::size_t>()]["byteOffset"].get<std::size_t>()] = 9;
    EXPECT_THAT(refusal("t.gltf", file.text()),
                HasSubstr("accessors[0].sparse.indices has a number that is none of its 4 values"));
  }
}

TEST_F(ImportGltf, NamesTheFieldThatIsNotAsItShouldBe) {
  const std::vector<std::tuple<const char*, json, const char*>> changes{
      {"/asset/version", "3.0", "asset.version is \"3.0\"; it is \"2.0\""},
      {"/asset/version", nullptr, "asset.version is missing"},
      {"/asset/minVersion", "2.1", "asset.minVersion is \"2.1\""},
      {"/scene", 5, "scene is 5; it is the number of one of the 1 scenes, from 0"},
      {"/scene", "a", "scene is \"a\""},
      {"/scenes/0/nodes", {7}, "scenes[0].nodes is 7; it is the number of one of the 1 nodes"},
      {"/nodes", nullptr, "scenes[0].nodes is 0; it is the number of one of the 0 nodes"},
      {"/nodes", {{"a", 1}}, "nodes is {\"a\":1}; it is a list"},
      {"/nodes/0/mesh", 9, "nodes[0].mesh is 9; it is the number of one of the 1 meshes"},
      {"/nodes/0/matrix", {1, 0, 0, 0}, "nodes[0].matrix is [1,0,0,0]; it is 16 numbers"},
      {"/nodes/0/translation", {1, 2}, "nodes[0].translation is [1,2]; it is 3 numbers"},
      {"/nodes/0/rotation", {0, 0, 0, 0}, "nodes[0].rotation is [0,0,0,0]; it is a quaternion of length 1"},
      {"/meshes", json::array(), "has no meshes"},
      {"/meshes/0/primitives", "x", "meshes[0].primitives is \"x\"; it is a list"},
      {"/meshes/0/primitives/0/attributes", "x", "meshes[0].primitives[0].attributes is \"x\""},
      {"/meshes/0/primitives/0/attributes/POSITION", 9,
       "attributes.POSITION is 9; it is the number of one of the 2 accessors"},
      {"/meshes/0/primitives/0/mode", 9, "meshes[0].primitives[0].mode is 9; it is a whole number from 0 to 6"},
      {"/meshes/0/primitives/0/indices", 9, "meshes[0].primitives[0].indices is 9"},
      {"/accessors/0/componentType", "FLOAT", "accessors[0].componentType is \"FLOAT\""},
      {"/accessors/0/componentType", 5130, "accessors[0].componentType is 5130; it is 5126 (float32) for positions"},
      {"/accessors/1/componentType", 5124, "accessors[1].componentType is 5124; it is 5121, 5123 or 5125 for indices"},
      {"/accessors/0/count", -4, "accessors[0].count is -4; it is a whole number from 0"},
      {"/accessors/0/type", "VEC2", "accessors[0].type is \"VEC2\"; it is \"VEC3\""},
      {"/accessors/1/bufferView", 9, "accessors[1].bufferView is 9; it is the number of one of the 2 bufferViews"},
      {"/bufferViews/0/byteStride", 4, "bufferViews[0].byteStride is 4; it is 12 or more"},
      {"/bufferViews/1/buffer", 9, "bufferViews[1].buffer is 9; it is the number of one of the 1 buffers"},
      {"/buffers/0/byteLength", 100, "buffers[0].byteLength is 100; its uri holds 72 bytes"},
      {"/buffers/0/uri", nullptr, "buffers[0].uri is missing; it is the name of a file"},
      {"/buffers/0/uri", "data:application/octet-stream;base64,@@", "buffers[0].uri is not base64"},
      {"/buffers/0",
       {{"byteLength", 72}, {"extensions", {{"EXT_meshopt_compression", json::object()}}}},
       "buffers[0] is packed by EXT_meshopt_compression"}};
  for (const auto& [place, value, reason] : changes) {
    File file;
    file.root = json::parse(file.text());
    const json::json_pointer at{std::string(place)};
    if (value.is_null()) {
      file.root[at.parent_pointer()].erase(at.back());
    } else {
      file.root[at] = value;
    }
    EXPECT_THAT(refusal("t.gltf", file.text()), HasSubstr(reason)) << place;
  }
  std::string cut = File().text();
  EXPECT_THAT(refusal("t.gltf", "{\n\"a\": 1,\n" + cut), HasSubstr("its JSON is cut off or damaged in line 3"));
  EXPECT_THAT(refusal("t.gltf", "{\n\"a\": \"M\xfc\"}"), HasSubstr("its JSON is not in UTF-8 in line 2"));
}

}  // namespace
}  // namespace haptics::import_gltf_test
