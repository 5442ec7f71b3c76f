#include "tests/stress/pinch_run.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "graphics_client/mirror/server_link.h"
#include "tests/stress/run_files.h"

namespace haptics::stress {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kTargets_Hz = 60;
constexpr double kMaxError_mm = 0.3;
constexpr double kMaxSlide_m = 1e-4;
/// By which hands let go: ticks that are missed between two looks, and a pause between two targets or two looks.
constexpr std::uint64_t kLetsGo_ticks = 15;
constexpr double kLetsGo_s = 0.2;
constexpr const char* kLate = "late";
constexpr int kTries = 4;
/// Along the way of a hand, from the beginning (s): over the brick, beside it, closed, raised; then it holds.
constexpr std::array kMoments_s{2.0, 4.0, 5.5, 7.5};
constexpr double kHalf_m = 0.025, kBeside_m = 0.02, kInside_m = 0.008, kGrip_m = 0.0205, kOver_m = 0.08, kLift_m = 0.04;

constexpr const char* kScene = R"(
operations { add { name: "table" mesh { box { size_m { x: 0.3 y: 0.24 z: 0.02 } } } pose { position { z: -0.01 } }
  motion { fixed: true collision { friction: 0.8 } } } }
operations { add { name: "brick" mesh { box { size_m { x: 0.05 y: 0.035 z: 0.035 } } } pose { position { z: 0.0175 } }
  material { stiffness_N_per_m: 800 friction { mu_static: 0.9 mu_dynamic: 0.7 } }
  motion { mass_kg: 0.05 angular_damping_per_s: 4 collision { friction: 0.7 } } } }
)";

/// Where a hand (side -1 or 1) is to be at a time.
Vec3 placeAt(double side, double time_s) {
  const double beside = side * (kHalf_m + kBeside_m), inside = side * (kHalf_m - kInside_m);
  const std::array<Vec3, 5> places{Vec3(beside, 0, 0.15), Vec3(beside, 0, kOver_m), Vec3(beside, 0, kGrip_m),
                                   Vec3(inside, 0, kGrip_m), Vec3(inside, 0, kGrip_m + kLift_m)};
  double from_s = 0;
  for (std::size_t i = 0; i < kMoments_s.size(); ++i) {
    if (time_s < kMoments_s[i]) {
      const double share = std::clamp((time_s - from_s) / (kMoments_s[i] - from_s), 0.0, 1.0);
      return glm::mix(places[i], places[i + 1], share);
    }
    from_s = kMoments_s[i];
  }
  return places.back();
}

/// The brick, as seen beside the server.
class HeldBrick {
 public:
  /// `isUp`: from now on it is to be held.
  void look(const MirrorView& view, bool isUp) {
    const auto brick = view.scene->find("brick");
    if (!brick || !view.sample || !view.secondHand || view.sample->tick == tick_) return;
    if (tick_ != 0) mostMissed_ = std::max(mostMissed_, view.sample->missedTicks - missedTicks_);
    // While the servo is held up by the machine, nobody holds the brick.
    const bool heldUp = std::exchange(missedTicks_, view.sample->missedTicks) != view.sample->missedTicks;
    tick_ = view.sample->tick;
    if (!isUp) return;
    const auto body = view.bodies.find(brick->id);
    if (body == view.bodies.end()) return;
    const Pose& pose = body->second.pose;
    ++looks_;
    held_ += view.sample->object == brick->id && view.secondHand->object == brick->id ? 1 : 0;
    lowest_m_ = std::min(lowest_m_, pose.position.z);
    const std::array grip{toLocal(pose, view.sample->stickingPoint), toLocal(pose, view.secondHand->stickingPoint)};
    for (std::size_t hand = 0; last_ && !heldUp && hand < grip.size(); ++hand) {
      slide_[hand] += grip[hand] - (*last_)[hand];
      slid_m_ = std::max(slid_m_, glm::length(slide_[hand]));
    }
    last_ = grip;
  }
  [[nodiscard]] Json report() const {
    return {{"looks", looks_},
            {"looks_in_which_both_hold_it", held_},
            {"lowest_above_its_place_mm", 1e3 * (lowest_m_ - 0.0175)},
            {"slid_mm", 1e3 * slid_m_}};
  }
  [[nodiscard]] std::uint64_t mostMissed() const { return mostMissed_; }

 private:
  std::uint64_t tick_ = 0;
  int looks_ = 0, held_ = 0;
  double lowest_m_ = 1;
  std::uint64_t missedTicks_ = 0, mostMissed_ = 0;
  std::optional<std::array<Vec3, 2>> last_;  // where the hands stick, brick's frame
  std::array<Vec3, 2> slide_{};
  double slid_m_ = 0;
};

/// Lets two hands pinch, lift and hold.
Json held(Cast& cast, double seconds) {
  constexpr double kSettles_s = 1;
  constexpr std::uint64_t kFirstTargets_ns = 5'000'000'000;
  const std::uint64_t began_ns = monotonicNow_ns() + kFirstTargets_ns;
  for (const char* hand : {"0", "1"})
    cast.addClient(std::string("leader_") + hand, {"lead", "--hand", hand, "--from", std::to_string(began_ns)});
  cast.awaitViewers([&] { return cast.says("leader_0", "leads") && cast.says("leader_1", "leads"); });
  const auto at_ns = [&](double time_s) { return began_ns + static_cast<std::uint64_t>(1e9 * time_s); };
  const double from_s = kMoments_s.back() + kSettles_s;
  HeldBrick brick;
  bool late = false;
  for (std::uint64_t last_ns = monotonicNow_ns(), now_ns = last_ns; now_ns < at_ns(from_s + seconds);
       last_ns = now_ns, now_ns = monotonicNow_ns()) {
    late |= 1e-9 * static_cast<double>(now_ns - last_ns) > kLetsGo_s;
    cast.server().checkAlive();
    brick.look(*cast.witness().latest(), now_ns > at_ns(from_s));
    std::this_thread::sleep_for(kLook);
  }
  Json report = brick.report();
  report["held_up_by_the_machine"] =
      late || brick.mostMissed() >= kLetsGo_ticks || cast.says("leader_0", kLate) || cast.says("leader_1", kLate);
  return report;
}

Json judged(const Json& report) {
  const Json& brick = report.at("brick");
  Json holds;
  holds["lifted_all_the_time"] = brick.at("lowest_above_its_place_mm") > 1e3 * kLift_m - 3;
  holds["held_by_both_all_the_time"] =
      brick.at("looks") > 100 && brick.at("looks_in_which_both_hold_it") == brick.at("looks");
  holds["slid_less_than_0.1_mm"] = brick.at("slid_mm") < 1e3 * kMaxSlide_m;
  bool contacts = true, scenes = true;
  for (const Json& viewer : report.at("viewers")) {
    contacts &=
        viewer.at("contacts").at("all").at("frames") > 0 && viewer.at("contacts").at("all").at("p99") <= kMaxError_mm;
    scenes &= viewer.at("client_scene_hash") == report.at("server").at("scene_hash");
  }
  holds["contact_error_p99_within_0.3_mm"] = contacts;
  holds["scenes_equal_at_the_end"] = scenes;
  holds["server_ended_well"] = report.at("server_ended_well");
  return holds;
}

Json runOnce(RunPlan plan, const CastOptions& options) {
  const auto network = makeNetwork(plan, options.relay, options.out);
  Json report = headOf(plan, *network);
  report["viewers_count"] = options.viewers;
  Cast cast(plan, options, *network, kScene,
            {"--hand", "nominal", "--hand", "nominal", "--record", (options.out / "pinch.haptics").string()});
  report["brick"] = held(cast, plan.seconds);
  report.update(cast.finish({"scene_hash", "missed_ticks", "ticks", "second_hand"}));
  conclude(report, *network, judged(report));
  return report;
}

}  // namespace

void runHandLeader(const HandLeaderOptions& options) {
  static std::atomic<bool> stopRequested{false};
  std::signal(SIGTERM, [](int) { stopRequested = true; });
  ServerLink link({.server = options.server,
                   .clientName = "hand " + std::to_string(options.hand + 1),
                   .telemetryRate_Hz = kTargets_Hz,
                   .datagrams = true,
                   .hand = options.hand});
  const double side = options.hand == 0 ? -1 : 1;
  bool leads = false;
  double askAgain_s = -1e9, last_s = 1e9;
  while (!stopRequested) {
    const auto view = link.latest();
    const double time_s = 1e-9 * static_cast<double>(static_cast<std::int64_t>(monotonicNow_ns() - options.began_ns));
    if (time_s - std::exchange(last_s, time_s) > kLetsGo_s) {
      std::printf("%s\n", kLate);
      std::fflush(stdout);
    }
    if (view->link == LinkState::kLive && !view->hand.isSelf && time_s > askAgain_s) {
      link.leadHand(true);
      askAgain_s = time_s + 1;
    }
    if (view->hand.isSelf && !std::exchange(leads, true)) {
      std::printf("leads\n");
      std::fflush(stdout);
    }
    link.commandHand({.leads = true, .position = placeAt(side, time_s)});
    std::this_thread::sleep_for(std::chrono::duration<double>(1 / kTargets_Hz));
  }
}

Json runPinched(RunPlan plan, const CastOptions& options) {
  for (int tries = 1;; ++tries) {
    Json report = runOnce(plan, options);
    if (report.at("pass") || !report.at("brick").at("held_up_by_the_machine") || tries == kTries) return report;
    std::printf("not judged, the machine held a process up\n%s\n", report.dump(2).c_str());
  }
}

}  // namespace haptics::stress
