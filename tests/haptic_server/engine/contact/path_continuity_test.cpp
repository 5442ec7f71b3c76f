// Where several bodies hold the IHIP and release it, it takes the path of a slow hand's over their surfaces, and stops only
// where nothing beside it is nearer to the HIP.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "haptic_server/engine/contact/contact.h"
#include "tests/haptic_server/engine/contact/contact_rig.h"

namespace haptics::path_continuity_test {
namespace {

constexpr double kSame = 2e-6;           // m: a few skins, along triangles that are nearly flat
constexpr double kSupportMargin = 3e-7;  // m

/// A moment of a random walk about five bodies, and where a reference proxy that divides the tick by 64 and knows
/// triangles only has its IHIP at the end of the tick. World, metres.
struct Moment {
  const char* name;
  friend std::ostream& operator<<(std::ostream& out, const Moment& moment) { return out << moment.name; }
  ContactState::Mode mode;
  Feature feature;
  std::vector<ContactSurface> holding;
  Vec3 local, hip, ihip;  // at the start
  Vec3 nextHip, nextIhip;
};

using Mode = ContactState::Mode;
const std::vector<Moment> kMoments{
    {"OnTheSeamOverACreaseOfIt",
     Mode::kSeveralSurfaces,
     Feature::kPolygon,
     {{2, 1, 2038}, {3, 1, 853}},
     Vec3(0),
     {0.025421261056465149, 0.0039567585587986578, 0.0044788886644855563},
     {0.02928723900760849, 0.0013248060107967806, 0.0024165648169638763},
     {0.025248507958275036, 0.0038738560193943409, 0.0044271522686856087},
     {0.026879362789020134, 0.00098902139592319145, 0.0016461979547377282}},
    {"HeldInAPointWhereASaddleMeetsAnother",
     Mode::kSeveralSurfaces,
     Feature::kPolygon,
     {{2, 1, 2717}, {2, 1, 2716}, {1, 1, 1195}},
     Vec3(0),
     {0.011466253864339549, -0.01515216445370967, 0.012675197713133829},
     {0.0016957788638490351, 0.033408394891113531, 0.0061724946651376313},
     {0.011486160534641597, -0.015180973534615914, 0.0126713771670701},
     {0.0016957564952511384, 0.033408293567134983, 0.0061725055749586527}},
    {"ASkinFromTheEndOfATriangle",
     Mode::kSeveralSurfaces,
     Feature::kPolygon,
     {{0, 1, 1166}, {1, 1, 1880}},
     Vec3(0),
     {-0.021341808045619526, -0.0050234447291882126, 0.012705585778745854},
     {-0.020570223488288474, -0.010396717812301823, -0.00247480678293234},
     {-0.021338944160536527, -0.0050455969033802676, 0.012709469295376882},
     {-0.019476525630680429, -0.010903969907220668, -0.0021384451026043522}},
    {"PastTheVertexOfASaddleBesideAnother",
     Mode::kOneSurface,
     Feature::kLine,
     {{2, 1, 1859}},
     {0.021286188727617898, -0.010961349185225962, -0.0017556226493785512},
     {0.02626851454105587, 0.013645772193005523, 0.024539054461979345},
     {0.012697809684531224, -0.0013438657595492114, 0.0077368208464914986},
     {0.0267409886072669, 0.012825283406552576, 0.024302762618540197},
     {0.013366256019133757, -0.0027850929546122507, 0.0089121031602767894}},
    {"InAValleyAheadOfManyRisingTriangles",
     Mode::kSeveralSurfaces,
     Feature::kPolygon,
     {{2, 1, 1137}, {3, 1, 1145}},
     Vec3(0),
     {0.0081709884784954643, 0.032076413658692453, 0.020739989944675439},
     {0.0033563206886641568, 0.038054798739202818, 0.024507737582800282},
     {0.0087285546527540586, 0.032435173721226861, 0.019880733817392405},
     {0.0042270746938604699, 0.038707378739506172, 0.024377831875784278}},
    {"CloserToAnotherThanTheMiddleOfItsTriangle",
     Mode::kOneSurface,
     Feature::kPolygon,
     {{4, 1, 627}},
     {0.0099999997764825821, 0.044120006756378193, -0.0028700061458459421},
     {-0.043299798897593889, 0.036205003773184828, 0.009313218660144576},
     {-0.044313931224108455, 0.035170087764826892, 0.0082108465538247959},
     {-0.04371199872099911, 0.036161834061000965, 0.009320223475259494},
     {-0.044554333621880729, 0.035300041105744466, 0.008310004444743193}},
    {"FromASeamThatEndsEarlyInAFastTick",
     Mode::kSeveralSurfaces,
     Feature::kPolygon,
     {{1, 1, 666}, {2, 1, 2974}},
     Vec3(0),
     {0.0067807003493829277, 0.016236882286316014, 0.00081206246874785531},
     {0.013183241988307661, 0.01536778611319705, -0.0047221966185618386},
     {0.0075947330975661958, 0.016164573209114307, 8.8108452849448848e-05},
     {0.01281329249867052, 0.016787120484524656, -0.0050081736319700504}},
    {"OnAnEdgeThatIsNearlyFlatBesideAnother",
     Mode::kSeveralSurfaces,
     Feature::kPolygon,
     {{1, 1, 821}, {2, 1, 2392}},
     Vec3(0),
     {-0.0048899844690263213, 0.023235562686779256, 0.020969449567690465},
     {-0.0053658525495228759, 0.024956163585763309, 0.02290771914222053},
     {-0.0048456734119461629, 0.023207415718118039, 0.020978892924774846},
     {-0.005369398085007868, 0.024947958726093213, 0.0229139982355154}},
};

class PathContinuity : public testing::TestWithParam<Moment> {};

TEST_P(PathContinuity, FollowsThePathOfASlowHand) {
  const Moment& moment = GetParam();
  const Quat turn{0.2983204717376271, -0.36399926120541576, 0.87484162251014996, 0.11472388377299372};
  ContactRig world;
  world.add(shapes::box({0.1, 0.1, 0.02}, 12),
            Pose{turn, {-0.010246574031050988, 0.0057819881125940539, 0.024279031035198621}});
  world.add(shapes::sphere(0.025, 16), Pose{turn, {-0.01057447432117762, 0.011999219770582546, 0.0022282144537057579}});
  world.add(shapes::bumpy(0.025, 16), Pose{turn, {0.017592972365984484, 0.019257778628628878, 0.019048091695533596}});
  world.add(shapes::torus(0.03, 0.008, 72, 24),
            Pose{turn, {0.00075084895759256007, 0.010552755151314295, 0.0014252245804498888}});
  world.add(shapes::box({0.02, 0.09, 0.012}, 8),
            Pose{turn, {-0.0063661264705111541, 0.010786600323032176, 0.012707687839483006}});
  ContactState& state = world.state();
  state.mode = moment.mode;
  state.feature = moment.feature;
  state.holdingCount = static_cast<int>(moment.holding.size());
  std::copy(moment.holding.begin(), moment.holding.end(), state.holding.begin());
  state.local = moment.local;
  state.hip = moment.hip;
  state.ihip = moment.ihip;
  const ContactResult r = world.tick(moment.nextHip);
  EXPECT_TRUE(r.touching);
  EXPECT_FALSE(r.work.notConverged);
  EXPECT_NEAR(glm::distance(r.ihip, moment.nextIhip), 0, kSame);
  for (const ContactSurface& s : state.surfaces()) {
    const Body& body = world.bodies()[static_cast<std::size_t>(s.body)];
    const ClosestPoint foot = closestOn(body.surface->triangle(s.triangle), s.triangle, body.frame.toLocal(r.ihip));
    EXPECT_LT(std::sqrt(foot.squaredDistance), kSupportMargin) << "polygon " << s.triangle << " of body " << s.body;
  }
}

INSTANTIATE_TEST_SUITE_P(Moments, PathContinuity, testing::ValuesIn(kMoments),
                         [](const auto& moment) { return std::string(moment.param.name); });

/// The edge of a tetrahedron ends in the groove of two blocks, exactly. It juts out between them, so that from the place
/// where it does there is a way over each of its faces.
TEST(PathContinuity, EdgeThatEndsInAGrooveLetsPassOverEitherFace) {
  ContactRig world;
  const shapes::Shape block = shapes::box({0.25, 0.25, 0.25});
  world.add(block, Vec3(0, 0, -0.125));
  world.add(block, Vec3(0.125, 0, 0));
  const Vec3f along(0x1p-8F, 0x1.18p-9F, -0x1p-8F);
  const shapes::Shape tetrahedron{
      {3.0F * along, -2.0F * along, {0.018F, -0.0018F, 0.0095F}, {-0.0142F, 0.007F, -0.0123F}},
      {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};
  world.add(tetrahedron);
  const std::array blocks{Vec3(-1, 0, 0), Vec3(0, 0, 1)};
  const auto normal = [&](std::size_t t) {
    const Vec3 a = tetrahedron.corner(t, 0);
    return glm::normalize(glm::cross(tetrahedron.corner(t, 1) - a, tetrahedron.corner(t, 2) - a));
  };
  const std::array faces{normal(0), normal(1)};
  ASSERT_LT(faces[0].y, 0);
  ASSERT_LT(faces[1].y, 0);
  const Vec3 all = blocks[0] + blocks[1] + faces[0] + faces[1];
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> depth(0.002, 0.02);
  for (int i = 0; i < 100; ++i) {
    const auto over = static_cast<std::size_t>(i % 2);
    const Vec3 line = glm::cross(blocks[over], faces[over]);
    const Vec3 place = glm::normalize(line * glm::dot(line, blocks[1 - over])) * 1e-4;
    world.place({-0.001, -0.004, 0.001});
    world.tick(-0.004 * all);
    ASSERT_LT(glm::length(world.result().ihip), kSame) << i;
    world.tick(place - blocks[over] * depth(random) - faces[over] * depth(random));
    EXPECT_LT(glm::distance(world.result().ihip, place), kSame) << i;
  }
}

}  // namespace
}  // namespace haptics::path_continuity_test
