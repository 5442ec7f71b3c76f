#include "graphics_client/mirror/playback.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace haptics {
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

TEST(Playback, LagsByNoMoreThanItsBoundWhereTheLinkIsBad) {
  Playback playback;
  for (std::uint64_t now = 1000; now < 3000; now += 16) {
    const std::uint64_t sample = now - now % 400;
    const auto shown = playback.at(viewAt(sample, now), now * kMillisecond_ns);
    const double newest = 1e-3 * kSpeed_m_per_s * static_cast<double>(sample);
    const double lag_s = 1e-3 * static_cast<double>(now) - shownX(*shown) / kSpeed_m_per_s;
    EXPECT_LE(shownX(*shown), newest + 1e-12);
    EXPECT_LE(lag_s, std::max(Playback::kMostLag_s, 1e-3 * static_cast<double>(now - sample)) + 1e-9);
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

}  // namespace
}  // namespace haptics
