// Defects of real files: no fall-through away from them. S11 and S12 of the failure scenes.

#include <gtest/gtest.h>

#include <algorithm>

#include "haptic_server/engine/contact/contact.h"
#include "tests/haptic_server/engine/contact/contact_rig.h"

namespace haptics::bad_meshes_test {
namespace {

using shapes::Shape;

constexpr double kTouchable = 2e-7;  // m

/// Presses on every side of a 0.1 m cube and strokes along it, within `reach` of its middle; returns the ticks in which
/// the cube is not felt as it is.
int badTicks(const Shape& shape, double reach) {
  ContactRig world(shape);
  int bad = 0;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double end : {1.0, -1.0}) {
      const auto place = [&](double a, double b, double height) {
        Vec3 p;
        p[axis] = end * (0.05 + height);
        p[(axis + 1) % 3] = a;
        p[(axis + 2) % 3] = b;
        return p;
      };
      const auto check = [&](const ContactResult& r, Vec3 hip) {
        Vec3 expected = hip;
        expected[axis] = end * 0.05;
        const bool good = r.touching && glm::distance(r.ihip, expected) < kTouchable && r.normal[axis] * end > 0.99;
        bad += good ? 0 : 1;
      };
      world.place(place(0.001, 0.002, 0.002));
      check(world.tick(place(0.001, 0.002, -0.003)), place(0.001, 0.002, -0.003));
      Vec3 from = place(0.001, 0.002, -0.003);
      for (const auto& [a, b] : {std::pair(reach, reach), std::pair(-reach, reach * 0.7), std::pair(-reach, -reach),
                                 std::pair(reach * 0.3, -reach), std::pair(0.0, 0.0)}) {
        const Vec3 to = place(a, b, -0.003);
        world.lead(from, to, 0.0013, check);
        from = to;
      }
      for (const double height : {0.0001, 0.002}) {
        const ContactResult r = world.tick(place(0.001, 0.002, height));
        bad += r.touching ? 1 : 0;
      }
    }
  }
  return bad;
}

Shape cube() { return shapes::box({0.1, 0.1, 0.1}, 8); }

TEST(BadMeshes, ACleanCubeHolds) { EXPECT_EQ(badTicks(cube(), 0.045), 0); }

TEST(BadMeshes, AHoleLeavesTheRestSolid) {
  Shape shape = cube();
  // The triangle at a corner of the top.
  const auto corner = std::find_if(shape.triangles.begin(), shape.triangles.end(), [&](const auto& t) {
    return std::any_of(t.begin(), t.end(), [&](std::uint32_t v) { return shape.vertices[v] == Vec3f(0.05F); });
  });
  shape.triangles.erase(corner);
  ASSERT_FALSE(shape.build()->closed());
  EXPECT_EQ(badTicks(shape, 0.035), 0);
}

TEST(BadMeshes, DuplicateFacesHold) {
  Shape shape = cube();
  for (std::size_t t = 0; t < 768; t += 5) shape.triangles.push_back(shape.triangles[t]);
  EXPECT_EQ(badTicks(shape, 0.045), 0);
}

TEST(BadMeshes, CoincidentSheetsRelease) {
  // Tilted, so that feet round to either side of the plane.
  const Quat tilt = glm::angleAxis(0.7, glm::normalize(Vec3(1, 2, 0.5)));
  const Shape once = shapes::sheet(0.1, 5).mapped([&](Vec3 v) { return tilt * v; });
  Shape twice = once;
  twice.add(once);
  ContactRig world(twice);
  for (int i = 0; i < 400; ++i) {
    const double x = 0.0002 * i - 0.04;
    world.place(tilt * Vec3(x, 0.5 * x, 0.001));
    EXPECT_TRUE(world.tick(tilt * Vec3(x, 0.5 * x, -0.001)).touching);
    EXPECT_FALSE(world.tick(tilt * Vec3(x, 0.5 * x, 0.0005)).touching) << i;
    EXPECT_FALSE(world.tick(tilt * Vec3(x, 0.5 * x, 0.001)).touching) << i;
  }
}

TEST(BadMeshes, FlippedFacesHold) {
  Shape shape = cube();
  for (std::size_t t = 0; t < shape.triangles.size(); t += 7) std::swap(shape.triangles[t][0], shape.triangles[t][1]);
  ContactRig world(shape);
  // The flipped faces' own normal points inwards: what holds is their back.
  EXPECT_EQ(badTicks(shape, 0.045), 0);
}

TEST(BadMeshes, FinsLeaveTheRestSolid) {
  Shape shape = cube();
  const auto tip = static_cast<std::uint32_t>(shape.vertices.size());
  shape.vertices.emplace_back(0.07F, 0.07F, 0.07F);
  const auto edge = std::find_if(shape.triangles.begin(), shape.triangles.end(), [&](const auto& t) {
    return shape.vertices[t[0]] == Vec3f(0.05F) || shape.vertices[t[1]] == Vec3f(0.05F);
  });
  shape.triangles.push_back({(*edge)[0], (*edge)[1], tip});
  EXPECT_EQ(badTicks(shape, 0.035), 0);
}

TEST(BadMeshes, UnweldedTrianglesHold) {
  const Shape welded = cube();
  Shape soup;
  for (std::size_t t = 0; t < welded.triangles.size(); ++t) {
    const auto first = static_cast<std::uint32_t>(soup.vertices.size());
    for (const std::uint32_t v : welded.triangles[t]) soup.vertices.push_back(welded.vertices[v]);
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  EXPECT_EQ(badTicks(soup, 0.045), 0);
}

TEST(BadMeshes, TJunctionsHold) {
  // Each side's quads are cut once more on the upper half only.
  Shape shape = cube();
  Shape cut;
  cut.vertices = shape.vertices;
  for (std::size_t t = 0; t < shape.triangles.size(); ++t) {
    const auto& v = shape.triangles[t];
    if (t % 3 != 0) {
      cut.triangles.push_back(v);
      continue;
    }
    const auto middle = static_cast<std::uint32_t>(cut.vertices.size());
    cut.vertices.emplace_back((shape.corner(t, 0) + shape.corner(t, 1)) * 0.5);
    cut.triangles.push_back({v[0], middle, v[2]});
    cut.triangles.push_back({middle, v[1], v[2]});
  }
  ASSERT_FALSE(cut.build()->closed());
  EXPECT_EQ(badTicks(cut, 0.045), 0);
}

TEST(BadMeshes, ZeroAreaFacesHold) {
  // The same cuts, with the joints filled: closed, and every third face has a neighbour without area.
  const Shape shape = cube();
  Shape filled;
  filled.vertices = shape.vertices;
  for (std::size_t t = 0; t < shape.triangles.size(); ++t) {
    const auto& v = shape.triangles[t];
    if (t % 3 != 0) {
      filled.triangles.push_back(v);
      continue;
    }
    const auto middle = static_cast<std::uint32_t>(filled.vertices.size());
    filled.vertices.emplace_back((shape.corner(t, 0) + shape.corner(t, 1)) * 0.5);
    filled.triangles.push_back({v[0], middle, v[2]});
    filled.triangles.push_back({middle, v[1], v[2]});
    filled.triangles.push_back({v[0], v[1], middle});
  }
  ASSERT_TRUE(filled.build()->closed());
  EXPECT_EQ(badTicks(filled, 0.045), 0);
}

TEST(BadMeshes, SliversHold) {  // S12: 20 x 0.001 mm
  // The cube's sides cut into strips of 1 um in the middle of each: mapped from an even grid.
  const Shape shape = shapes::cubeGrid(8).mapped([](Vec3 v) {
    const auto squeeze = [](double x) { return std::abs(x) < 0.3 ? x * 4e-5 : x; };
    return Vec3(squeeze(v.x), squeeze(v.y), v.z) * 0.05;
  });
  EXPECT_EQ(badTicks(shape, 0.045), 0);
}

TEST(BadMeshes, AValleyOfTwoSheetsHolds) {
  for (const double slope : {0.5, 2.0, 6.0}) {
    Shape valley = shapes::sheet(0.1, 5).mapped([&](Vec3 v) { return Vec3(v.x + 0.05, v.y, (v.x + 0.05) * slope); });
    valley.add(shapes::sheet(0.1, 5).mapped([&](Vec3 v) { return Vec3(v.x - 0.05, v.y, (0.05 - v.x) * slope); }));
    ContactRig world(valley);
    for (const double x : {-0.002, 0.0, 0.0011}) {
      const Vec3 bottom{x, 0.0031, -0.004};
      world.place({0, 0.003, 0.03});
      world.lead({0, 0.003, 0.03}, bottom, 0.0013, [](const ContactResult&, Vec3) {});
      world.lead(bottom, bottom + Vec3(0, 0.02, 0), 0.0007, [&](const ContactResult& r, Vec3 hip) {
        EXPECT_TRUE(r.touching);
        EXPECT_NEAR(glm::distance(r.ihip, Vec3(0, hip.y, 0)), 0, 0.0005) << slope << " " << x;
        EXPECT_GE(r.ihip.z, std::abs(r.ihip.x) * slope - kTouchable);
      });
    }
  }
}

TEST(BadMeshes, AcuteCreasesKeepTheContactSide) {  // S12
  // A blade of 1 degree and a gash of 1 degree, stroked along and across.
  for (const double inwards : {1.0, -1.0}) {
    const Shape blade = shapes::box({0.02, 0.1, 0.1}, 4).mapped([&](Vec3 v) {
      return inwards > 0 ? Vec3(v.x * (0.06 - v.z) * 1.6, v.y, v.z)
                         : Vec3(v.x, v.y, v.z - 0.06 * std::max(0.0, 1 - std::abs(v.x) / 0.004));
    });
    ContactRig world(blade);
    for (int i = 0; i < 200; ++i) {
      const double y = 0.0004 * i - 0.04;
      const Vec3 over{0.003 * std::sin(0.3 * i), y, 0.053};
      world.place(over);
      world.lead(over, {-0.5 * over.x, y + 0.003, 0.046}, 0.0011, [&](const ContactResult& r, Vec3) {
        EXPECT_LT(world.depthInside(r.ihip), kTouchable) << inwards << " " << i;
      });
    }
  }
}

}  // namespace
}  // namespace haptics::bad_meshes_test
