#include <gtest/gtest.h>

#include <cstddef>
#include <glm/common.hpp>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "file_imports.h"

namespace haptics::scene_trees_test {
namespace {

using SceneTrees = fixture::FileImports;

/// A quarter of a turn about z, or none, after a scale and before a translation.
struct Placing {
  Vec3 translation{0};
  double scale = 1;
  bool isTurned = false;

  [[nodiscard]] Vec3 of(Vec3 at) const {
    at *= scale;
    return translation + (isTurned ? Vec3(-at.y, at.x, at.z) : at);
  }
};

/// A node in both languages, and the low and high corners of each tetrahedron that it shows.
struct Tree {
  std::string x3d, vrml;
  std::vector<std::pair<Vec3, Vec3>> shown = {};
};

/// Scenes as ISO/IEC 14772 and 19775 have them, drawn at random: groups of each kind, with and without children, choices, levels,
/// names that are used again, and nodes that cannot be felt.
class Drawing {
 public:
  explicit Drawing(unsigned seed) : random_(seed) {}

  Tree scene() {
    Tree scene;
    for (int i = 0; i < 4; ++i) append(scene, node(5), true);
    return scene;
  }

 private:
  std::mt19937 random_;
  struct Named {
    std::string name, kind;
    std::vector<std::pair<Vec3, Vec3>> shown;
  };
  std::vector<Named> named_;

  int upTo(int most) { return std::uniform_int_distribution(0, most)(random_); }
  template <std::size_t N>
  std::string oneOf(const char* const (&those)[N]) {
    return those[static_cast<std::size_t>(upTo(N - 1))];
  }

  static void append(Tree& to, const Tree& part, bool isShown) {
    to.x3d += part.x3d;
    to.vrml += part.vrml;
    if (isShown) to.shown.insert(to.shown.end(), part.shown.begin(), part.shown.end());
  }

  Tree node(int levels) {
    const int drawn = upTo(11);
    if (drawn == 0) return unfelt();
    if (drawn == 1 && !named_.empty()) {
      const Named& used = named_[static_cast<std::size_t>(upTo(static_cast<int>(named_.size()) - 1))];
      return {"<" + used.kind + " USE='" + used.name + "'/>", "USE " + used.name + "\n", used.shown};
    }
    return levels == 0 || drawn < 4 ? shape() : group(levels);
  }

  Tree unfelt() {
    const std::string kind =
        oneOf({"Viewpoint", "PointLight", "DirectionalLight", "WorldInfo", "TimeSensor", "TouchSensor",
               "NavigationInfo", "Background", "Fog", "Group", "Transform", "Switch", "LOD", "Shape"});
    return {upTo(1) == 0 ? "<" + kind + "/>" : "<" + kind + "></" + kind + ">", kind + " { }\n"};
  }

  Tree shape() {
    const std::string name = nameFor("Shape", {{{0, 0, 0}, {1, 1, 1}}});
    return {"<Shape" + def(name) +
                "><IndexedFaceSet coordIndex='0 2 1 -1 0 1 3 -1 1 2 3 -1 2 0 3 -1'><Coordinate point='0 0 0 1 0 0 0 1 "
                "0 0 0 1'/>"
                "</IndexedFaceSet></Shape>",
            (name.empty() ? "" : "DEF " + name + " ") +
                "Shape { geometry IndexedFaceSet { coordIndex [ 0 2 1 -1 0 1 3 -1 1 2 3 -1 2 0 3 -1 ] coord Coordinate "
                "{ point [ 0 0 "
                "0 1 0 0 0 1 0 0 0 1 ] } } }\n",
            {{{0, 0, 0}, {1, 1, 1}}}};
  }

  Tree group(int levels) {
    const std::string kind =
        oneOf({"Group", "Transform", "Transform", "Anchor", "Billboard", "Collision", "Switch", "LOD"});
    std::string x3d, vrml;
    Placing placing;
    const int chosen = kind == "LOD" ? 0 : upTo(3) - 1;
    if (kind == "Transform") {
      placing = {Vec3(upTo(6) - 3, upTo(6) - 3, upTo(6) - 3), 1.0 + upTo(1), upTo(1) == 0};
      const auto words = [](const Vec3& v) {
        return std::to_string(v.x) + ' ' + std::to_string(v.y) + ' ' + std::to_string(v.z);
      };
      const std::string translation = words(placing.translation), scale = words(Vec3(placing.scale));
      x3d += " translation='" + translation + "' scale='" + scale + '\'';
      vrml += " translation " + translation + " scale " + scale;
      if (placing.isTurned) x3d += " rotation='0 0 1 1.5707963267948966'";
      if (placing.isTurned) vrml += " rotation 0 0 1 1.5707963267948966";
    }
    if (kind == "Switch") {
      x3d += " whichChoice='" + std::to_string(chosen) + '\'';
      vrml += " whichChoice " + std::to_string(chosen);
    }
    if (kind == "LOD") vrml += " range [ 2 ]";
    Tree inside;
    const int children = upTo(3);
    for (int i = 0; i < children; ++i)
      append(inside, node(levels - 1), (kind != "Switch" && kind != "LOD") || i == chosen);
    for (auto& [low, high] : inside.shown) {
      const Vec3 a = placing.of(low), b = placing.of(high);
      low = glm::min(a, b);
      high = glm::max(a, b);
    }
    const std::string name = nameFor(kind, inside.shown);
    const std::string field = kind == "Switch" ? "choice" : kind == "LOD" ? "level" : "children";
    return {
        "<" + kind + def(name) + x3d + (children == 0 ? "/>" : ">" + inside.x3d + "</" + kind + ">"),
        (name.empty() ? "" : "DEF " + name + " ") + kind + " {" + vrml + " " + field + " [ " + inside.vrml + " ] }\n",
        inside.shown};
  }

  std::string nameFor(const std::string& kind, const std::vector<std::pair<Vec3, Vec3>>& shown) {
    if (upTo(2) > 0) return "";
    named_.push_back({"n" + std::to_string(named_.size()), kind, shown});
    return named_.back().name;
  }
  static std::string def(const std::string& name) { return name.empty() ? "" : " DEF='" + name + "'"; }
};

TEST_F(SceneTrees, OfX3dAndVrmlShowWhatTheyHaveWhereItIs) {
  int shown = 0;
  for (unsigned seed = 0; seed < 60; ++seed) {
    const Tree tree = Drawing(seed).scene();
    if (tree.shown.empty()) continue;
    ++shown;
    Vec3 low = tree.shown[0].first, high = tree.shown[0].second;
    for (const auto& each : tree.shown) low = glm::min(low, each.first), high = glm::max(high, each.second);
    for (const auto& [file, text] :
         {std::pair{"t.x3d", "<X3D version='3.3' profile='Immersive'><Scene>" + tree.x3d + "</Scene></X3D>"},
          {"t.wrl", "#VRML V2.0 utf8\n" + tree.vrml},
          {"t.x3dv", "#X3D V3.3 utf8\nPROFILE Immersive\n" + tree.vrml}}) {
      const auto imported = import(file, text);
      ASSERT_TRUE(imported) << seed << ' ' << imported.error().text() << '\n' << text;
      EXPECT_EQ(imported->report.trianglesInFile, 4 * tree.shown.size()) << text;
      for (int axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(imported->report.boxMin_m[axis], low[axis], 1e-4) << text;
        EXPECT_NEAR(imported->report.boxMax_m[axis], high[axis], 1e-4) << text;
      }
    }
  }
  EXPECT_GT(shown, 40);
}

}  // namespace
}  // namespace haptics::scene_trees_test
