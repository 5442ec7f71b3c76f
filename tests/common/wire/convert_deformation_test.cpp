#include <google/protobuf/text_format.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "common/deform/free_form.h"
#include "common/wire/convert.h"
#include "common/wire/convert_properties.h"

namespace haptics::convert_deformation_test {
namespace {

v1::Deformation message(const std::string& text) {
  v1::Deformation deformation;
  if (!google::protobuf::TextFormat::ParseFromString(text, &deformation)) ADD_FAILURE() << text;
  return deformation;
}

std::string fieldAtFault(const std::string& text) {
  const auto deformation = deformationFrom(message(text));
  return deformation ? "" : deformation.error().field;
}

std::string numbers(int count) {
  std::string text;
  for (int i = 0; i < count; ++i) text += " control_m: 0.01";
  return text;
}

TEST(DeformationOnTheWire, ComesBackAsItWent) {
  DeformationProperties properties;
  properties.softness =
      Softness{.stiffness_N_per_m = 1.0 / 3, .radius_m = 0.01, .degree = 4, .return_s = 0.1, .plastic = 0.75};
  Lattice lattice{{-0.1, 0, 0.3}, {0.1, 0.2, 1.0 / 7}, {2, 3, 4}, {}};
  lattice.control_m = FreeForm::atRest(lattice.low_m, lattice.size_m, lattice.points);
  properties.lattice = lattice;
  properties.residue = Hasher().add(std::uint64_t{7}).finish();
  v1::Deformation wire;
  toWire(properties, wire);
  EXPECT_EQ(announcedDeformationFrom(wire).value(), properties);
}

TEST(DeformationOnTheWire, KeepsWhatIsAbsentAndTakesAwayWhatIsEmpty) {
  DeformationProperties soft{.softness = Softness{.stiffness_N_per_m = 100, .radius_m = 0.01}, .lattice = {}};
  const auto nothing = deformationFrom(message("")).value();
  EXPECT_TRUE(nothing.empty());
  EXPECT_EQ(edited(soft, nothing), soft);
  EXPECT_EQ(edited(soft, deformationFrom(message("softness {}")).value()), DeformationProperties{});
  const auto lattice =
      deformationFrom(message("lattice { points_x: 2 points_y: 2 points_z: 2" + numbers(24) + "}")).value();
  EXPECT_TRUE(lattice.latticeOfMesh);
  EXPECT_EQ(edited(soft, lattice).softness, soft.softness);
  soft.residue = ContentHash{};
  EXPECT_EQ(edited(soft, deformationFrom(message("softness {}")).value()).residue, soft.residue);
  EXPECT_FALSE(edited(soft, deformationFrom(message("residue {}")).value()).residue);
  EXPECT_FALSE(edited(soft, lattice).residue) << "it is of the shape that it was left on";
}

TEST(DeformationOnTheWire, IsRefusedWhereItIsWrongAndSaysWhere) {
  EXPECT_EQ(fieldAtFault("softness { stiffness_N_per_m: 100 }"), "softness.radius_m");
  EXPECT_EQ(fieldAtFault("softness { stiffness_N_per_m: 100 radius_m: nan }"), "softness.radius_m");
  EXPECT_EQ(fieldAtFault("softness { stiffness_N_per_m: -100 radius_m: 0.01 }"), "softness.stiffness_N_per_m");
  EXPECT_EQ(fieldAtFault("softness { stiffness_N_per_m: inf radius_m: 0.01 }"), "softness.stiffness_N_per_m");
  EXPECT_EQ(fieldAtFault("softness { stiffness_N_per_m: 100 radius_m: 0.01 degree: 1 }"), "softness.degree");
  EXPECT_EQ(fieldAtFault("softness { stiffness_N_per_m: 100 radius_m: 0.01 return_s: -1 }"), "softness.return_s");
  EXPECT_EQ(fieldAtFault("softness { stiffness_N_per_m: 100 radius_m: 0.01 plastic: 1.1 }"), "softness.plastic");
  EXPECT_EQ(fieldAtFault("softness { stiffness_N_per_m: 100 radius_m: 0.01 plastic: nan }"), "softness.plastic");
  EXPECT_EQ(fieldAtFault("residue { asset: 'short' }"), "residue.asset");
  EXPECT_EQ(fieldAtFault("lattice { points_x: 1 points_y: 2 points_z: 2 }"), "lattice.points_x");
  EXPECT_EQ(fieldAtFault("lattice { points_x: 2 points_y: 2 points_z: 9 }"), "lattice.points_z");
  EXPECT_EQ(fieldAtFault("lattice { points_x: 2 points_y: 2 points_z: 2" + numbers(23) + "}"), "lattice.control_m");
  EXPECT_EQ(fieldAtFault("lattice { low_m { x: 1 } points_x: 2 points_y: 2 points_z: 2" + numbers(24) + "}"),
            "lattice.low_m");
  EXPECT_EQ(
      fieldAtFault("lattice { low_m {} size_m { x: 1 y: 1 } points_x: 2 points_y: 2 points_z: 2" + numbers(24) + "}"),
      "lattice.size_m.z");
  EXPECT_EQ(fieldAtFault("lattice { points_x: 2 points_y: 2 points_z: 2 control_m: nan" + numbers(23) + "}"),
            "lattice.control_m[0]");
}

TEST(DentsOnTheWire, ComeBackAsTheyWentAndWithoutWhatIsNone) {
  const ObjectDent dent{7, {{0.1F, -0.2F, 1.0F / 3}, {0, 1e-9F, -0.001F}}};
  v1::Telemetry telemetry;
  toWire(dent, *telemetry.add_dent());
  telemetry.add_dent()->add_centre(1);
  toWire({8, {{0, std::numeric_limits<float>::quiet_NaN(), 0}, {}}}, *telemetry.add_dent());
  EXPECT_EQ(dentsFromWire(telemetry), std::vector{dent});
  for (std::size_t i = 0; i < 3 * kMaxDents; ++i) toWire(dent, *telemetry.add_dent());
  EXPECT_EQ(dentsFromWire(telemetry).size(), kMaxDentsOfAll);
}

}  // namespace
}  // namespace haptics::convert_deformation_test
