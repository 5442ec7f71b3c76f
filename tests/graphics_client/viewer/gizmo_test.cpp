#include "graphics_client/viewer/gizmo.h"

#include <gtest/gtest.h>

#include <array>
#include <numbers>

namespace haptics::gizmo_test {
namespace {

using Kind = GizmoHandle::Kind;

constexpr double kPixel = 5e-4;
const Vec3 kCentre{0.03, -0.02, 0.05};
const PicturePoint kSize_px{1000, 800};

/// Looks at the centre from 0.5 m away, z up in the picture.
PictureCamera cameraFrom(Vec3 towards) {
  PictureCamera camera;
  camera.into = -glm::normalize(towards);
  camera.eye = kCentre - camera.into * 0.5;
  camera.right = glm::normalize(glm::cross(camera.into, Vec3(0, 0, 1)));
  camera.up = glm::cross(camera.right, camera.into);
  camera.pixelWidth = kPixel;
  camera.size_px = kSize_px;
  return camera;
}

const std::array kCameras{cameraFrom({0.3, -1, 0.6}), cameraFrom({-1, -0.4, 0.2}), cameraFrom({0.5, 0.6, -0.5})};

Vec3 unit(int axis) {
  Vec3 direction(0);
  direction[axis] = 1;
  return direction;
}

TEST(PictureCamera, ProjectsOntoTheRayThatItCasts) {
  for (const PictureCamera& camera : kCameras) {
    EXPECT_NEAR(glm::distance(*camera.project(kCentre), kSize_px / 2.0), 0, 1e-9);
    const PicturePoint pixel(123, 456);
    EXPECT_NEAR(glm::distance(*camera.project(camera.eye + camera.ray(pixel) * 0.7), pixel), 0, 1e-9);
    EXPECT_NEAR(camera.depth_m(camera.eye + camera.ray(pixel) * 0.7), 0.7, 1e-12);
    EXPECT_FALSE(camera.project(camera.eye - camera.into));
  }
}

TEST(Gizmo, HasItsSizeInThePictureAtEveryDistance) {
  for (const double distance_m : {0.1, 0.5, 3.0}) {
    PictureCamera camera = cameraFrom({0, -1, 0});
    camera.eye = kCentre - camera.into * distance_m;
    const Gizmo gizmo(camera, kCentre);
    const auto tip = camera.project(kCentre + Vec3(0, 0, Gizmo::kArrow_px * gizmo.metresPerPixel()));
    EXPECT_NEAR(glm::distance(*tip, kSize_px / 2.0), Gizmo::kArrow_px, 1e-6);
  }
}

TEST(Gizmo, FindsEveryArrowUnderThePointerAndNothingBeside) {
  for (const PictureCamera& camera : kCameras) {
    const Gizmo gizmo(camera, kCentre);
    for (int axis = 0; axis < 3; ++axis) {
      const GizmoHandle arrow{Kind::kMove, axis};
      if (!gizmo.isShown(arrow)) continue;
      const auto tip = camera.project(kCentre + unit(axis) * (Gizmo::kArrow_px * gizmo.metresPerPixel()));
      EXPECT_EQ(gizmo.handleAt(*tip), arrow);
      const PicturePoint outwards = glm::normalize(*tip - kSize_px / 2.0);
      EXPECT_NE(gizmo.handleAt(*tip + outwards * (Gizmo::kReach_px + 1)), arrow);
    }
    EXPECT_FALSE(gizmo.handleAt(kSize_px / 2.0 + PicturePoint(200, 200)));
    EXPECT_FALSE(gizmo.handleAt({-1e6, 1e6}));
  }
}

TEST(Gizmo, HasTheHandlesThatItIsGiven) {
  const PictureCamera& camera = kCameras[0];
  const Gizmo whole(camera, kCentre), moves(camera, kCentre, {.turns = false}),
      turns(camera, kCentre, {.moves = false});
  const GizmoHandle up{Kind::kMove, 2};
  const auto tip = camera.project(kCentre + unit(2) * (Gizmo::kArrow_px * whole.metresPerPixel()));
  EXPECT_EQ(whole.handleAt(*tip), up);
  EXPECT_EQ(moves.handleAt(*tip), up);
  EXPECT_FALSE(turns.handleAt(*tip));
  const auto rim = camera.project(kCentre + glm::normalize(Vec3(1, 1, 0)) * (Gizmo::kRing_px * whole.metresPerPixel()));
  EXPECT_TRUE(turns.handleAt(*rim));
  EXPECT_FALSE(moves.handleAt(*rim));
}

TEST(Gizmo, FindsEveryRingUnderThePointer) {
  for (const PictureCamera& camera : kCameras) {
    const Gizmo gizmo(camera, kCentre);
    for (int axis = 0; axis < 3; ++axis) {
      int found = 0;
      for (int degrees = 0; degrees < 360; degrees += 5) {
        const Quat turn = glm::angleAxis(degrees * std::numbers::pi / 180, unit(axis));
        const Vec3 spoke = turn * unit((axis + 1) % 3) * (Gizmo::kRing_px * gizmo.metresPerPixel());
        found += gizmo.handleAt(*camera.project(kCentre + spoke)) == GizmoHandle{Kind::kTurn, axis} ? 1 : 0;
      }
      EXPECT_GT(found, 30) << "of 72; the rest is where handles cross";
    }
  }
}

TEST(Gizmo, HidesAnArrowThatPointsAtTheEyeAndAllThatIsBehindIt) {
  const PictureCamera camera = cameraFrom({0.05, -1, 0.05});
  EXPECT_FALSE(Gizmo(camera, kCentre).isShown({Kind::kMove, 1}));
  EXPECT_TRUE(Gizmo(camera, kCentre).isShown({Kind::kMove, 0}));
  EXPECT_TRUE(Gizmo(camera, kCentre).isShown({Kind::kTurn, 1}));
  const Gizmo behind(camera, camera.eye - camera.into);
  EXPECT_FALSE(behind.isShown({Kind::kTurn, 0}));
  EXPECT_FALSE(behind.handleAt(kSize_px / 2.0));
}

class DraggedObject : public testing::Test {
 protected:
  const Pose pose_{glm::normalize(Quat(0.8, 0.1, -0.4, 0.2)), kCentre + Vec3(0.01, 0.02, -0.03)};
};

TEST_F(DraggedObject, StaysUntilThePointerMoves) {
  for (const PictureCamera& camera : kCameras) {
    const Gizmo gizmo(camera, kCentre);
    for (const Kind kind : {Kind::kMove, Kind::kTurn}) {
      const PicturePoint pressed = kSize_px / 2.0 + PicturePoint(40, 30);
      GizmoDrag drag({kind, 2}, gizmo, pose_, camera, pressed);
      const Pose moved = drag.moveTo(camera, pressed);
      EXPECT_NEAR(glm::distance(moved.position, pose_.position), 0, 1e-12);
      EXPECT_NEAR(std::abs(glm::dot(moved.rotation, pose_.rotation)), 1, 1e-12);
    }
  }
}

TEST_F(DraggedObject, FollowsThePointerAlongItsArrow) {
  constexpr double kWay_m = 0.037;
  for (const PictureCamera& camera : kCameras) {
    const Gizmo gizmo(camera, kCentre);
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3 held = kCentre + unit(axis) * 0.02;
      GizmoDrag drag({Kind::kMove, axis}, gizmo, pose_, camera, *camera.project(held));
      const Pose moved = drag.moveTo(camera, *camera.project(held + unit(axis) * kWay_m));
      EXPECT_NEAR(glm::distance(moved.position, pose_.position + unit(axis) * kWay_m), 0, 1e-9);
      EXPECT_EQ(moved.rotation, pose_.rotation);
      EXPECT_NEAR(glm::distance(drag.centre(), kCentre + unit(axis) * kWay_m), 0, 1e-9);
    }
  }
}

TEST_F(DraggedObject, StaysWhereThePointerIsBeyondTheHorizonOfItsArrow) {
  const PictureCamera camera = cameraFrom({0.5, -1, 0.1});
  GizmoDrag drag({Kind::kMove, 1}, Gizmo(camera, kCentre), pose_, camera, kSize_px / 2.0);
  for (int x = -3000; x < 3000; x += 7) {
    const Pose moved = drag.moveTo(camera, kSize_px / 2.0 + PicturePoint(x, 0));
    ASSERT_TRUE(isFinite(moved));
    ASSERT_LE(glm::distance(moved.position, pose_.position), 2 + 1e-9);
  }
}

/// Seen from the front and edge-on, the pointer on the rim turns the object about the gizmo's centre.
TEST_F(DraggedObject, TurnsWithThePointerOnItsRing) {
  constexpr double kTurn = 0.3;
  for (const PictureCamera& camera : {cameraFrom({0.3, -1, 0.6}), cameraFrom({0, -1, 0.1})}) {
    const Gizmo gizmo(camera, kCentre);
    const Vec3 spoke = Vec3(0, -Gizmo::kRing_px * gizmo.metresPerPixel(), 0);
    GizmoDrag drag({Kind::kTurn, 2}, gizmo, pose_, camera, *camera.project(kCentre + spoke));
    Pose turned;
    for (int i = 1; i <= 10; ++i) {
      const Quat turn = glm::angleAxis(kTurn * i / 10, Vec3(0, 0, 1));
      turned = drag.moveTo(camera, *camera.project(kCentre + turn * spoke));
    }
    const Quat turn = turned.rotation * glm::conjugate(pose_.rotation);
    EXPECT_NEAR(glm::angle(turn), kTurn, 0.02);
    EXPECT_NEAR(glm::axis(turn).z, 1, 1e-9);
    EXPECT_NEAR(glm::distance(turned.position, kCentre + turn * (pose_.position - kCentre)), 0, 1e-9);
    EXPECT_EQ(drag.centre(), kCentre);
  }
}

TEST_F(DraggedObject, TurnsAllTheWayRound) {
  const PictureCamera camera = cameraFrom({0.3, -1, 0.6});
  const Gizmo gizmo(camera, kCentre);
  const Vec3 spoke = Vec3(Gizmo::kRing_px * gizmo.metresPerPixel(), 0, 0);
  GizmoDrag drag({Kind::kTurn, 2}, gizmo, pose_, camera, *camera.project(kCentre + spoke));
  for (int degrees = 0; degrees <= 450; degrees += 10) {
    const Quat turn = glm::angleAxis(degrees * std::numbers::pi / 180, Vec3(0, 0, 1));
    const Pose turned = drag.moveTo(camera, *camera.project(kCentre + turn * spoke));
    ASSERT_NEAR(std::abs(glm::dot(turned.rotation, turn * pose_.rotation)), 1, 1e-9) << degrees;
    ASSERT_NEAR(glm::length(turned.rotation), 1, 1e-12);
  }
}

}  // namespace
}  // namespace haptics::gizmo_test
