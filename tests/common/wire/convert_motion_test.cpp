#include <google/protobuf/text_format.h>
#include <gtest/gtest.h>

#include <set>
#include <string>
#include <variant>

#include "common/wire/convert.h"
#include "common/wire/convert_properties.h"

namespace haptics::convert_motion_test {
namespace {

v1::Motion message(const std::string& text) {
  v1::Motion motion;
  if (!google::protobuf::TextFormat::ParseFromString(text, &motion)) ADD_FAILURE() << text;
  return motion;
}

std::string fieldAtFault(const std::string& text) {
  const auto motion = motionFrom(message(text));
  return motion ? "" : motion.error().field;
}

TEST(MotionOnTheWire, ComesBackAsItWent) {
  MotionProperties door{.mass_kg = 1.0 / 3,
                        .inertia = GivenInertia{{0.1, 0.2, 0.3}, {0.01, 0.02, 0.025}, {0.001, -0.002, 0.003}},
                        .gravity_m_per_s2 = {0, 0.1, -1.62},
                        .linearDamping_per_s = 0.5,
                        .angularDamping_per_s = 0.25,
                        .spring = {100, 1, 0.5, 0.01},
                        .joint = JointProperties{JointProperties::Kind::kHinge, {0.1, 0, 0}, {0, 0, 1}, -0.5, 1.5}};
  v1::Motion wire;
  toWire(door, wire);
  EXPECT_EQ(announcedMotionFrom(wire).value(), door);
  MotionProperties brick{.mass_kg = 0.2, .planes = {{{0, 0, 1}, 0.01, 0.3, 1e-3}, {{-1, 0, 0}, -0.2}}};
  toWire(brick, wire);
  EXPECT_EQ(announcedMotionFrom(wire).value(), brick);
  brick.collision = CollisionProperties{0.7, 1e-3};
  toWire(brick, wire);
  EXPECT_EQ(announcedMotionFrom(wire).value(), brick);
  const MotionProperties ground{.gravity_m_per_s2 = Vec3(0), .fixed = true, .collision = CollisionProperties{}};
  toWire(ground, wire);
  EXPECT_EQ(announcedMotionFrom(wire).value(), ground);
  EXPECT_EQ(motionFrom(message("fixed: true collision {}")).value(), ground);
  const MotionProperties tool{.gravity_m_per_s2 = Vec3(0), .tool = ToolProperties{0.002, 0.5}};
  toWire(tool, wire);
  EXPECT_EQ(announcedMotionFrom(wire).value(), tool);
  EXPECT_EQ(motionFrom(message("tool { spacing_m: 0.002 torsion_Nm_per_rad: 0.5 }")).value(), tool);
  const MotionProperties jaws{
      .gravity_m_per_s2 = Vec3(0),
      .tool = ToolProperties{0.002, 1, JawProperties{{0.1, 0, 0}, {0, -1, 0}, {1, 0, 0}, 0.25}}};
  toWire(jaws, wire);
  EXPECT_EQ(announcedMotionFrom(wire).value(), jaws);
  EXPECT_EQ(motionFrom(message("tool { spacing_m: 0.002 jaws { hinge_m { x: 0.1 } axis { y: -1.00001 } reach { x: 1 } "
                               "grip_Nm_per_rad: 0.25 } }"))
                .value(),
            jaws);
}

TEST(MotionOnTheWire, HasAHashOfItsOwnForEachThatDiffers) {
  std::set<std::string> hashes;
  for (const MotionProperties& motion :
       {MotionProperties{.mass_kg = 1}, MotionProperties{.mass_kg = 1, .collision = CollisionProperties{}},
        MotionProperties{.mass_kg = 1, .collision = CollisionProperties{0.6}},
        MotionProperties{.mass_kg = 1, .collision = CollisionProperties{0.5, 1e-3}},
        MotionProperties{.fixed = true, .collision = CollisionProperties{}},
        MotionProperties{.tool = ToolProperties{0.002}}, MotionProperties{.tool = ToolProperties{0.003}},
        MotionProperties{.tool = ToolProperties{0.002, 2}},
        MotionProperties{.tool = ToolProperties{0.002, 1, JawProperties{}}},
        MotionProperties{.tool = ToolProperties{0.002, 1, JawProperties{{1, 0, 0}}}},
        MotionProperties{.tool = ToolProperties{0.002, 1, JawProperties{{}, {0, -1, 0}}}},
        MotionProperties{.tool = ToolProperties{0.002, 1, JawProperties{{}, {0, 1, 0}, {0, 0, 1}}}},
        MotionProperties{.tool = ToolProperties{0.002, 1, JawProperties{{}, {0, 1, 0}, {1, 0, 0}, 1}}}}) {
    Hasher hasher;
    addTo(hasher, motion);
    hashes.insert(hasher.finish().hex());
  }
  EXPECT_EQ(hashes.size(), 13U);
}

TEST(MotionOnTheWire, NeedsOnlyAMass) {
  const MotionProperties motion = motionFrom(message("mass_kg: 0.5")).value();
  EXPECT_EQ(motion, MotionProperties{.mass_kg = 0.5});
}

TEST(MotionOnTheWire, IsRefusedWhereItIsWrongAndSaysWhere) {
  EXPECT_EQ(fieldAtFault(""), "mass_kg");
  EXPECT_EQ(fieldAtFault("mass_kg: -1"), "mass_kg");
  EXPECT_EQ(fieldAtFault("mass_kg: nan"), "mass_kg");
  EXPECT_EQ(fieldAtFault("mass_kg: 1 inertia { moments { x: 1 y: 0 z: 1 } }"), "inertia.moments.y");
  EXPECT_EQ(fieldAtFault("mass_kg: 1 hinge { anchor_m { x: 1 } }"), "hinge.axis");
  EXPECT_EQ(fieldAtFault("mass_kg: 1 slider { axis { x: 2 } }"), "slider.axis");
  EXPECT_EQ(fieldAtFault("mass_kg: 1 hinge { axis { x: 1 } lowest: 0.1 }"), "hinge.lowest");
  EXPECT_EQ(fieldAtFault("mass_kg: 1 hinge { axis { x: 1 } } planes { normal { z: 1 } }"), "planes");
  EXPECT_EQ(fieldAtFault("mass_kg: 1 planes { normal { z: 1 } friction: -1 }"), "planes[0].friction");
  EXPECT_EQ(fieldAtFault("mass_kg: 1 spring { stiffness_N_per_m: inf }"), "spring.stiffness_N_per_m");
  EXPECT_EQ(fieldAtFault("mass_kg: 1 gravity_m_per_s2 { z: -1e9 }"), "gravity_m_per_s2.z");
  EXPECT_EQ(fieldAtFault("mass_kg: 1 collision { friction: 11 }"), "collision.friction");
  EXPECT_EQ(fieldAtFault("mass_kg: 1 collision { rolling_m: nan }"), "collision.rolling_m");
  EXPECT_EQ(fieldAtFault("fixed: true"), "collision");
  EXPECT_EQ(fieldAtFault("fixed: true collision {} mass_kg: 1"), "fixed");
  EXPECT_EQ(fieldAtFault("tool {}"), "tool.spacing_m");
  EXPECT_EQ(fieldAtFault("tool { spacing_m: nan }"), "tool.spacing_m");
  EXPECT_EQ(fieldAtFault("tool { spacing_m: 0.01 torsion_Nm_per_rad: 0 }"), "tool.torsion_Nm_per_rad");
  EXPECT_EQ(fieldAtFault("tool { spacing_m: 0.01 } mass_kg: 1"), "tool");
  EXPECT_EQ(fieldAtFault("tool { spacing_m: 0.01 jaws {} }"), "tool.jaws.axis");
  EXPECT_EQ(fieldAtFault("tool { spacing_m: 0.01 jaws { axis { y: 1 } reach { x: 2 } } }"), "tool.jaws.reach");
  EXPECT_EQ(fieldAtFault("tool { spacing_m: 0.01 jaws { axis { y: 1 } reach { y: 1 } } }"), "tool.jaws.reach");
  EXPECT_EQ(fieldAtFault("tool { spacing_m: 0.01 jaws { axis { y: 1 } reach { x: 1 } hinge_m { x: nan } } }"),
            "tool.jaws.hinge_m.x");
  EXPECT_EQ(fieldAtFault("tool { spacing_m: 0.01 jaws { axis { y: 1 } reach { x: 1 } grip_Nm_per_rad: 0 } }"),
            "tool.jaws.grip_Nm_per_rad");
}

Result<Transaction> transaction(const std::string& text) { return fromWire(parseSceneText(text, "test").value()); }

TEST(MotionOnTheWire, IsSetAddedAndTakenAwayByATransaction) {
  const auto edit = transaction(R"(
      operations { add { name: "a" mesh { box { size_m { x: 1 y: 1 z: 1 } } } motion { mass_kg: 2 } } }
      operations { set_motion { object { name: "a" } motion { mass_kg: 3 } } }
      operations { set_motion { object { id: 7 } motion {} } }
      operations { set_motion { object { id: 7 } } })");
  ASSERT_TRUE(edit) << edit.error().text();
  EXPECT_EQ(std::get<AddObject>(edit->operations[0]).motion->mass_kg, 2);
  EXPECT_EQ(std::get<SetMotion>(edit->operations[1]).motion->mass_kg, 3);
  EXPECT_FALSE(std::get<SetMotion>(edit->operations[2]).motion);
  EXPECT_FALSE(std::get<SetMotion>(edit->operations[3]).motion);
}

TEST(MotionOnTheWire, OfATransactionIsRefusedWithItsWholePath) {
  const auto field = [](const std::string& text) { return transaction(text).error().field; };
  EXPECT_EQ(field("operations { set_motion { object { id: 7 } motion { mass_kg: -3 } } }"),
            "operations[0].set_motion.motion.mass_kg");
  EXPECT_EQ(field(R"(operations { add { name: "a" mesh { box { size_m { x: 1 y: 1 z: 1 } } }
                      motion { mass_kg: 1 slider {} } } })"),
            "operations[0].add.motion.slider.axis");
  EXPECT_EQ(field("operations { set_motion { motion { mass_kg: 3 } } }"), "operations[0].set_motion.object");
}

}  // namespace
}  // namespace haptics::convert_motion_test
