#include "common/surface/mapped_field.h"

#include <gtest/gtest.h>

#include <numbers>
#include <string>

#include "common/surface/make_field.h"
#include "field_checks.h"

namespace haptics::mapped_field_test {
namespace {

using namespace fixture;
using std::numbers::pi;
using Shape = Mapping::Shape;

constexpr double kRadius_m = 0.05;
constexpr double kTile_m = 0.02;

std::shared_ptr<const SampledField> randomTile(std::uint32_t width = 16, std::uint32_t height = 12) {
  Random random(5);
  std::vector<float> samples(std::size_t{width} * height);
  for (float& sample : samples) sample = static_cast<float>(random.uniform());
  return std::make_shared<const SampledField>(SampledField::make(width, height, samples).value());
}

/// Eight waves along x, or along y, in a tile of 128 x 128 samples; a crest in its middle.
std::shared_ptr<const SampledField> grating(bool alongY) {
  std::vector<float> samples;
  for (int y = 0; y < 128; ++y) {
    for (int x = 0; x < 128; ++x) {
      samples.push_back(static_cast<float>(std::cos(2 * pi * ((alongY ? y : x) - 63.5) / 16)));
    }
  }
  return std::make_shared<const SampledField>(SampledField::make(128, 128, samples).value());
}

Mapping mapping(Shape shape) {
  const Vec3 size_m = shape == Shape::kCube ? Vec3(0.1, 0.08, 0.06) : Vec3(2 * kRadius_m);
  return {shape, Vec3(0.01, -0.02, 0.03), glm::normalize(Quat(0.9, 0.1, -0.3, 0.2)), size_m, kTile_m};
}

Mapping upright(Shape shape, Vec3 size_m = Vec3(2 * kRadius_m)) {
  return {shape, Vec3(0), Quat(1, 0, 0, 0), size_m, kTile_m};
}

/// From the mapping's frame to the object's.
Vec3 inObject(const Mapping& m, Vec3 local) { return m.centre + m.rotation * local; }

class MappedField : public ::testing::TestWithParam<Shape> {};

TEST_P(MappedField, HasTheGradientOfItsValue) {
  expectTheGradientIsTheDerivative(*makeMappedField(randomTile(), mapping(GetParam())), 0.1, 20'000);
}

TEST_P(MappedField, StaysWithinItsBounds) {
  expectToStayWithinBounds(*makeMappedField(randomTile(), mapping(GetParam())), 0.1);
}

TEST_P(MappedField, JumpsNowhereAlongLongWalks) {
  const auto field = makeMappedField(randomTile(), mapping(GetParam()));
  Random random(3);
  for (int walk = 0; walk < 40; ++walk) {
    expectNoJumpAcross(*field, randomPoint(random, 0.06), randomDirection(random), 0.02);
  }
}

TEST_P(MappedField, IsFiniteAtItsCentreAndFarFromIt) {
  const Mapping m = mapping(GetParam());
  const auto field = makeMappedField(randomTile(), m);
  for (const Vec3 local :
       {Vec3(0), Vec3(0, 0, 1), Vec3(0, 0, -kRadius_m), Vec3(1e-300, 0, 0.01), Vec3(1e6, -1e6, 1e6)}) {
    const FieldSample sample = field->at(inObject(m, local));
    EXPECT_TRUE(std::isfinite(sample.value) && isFinite(sample.gradient));
  }
}

std::string nameOf(const ::testing::TestParamInfo<Shape>& shape) {
  switch (shape.param) {
    case Shape::kPlane:
      return "Plane";
    case Shape::kCube:
      return "Cube";
    case Shape::kCylinder:
      return "Cylinder";
    case Shape::kSphere:
      return "Sphere";
  }
  return {};
}
INSTANTIATE_TEST_SUITE_P(On, MappedField,
                         ::testing::Values(Shape::kPlane, Shape::kCube, Shape::kCylinder, Shape::kSphere), nameOf);

TEST(MappedFieldSeams, AreNoneOnAPlaneFromTileToTile) {
  const Mapping m = mapping(Shape::kPlane);
  const auto field = makeMappedField(randomTile(), m);
  const double height_m = kTile_m * 12 / 16;
  for (int i = -3; i <= 3; ++i) {
    const Vec3 border = inObject(m, {(i + 0.5) * kTile_m, (i + 0.5) * height_m, 0});
    expectNoJumpAcross(*field, border, m.rotation * Vec3(1, 0, 0), 1e-3);
    expectNoJumpAcross(*field, border, m.rotation * Vec3(0, 1, 0), 1e-3);
  }
}

TEST(MappedFieldSeams, AreNoneWhereATurnEndsNorAtAPole) {
  for (const Shape shape : {Shape::kCylinder, Shape::kSphere}) {
    const Mapping m = mapping(shape);
    const auto field = makeMappedField(randomTile(), m);
    for (int i = -3; i <= 3; ++i) {
      const double latitude = 0.3 * i;
      const Vec3 seam = shape == Shape::kSphere ? kRadius_m * Vec3(-std::cos(latitude), 0, std::sin(latitude))
                                                : Vec3(-kRadius_m, 0, 0.01 * i);
      expectNoJumpAcross(*field, inObject(m, seam), m.rotation * Vec3(0, 1, 0), 1e-3);
    }
    // From outside to outside of the part that fades.
    const Vec3 pole = inObject(m, {0, 0, kRadius_m});
    expectNoJumpAcross(*field, pole, m.rotation * Vec3(1, 0, 0), 0.4 * kRadius_m);
    EXPECT_DOUBLE_EQ(field->at(pole).value, randomTile()->mean());
  }
}

TEST(MappedFieldSeams, AreNoneAtEdgesAndCornersOfABox) {
  const Mapping m = mapping(Shape::kCube);
  const auto field = makeMappedField(randomTile(), m);
  for (const Vec3 edge :
       {Vec3(1, 1, 0.3), Vec3(1, -1, -0.5), Vec3(-1, 0.4, 1), Vec3(0.2, -1, -1), Vec3(1, 1, 1), Vec3(-1, -1, 1)}) {
    const Vec3 place = inObject(m, 0.5 * edge * m.size_m);
    for (const Vec3 across : {Vec3(1, -1, 0), Vec3(1, 1, 1), Vec3(0, 1, -1), Vec3(1, 0, 1)}) {
      expectNoJumpAcross(*field, place, m.rotation * glm::normalize(across), 0.01);
      expectNoJumpAcross(*field, place - m.rotation * Vec3(0.001), m.rotation * glm::normalize(across), 0.01);
    }
  }
}

TEST(MappedFieldOnAPlane, RepeatsAGratingAtItsWavelengthWithACrestInTheMiddle) {
  for (const bool alongY : {false, true}) {
    const auto field = makeMappedField(grating(alongY), upright(Shape::kPlane));
    for (double s = -0.05; s < 0.05; s += 0.0007) {
      const double expected = std::cos(2 * pi * s / (kTile_m / 8));
      EXPECT_NEAR(field->at(alongY ? Vec3(0.3, s, 7) : Vec3(s, 0.3, 7)).value, expected, 1e-3);
    }
  }
}

TEST(MappedFieldOnACylinder, HasAWholeNumberOfTilesRoundIt) {
  // The turn is 0.314 m: 15.7 tiles, so 16.
  const auto field = makeMappedField(grating(false), upright(Shape::kCylinder));
  for (double angle = -pi; angle < pi; angle += 0.001) {
    const Vec3 outward(std::cos(angle), std::sin(angle), 0);
    for (const double radius_m : {0.3 * kRadius_m, kRadius_m, 2 * kRadius_m}) {
      EXPECT_NEAR(field->at(radius_m * outward + Vec3(0, 0, 0.2)).value, std::cos(16 * 8 * angle), 1e-3);
    }
  }
}

TEST(MappedFieldOnACylinder, KeepsTilesSquareAlongItsHeight) {
  const auto field = makeMappedField(grating(true), upright(Shape::kCylinder));
  const double tile_m = 2 * pi * kRadius_m / 16;
  for (double z = -0.1; z < 0.1; z += 0.0007) {
    EXPECT_NEAR(field->at({0, kRadius_m, z}).value, std::cos(2 * pi * z / (tile_m / 8)), 1e-3);
  }
}

TEST(MappedFieldOnASphere, FollowsLongitudeAndLatitude) {
  const auto round = makeMappedField(grating(false), upright(Shape::kSphere));
  const auto upwards = makeMappedField(grating(true), upright(Shape::kSphere));
  for (double longitude = -pi; longitude < pi; longitude += 0.01) {
    for (const double latitude : {-1.2, -0.4, 0.0, 1.0}) {
      const Vec3 outward(std::cos(latitude) * std::cos(longitude), std::cos(latitude) * std::sin(longitude),
                         std::sin(latitude));
      for (const double radius_m : {kRadius_m, 1.5 * kRadius_m}) {
        EXPECT_NEAR(round->at(radius_m * outward).value, std::cos(16 * 8 * longitude), 1e-3);
        EXPECT_NEAR(upwards->at(radius_m * outward).value, std::cos(16 * 8 * latitude), 1e-3);
      }
    }
  }
}

TEST(MappedFieldOnABox, LaysTilesUprightAndUnmirroredOnEachFace) {
  const Vec3 size_m(0.1, 0.08, 0.06);
  const auto tile = randomTile();
  const auto onPlane = makeMappedField(tile, upright(Shape::kPlane));
  const auto onBox = makeMappedField(tile, upright(Shape::kCube, size_m));
  struct Face {
    Vec3 outward, right, up;
  };
  for (const Face& face : {Face{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, Face{{-1, 0, 0}, {0, -1, 0}, {0, 0, 1}},
                           Face{{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}}, Face{{0, -1, 0}, {1, 0, 0}, {0, 0, 1}},
                           Face{{0, 0, 1}, {1, 0, 0}, {0, 1, 0}}, Face{{0, 0, -1}, {-1, 0, 0}, {0, 1, 0}}}) {
    EXPECT_EQ(glm::dot(glm::cross(face.right, face.up), face.outward), 1) << "as seen from outside";
    for (const auto& [x_m, y_m] : {std::pair(0.003, 0.004), std::pair(-0.011, 0.007), std::pair(0.013, -0.02)}) {
      const FieldSample flat = onPlane->at({x_m, y_m, 0});
      const FieldSample there = onBox->at(0.5 * size_m * face.outward + x_m * face.right + y_m * face.up);
      EXPECT_NEAR(there.value, flat.value, 1e-12);
      EXPECT_NEAR(glm::length(there.gradient - flat.gradient.x * face.right - flat.gradient.y * face.up), 0, 1e-9);
    }
  }
}

TEST(MakeField, FindsASampledFieldByItsHashAndRefusesOneThatIsNotThere) {
  const auto tile = randomTile();
  const ContentHash hash{{1, 2, 3}};
  const FieldLookup lookup = [&](const ContentHash& wanted) { return wanted == hash ? tile : nullptr; };
  const auto field = makeField(MappedFamily{hash, mapping(Shape::kSphere)}, lookup);
  ASSERT_TRUE(field);
  EXPECT_EQ((*field)->at(Vec3(0.04)).value, makeMappedField(tile, mapping(Shape::kSphere))->at(Vec3(0.04)).value);
  const auto missing = makeField(MappedFamily{ContentHash{{9}}, mapping(Shape::kPlane)}, lookup);
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().field, "field");
}

TEST(MakeField, MakesEachFamilyThatNeedsNoAsset) {
  const FieldLookup none = [](const ContentHash&) { return nullptr; };
  for (const FieldFamily& family :
       {FieldFamily(FourierFamily{{{1, Vec3(1, 0, 0), 0.01, 0}}}), FieldFamily(NoiseFamily{0.01}),
        FieldFamily(CellularFamily{0.01}), FieldFamily(GrainFamily{0.01})}) {
    const auto field = makeField(family, none);
    ASSERT_TRUE(field);
    EXPECT_DOUBLE_EQ((*field)->shortestWavelength_m(), 0.01);
  }
}

}  // namespace
}  // namespace haptics::mapped_field_test
