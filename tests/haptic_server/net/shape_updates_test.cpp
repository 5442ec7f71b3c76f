#include "haptic_server/net/shape_updates.h"

#include <gtest/gtest.h>

#include <optional>

#include "common/wire/driven_shapes.h"

namespace haptics::shape_updates_test {
namespace {

constexpr ObjectId kObject = 7;
constexpr std::uint64_t kNow_ns = 1'000'000'000;

/// Of a cube of 2 m, all points by `shift_m` along z from where they do nothing.
[[nodiscard]] Lattice lattice(float shift_m) {
  Lattice lattice{.low_m = Vec3(-1), .size_m = Vec3(2), .points = {2, 2, 2}, .control_m = {}};
  for (int i = 0; i < 8; ++i)
    lattice.control_m.emplace_back(i % 2 * 2 - 1, i / 2 % 2 * 2 - 1, float(i / 4 * 2 - 1) + shift_m);
  return lattice;
}

[[nodiscard]] std::shared_ptr<const DrivenShape::Sample> sample(std::optional<Lattice> of) {
  return std::make_shared<const DrivenShape::Sample>(DrivenShape::Sample{std::move(of), nullptr});
}

class ShapeUpdatesTest : public ::testing::Test {
 protected:
  /// What a client hears where the servo is so far on its way.
  [[nodiscard]] std::vector<ShapeState> heard(double at, std::uint64_t now_ns = kNow_ns) {
    ShapePlaces places;
    places.place[places.count++] = {kObject, at};
    v1::Telemetry message;
    updates.add(places, shapes, now_ns, message);
    return shapesFromWire(message);
  }

  SceneService::DrivenShapes shapes{
      {kObject, {.number = 6, .samples = {sample({}), sample(lattice(0.5)), sample(lattice(1))}}}};
  ShapeUpdates updates;
};

TEST_F(ShapeUpdatesTest, TellWhereTheControlPointsAreBetweenTheSamples) {
  EXPECT_EQ(heard(6).at(0).lattice, lattice(1));
  EXPECT_EQ(heard(5.5).at(0).lattice, lattice(0.75));
  EXPECT_EQ(heard(4.5).at(0).lattice, lattice(0.25)) << "from where it does nothing";
  EXPECT_FALSE(heard(4).at(0).lattice) << "as the scene has it";
  EXPECT_FALSE(heard(2).at(0).lattice) << "the servo is behind all of the samples";
  shapes.at(kObject).samples[1] =
      sample(Lattice{.low_m = Vec3(-2), .size_m = Vec3(4), .points = {2, 2, 2}, .control_m = {}});
  EXPECT_EQ(heard(5.75).at(0).lattice, lattice(1)) << "the nearer of two that cannot be mixed";
}

TEST_F(ShapeUpdatesTest, TellWhatIsNewsAndAllOfItNowAndThen) {
  EXPECT_EQ(heard(6).size(), 1U);
  EXPECT_EQ(heard(6).size(), 0U);
  EXPECT_EQ(heard(6, kNow_ns + ShapeUpdates::kEvery_ns).size(), 1U);
  EXPECT_EQ(heard(5.9, kNow_ns + ShapeUpdates::kEvery_ns).size(), 1U);
  shapes.clear();
  EXPECT_EQ(heard(6).size(), 0U);
}

}  // namespace
}  // namespace haptics::shape_updates_test
