#include "graphics_client/mirror/playback.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "common/mesh/generators.h"
#include "tests/graphics_client/viewer/fake_mirror.h"

namespace haptics::playback_test {
namespace {

constexpr std::uint64_t kMillisecond_ns = 1'000'000;
constexpr double kSpeed_m_per_s = 0.1;

/// The view that a client has of a body that moves evenly along x, felt by a HIP that moves with it.
std::shared_ptr<const MirrorView> viewAt(std::uint64_t sample_ms, std::uint64_t now_ms) {
  MirrorView view;
  view.link = LinkState::kLive;
  view.sample.emplace();
  view.sample->tick = sample_ms;
  view.sample->time_ns = sample_ms * kMillisecond_ns;
  view.sample->object = 1;
  const double x = 1e-3 * kSpeed_m_per_s * static_cast<double>(sample_ms);
  view.sample->hip = view.sample->ihip = Vec3(x, 0, 0);
  view.bodies[1] = {1, Pose{Quat(1, 0, 0, 0), Vec3(x, 0, 0)}};
  view.takenAt_ns = now_ms * kMillisecond_ns;
  view.telemetryAge_s = 1e-3 * static_cast<double>(now_ms - sample_ms);
  return std::make_shared<const MirrorView>(std::move(view));
}

double shownX(const MirrorView& view) { return view.bodies.at(1).pose.position.x; }

TEST(Playback, OfASceneInWhichNothingMovesIsTheNewestSample) {
  Playback playback;
  auto view = std::make_shared<MirrorView>(*viewAt(100, 110));
  view->bodies.clear();
  EXPECT_EQ(playback.at(view, 110 * kMillisecond_ns), view);
}

TEST(Playback, MovesEvenlyWhereSamplesComeUnevenly) {
  Playback playback;
  double last = 0;
  std::uint64_t sample = 0;
  for (std::uint64_t now = 1000; now < 4000; now += 10) {
    const std::uint64_t period = now % 70 < 30 ? 8 : 27;  // a link that stutters
    sample = std::max(sample, now - now % period);
    const double x = shownX(*playback.at(viewAt(sample, now), now * kMillisecond_ns));
    if (now > 2500) {
      EXPECT_NEAR(x - last, 0.01 * kSpeed_m_per_s, 0.25 * 0.01 * kSpeed_m_per_s)
          << now << ": the samples' steps are 0 to 2.7";
    }
    last = x;
  }
}

TEST(Playback, ShowsContactAndBodyAtTheSameMoment) {
  Playback playback;
  for (std::uint64_t now = 1000; now < 2000; now += 7) {
    const auto shown = playback.at(viewAt(now - now % 16, now), now * kMillisecond_ns);
    EXPECT_NEAR(shown->sample->ihip.x, shownX(*shown), 1e-12);
  }
}

using Change = std::function<void(MirrorView&)>;

/// As above, 6 tenths of the way from a sample at 1000 ms to one at 1040 ms; each is changed by a function.
std::shared_ptr<const MirrorView> onTheWay(const Change& first, const Change& second) {
  Playback playback;
  const auto changed = [](std::uint64_t sample_ms, std::uint64_t now_ms, const Change& change) {
    auto view = std::make_shared<MirrorView>(*viewAt(sample_ms, now_ms));
    change(*view);
    return view;
  };
  (void)playback.at(changed(1000, 1000, first), 1000 * kMillisecond_ns);
  (void)playback.at(changed(1000, 1030, first), 1030 * kMillisecond_ns);  // 30 ms late: the lag
  return playback.at(changed(1040, 1054, second), 1054 * kMillisecond_ns);
}

TEST(Playback, GoesFromDentToDentWithTheContact) {
  const ObjectDent staying{1, {{0, 0.05F, 0}, {0, -0.002F, 0}}};
  const Change first = [&](MirrorView& view) {
    view.dents = {{1, {{0.01F, 0, 0.05F}, {0, 0, -0.004F}}}, staying, {2, {{1, 1, 1}, {0.002F, 0, 0}}}};
  };
  const Change second = [&](MirrorView& view) {
    view.dents = {staying, {1, {{0.02F, 0, 0.05F}, {0, 0, -0.006F}}}, {3, {{2, 2, 2}, {0, 0.004F, 0}}}};
  };
  const auto shown = onTheWay(first, second);
  ASSERT_EQ(shown->dents.size(), 4);
  const auto is = [&](std::uint64_t object, Vec3 centre, Vec3 displacement) {
    return std::ranges::count_if(shown->dents, [&](const ObjectDent& dent) {
      return dent.object == object && glm::distance(Vec3(dent.dent.centre), centre) < 1e-6 &&
             glm::distance(Vec3(dent.dent.displacement), displacement) < 1e-8;
    });
  };
  EXPECT_EQ(is(1, {0, 0.05, 0}, {0, -0.002, 0}), 1) << "one that stays";
  EXPECT_EQ(is(1, {0.016, 0, 0.05}, {0, 0, -0.0052}), 1) << "the contact's";
  EXPECT_EQ(is(2, {1, 1, 1}, {0.0008, 0, 0}), 1) << "one that ends";
  EXPECT_EQ(is(3, {2, 2, 2}, {0, 0.0024, 0}), 1) << "one that begins";
}

TEST(Playback, MakesNothingUpWhereTheContactLeavesADentBehind) {
  const Change first = [](MirrorView& view) { view.dents = {{1, {{0, 0, 0.05F}, {0, 0, -0.004F}}}}; };
  const Change second = [](MirrorView& view) {
    view.dents = {{1, {{0, 0, 0.05F}, {0, 0, -0.003F}}}, {1, {{0.01F, 0, 0.05F}, {0, 0, -0.002F}}}};
  };
  const auto shown = onTheWay(first, second);
  ASSERT_EQ(shown->dents.size(), 2);
  EXPECT_EQ(shown->dents.at(0).dent.displacement.z, -0.003F);
  EXPECT_EQ(shown->dents.at(1).dent.displacement.z, -0.002F);
  EXPECT_NEAR(shown->sample->ihip.x, shownX(*shown), 1e-12) << "the IHIP too is the later sample's, in the body";
}

TEST(Playback, KeepsTheIhipOnTheSideOfABodyThatTurns) {
  const auto turned = [](double angle_rad) {
    return [angle_rad](MirrorView& view) {
      Pose& pose = view.bodies[1].pose;
      pose.rotation = glm::angleAxis(angle_rad, Vec3(0, 0, 1));
      view.sample->ihip = toWorld(pose, Vec3(0.05, 0.02 * angle_rad, 0));  // slides along its side x = 0.05
    };
  };
  const auto shown = onTheWay(turned(0), turned(1));
  EXPECT_NEAR(toLocal(shown->bodies.at(1).pose, shown->sample->ihip).x, 0.05, 1e-12);
  EXPECT_NEAR(toLocal(shown->bodies.at(1).pose, shown->sample->ihip).y, 0.012, 1e-12);
}

/// A body of this shape is touched in the middle of a triangle, wherever the shaded normal looks.
Change touchedOn(const TriMesh& mesh, std::uint32_t triangle) {
  FakeMirror mirror;
  const ObjectId object = mirror.add("body", mesh, {}, {});
  const auto corners = mirror.view().cornersOf(*mirror.view().scene->find(object), triangle).value();
  return [=, scene = mirror.view().scene, meshes = mirror.view().meshes](MirrorView& view) {
    view.scene = scene;
    view.meshes = meshes;
    view.bodies = {{object, {object, view.bodies.at(1).pose}}};
    view.sample->object = object;
    view.sample->primitive.polygon = triangle;
    view.sample->surfaceNormal = glm::normalize(Vec3(1, 0, 1));
    view.sample->ihip = toWorld(view.bodies.at(object).pose, (corners[0] + corners[1] + corners[2]) / 3.0);
  };
}

Vec3 shownInBody(const MirrorView& view) {
  return toLocal(view.bodies.at(view.sample->object).pose, view.sample->ihip);
}

TEST(Playback, KeepsTheIhipOnARoundBody) {
  constexpr double kRadius_m = 0.02;
  const TriMesh ball = makeSphere(kRadius_m, 60).value();
  const auto at = [&](double angle_rad) {
    const Vec3f place(kRadius_m * Vec3(std::cos(angle_rad), std::sin(angle_rad), 0));
    const auto apart = [&](const TriangleIndices& t) {
      return glm::distance(ball.vertices[t[0]], place) + glm::distance(ball.vertices[t[1]], place) +
             glm::distance(ball.vertices[t[2]], place);
    };
    return touchedOn(
        ball, static_cast<std::uint32_t>(std::ranges::min_element(ball.triangles, {}, apart) - ball.triangles.begin()));
  };
  const auto from = at(0), to = at(0.6);
  const Vec3 a = shownInBody(*onTheWay(from, from)), b = shownInBody(*onTheWay(to, to));
  const double straight_m = glm::length(glm::mix(a, b, 0.6));
  ASSERT_LT(straight_m, kRadius_m - 5e-4);
  EXPECT_NEAR(glm::length(shownInBody(*onTheWay(from, to))), kRadius_m, 1e-4);
}

TEST(Playback, LeadsTheIhipStraightOverAPlaneThatIsShaded) {
  const TriMesh box = makeBox({0.1, 0.1, 0.02}, 1).value();
  const auto isTop = [&](std::uint32_t t) {
    return std::ranges::all_of(box.triangles[t], [&](std::uint32_t v) { return box.vertices[v].z > 0; });
  };
  std::vector<std::uint32_t> top;
  for (std::uint32_t t = 0; t < box.triangles.size(); ++t) {
    if (isTop(t)) top.push_back(t);
  }
  ASSERT_EQ(top.size(), 2);
  const auto shown = onTheWay(touchedOn(box, top[0]), touchedOn(box, top[1]));
  EXPECT_NEAR(shownInBody(*shown).z, 0.01, 1e-9);
}

TEST(Playback, ShowsAContactThatEndsAsTheLastSampleHadIt) {
  for (const bool early : {true, false}) {
    const Change touching = [](MirrorView& view) {
      view.sample->ihip = toWorld(view.bodies[1].pose, Vec3(0, 0, 0.05));
      view.dents = {{1, {{0, 0, 0.055F}, {0, 0, -0.005F}}}};
    };
    const Change free = [](MirrorView& view) { view.sample->object = 0; };
    const auto shown = early ? onTheWay(touching, free) : onTheWay(free, touching);
    if (early) {  // 6 tenths of the way: as the second
      EXPECT_EQ(shown->sample->object, 0);
      EXPECT_TRUE(shown->dents.empty());
      continue;
    }
    EXPECT_EQ(shown->sample->object, 1);
    EXPECT_EQ(shown->dents.at(0).dent.displacement.z, -0.005F);
    EXPECT_NEAR(toLocal(shown->bodies.at(1).pose, shown->sample->ihip).x, 0, 1e-12) << "where the body is by then";
  }
}

/// A dent until the scene's second revision, which has it in the shape at rest.
struct TakenInDent {
  std::shared_ptr<const SceneVersion> before = std::make_shared<const SceneVersion>(sceneAt(1));
  std::shared_ptr<const SceneVersion> after = std::make_shared<const SceneVersion>(sceneAt(2));

  static SceneVersion sceneAt(std::uint64_t revision) {
    ObjectRecord clay;
    clay.id = 1;
    clay.name = "clay";
    clay.deformation.softness = Softness{.stiffness_N_per_m = 100, .radius_m = 0.01, .plastic = 1};
    return SceneVersion::fromSnapshot(revision, {clay}).value();
  }
  [[nodiscard]] Change with(std::uint64_t feltRevision, const std::shared_ptr<const SceneVersion>& scene) const {
    return [=](MirrorView& view) {
      view.scene = scene;
      view.sample->sceneRevision = feltRevision;
      if (feltRevision == 1) view.dents = {{1, {{0, 0, 0.05F}, {0, 0, -0.004F}}}};
    };
  }
};

TEST(Playback, ShowsADentOnceWhileTheShapeAtRestTakesItIn) {
  const TakenInDent dent;
  constexpr std::uint64_t kHeard_ms = 1050;                        // the edit comes here then
  for (std::uint64_t felt_ms = 1000; felt_ms < 1090; ++felt_ms) {  // the servo adopts it then, and tells 5 ms later
    Playback playback;
    for (std::uint64_t now = 1000; now < 1150; now += 7) {
      const std::uint64_t sample = now - 5 - (now - 5) % 16;
      const std::uint64_t felt = sample < felt_ms ? 1 : 2;
      auto view = std::make_shared<MirrorView>(*viewAt(sample, now));
      dent.with(felt, now < kHeard_ms ? dent.before : dent.after)(*view);
      const auto shown = playback.at(view, now * kMillisecond_ns);
      EXPECT_EQ(shown->dents.size(), shown->scene->revision() == 1 ? 1U : 0U) << now << ", adopted at " << felt_ms;
      for (const ObjectDent& shownDent : shown->dents) EXPECT_EQ(shownDent.dent.displacement.z, -0.004F) << now;
    }
  }
}

TEST(Playback, MakesNothingUpWhereTheContactGoesFarOverClay) {
  const TakenInDent clay;  // its radius is 10 mm
  const auto dentAt = [&](float x_m) {
    return [&clay, x_m](MirrorView& view) {
      clay.with(1, clay.before)(view);
      view.dents.at(0).dent.centre.x = x_m;
    };
  };
  EXPECT_NEAR(onTheWay(dentAt(0), dentAt(0.0015F))->dents.at(0).dent.centre.x, 0.0009, 1e-9) << "6 tenths of the way";
  EXPECT_EQ(onTheWay(dentAt(0), dentAt(0.006F))->dents.at(0).dent.centre.x, 0.006F);
}

TEST(Playback, HoldsNoEditBackWhereTheServoTellsNoMore) {
  const TakenInDent dent;
  Playback playback;
  const auto at = [&](std::uint64_t now, const std::shared_ptr<const SceneVersion>& scene) {
    auto view = std::make_shared<MirrorView>(*viewAt(std::min<std::uint64_t>(now, 1010), now));
    dent.with(1, scene)(*view);
    return playback.at(view, now * kMillisecond_ns)->scene->revision();
  };
  EXPECT_EQ(at(1000, dent.before), 1);
  EXPECT_EQ(at(1010, dent.before), 1);
  EXPECT_EQ(at(1020, dent.after), 1);
  EXPECT_EQ(at(1300, dent.after), 2);
}

TEST(Playback, MakesNothingUpWhereSamplesAreMissing) {
  Playback playback;
  (void)playback.at(viewAt(1000, 1000), 1000 * kMillisecond_ns);
  (void)playback.at(viewAt(1000, 1050), 1050 * kMillisecond_ns);
  const auto shown = playback.at(viewAt(1100, 1110), 1110 * kMillisecond_ns);
  EXPECT_NEAR(shownX(*shown), 0.11, 1e-12) << "where it was at 1100 ms";
  EXPECT_NEAR(shown->sample->ihip.x, 0.11, 1e-12);
}

TEST(Playback, OfASoftObjectIsSmoothToo) {
  const Change soft = [](MirrorView& view) {
    view.bodies.clear();
    ObjectRecord record;
    record.id = 1;
    record.name = "soft";
    record.deformation.softness = Softness{.radius_m = 0.02};
    view.scene = std::make_shared<const SceneVersion>(SceneVersion::fromSnapshot(1, {record}).value());
  };
  const auto shown = onTheWay(soft, soft);
  EXPECT_NEAR(shown->sample->hip.x, 0.1024, 1e-9);
}

TEST(Playback, LagsByNoMoreThanItsBoundWhereTheLinkIsBad) {
  Playback playback;
  for (std::uint64_t now = 1000; now < 3000; now += 16) {
    const std::uint64_t sample = now - now % 400;
    const auto shown = playback.at(viewAt(sample, now), now * kMillisecond_ns);
    const double newest = 1e-3 * kSpeed_m_per_s * static_cast<double>(sample);
    const double lag_s = 1e-3 * static_cast<double>(now) - shownX(*shown) / kSpeed_m_per_s;
    EXPECT_LE(shownX(*shown), newest + 1e-12);
    const double freshest_s = 0.016;  // a frame
    EXPECT_LE(lag_s, std::max(Playback::kMaxLag_s + freshest_s, 1e-3 * static_cast<double>(now - sample)) + 1e-9);
  }
}

TEST(Playback, IsAsSmoothOverALinkThatTakesLong) {
  Playback playback;
  constexpr std::uint64_t kOnTheWay_ms = 100;
  double last = 0;
  for (std::uint64_t now = 1000; now < 3000; now += 10) {
    const std::uint64_t sample = now - now % 16 - kOnTheWay_ms;
    const double x = shownX(*playback.at(viewAt(sample, now), now * kMillisecond_ns));
    if (now > 2000) {
      EXPECT_NEAR(x - last, 0.01 * kSpeed_m_per_s, 1e-4 * kSpeed_m_per_s) << now;
    }
    last = x;
  }
}

TEST(Playback, ShowsABodyThatRestsExactlyWhereItIs) {
  Playback playback;
  for (std::uint64_t now = 1000; now < 1200; now += 7) {
    auto view = std::make_shared<MirrorView>(*viewAt(now - now % 16, now));
    view->bodies[1].pose = {glm::normalize(Quat(0.3, 0.1, 0.7, -0.2)), Vec3(0.1, 0.2, 0.3)};
    const auto shown = playback.at(view, now * kMillisecond_ns);
    EXPECT_EQ(shown->bodies.at(1).pose, view->bodies.at(1).pose);
  }
}

TEST(Playback, StartsAnewWithAnotherServer) {
  Playback playback;
  (void)playback.at(viewAt(100'000, 100'010), 100'010 * kMillisecond_ns);
  auto other = std::make_shared<MirrorView>(*viewAt(5, 100'020));
  other->epoch = 7;
  other->telemetryAge_s = 0.01;
  EXPECT_EQ(shownX(*playback.at(other, 100'020 * kMillisecond_ns)), shownX(*other));
}

TEST(Playback, RemembersNoMoreAssetsThanItsBound) {
  constexpr std::uint64_t kFirst = 100, kViews = 12;
  Playback playback;
  std::vector<std::weak_ptr<const MirrorView>> remembered;
  for (std::uint64_t sample = kFirst; sample < kFirst + kViews; ++sample) {
    auto view = std::make_shared<MirrorView>(*viewAt(sample, sample));
    view->scene = std::make_shared<const SceneVersion>();
    view->assetBytes = kMaxHeldAssets_bytes / 2;
    remembered.push_back(view);
    (void)playback.at(view, sample * kMillisecond_ns);
  }
  EXPECT_EQ(std::ranges::count_if(remembered, [](const auto& view) { return !view.expired(); }), 4);
}

}  // namespace
}  // namespace haptics::playback_test
