// Runs the ticks of one trajectory over a sphere of 10,800 triangles, or of a small scene, in a function of their own, for
// callgrind to count (instruction_gate.py). Usage: count_instructions TRAJECTORY; prints the number of ticks.

#include <cstring>
#include <iostream>

#include "tests/bench/scenes.h"
#include "tests/bench/step_replay.h"

namespace {

using namespace haptics::bench;

constexpr std::uint32_t kSegmentsCounted = 30;
constexpr int kTicks = 4000;
constexpr int kDearTicks = 500;  // of scenes that take a hundred times as long

struct Case {
  const char* name;
  Trajectory trajectory;
};
constexpr Case kCases[] = {{"rubbing", kRubbing},
                           {"slide", kSlide},
                           {"free", kFreeSpace},
                           {"second_body", kSecondBodyNear},
                           {"line_contact", kLineContact}};

/// The whole step with one object, rubbing; "plain" is what a scene without surface properties pays.
struct StepCase {
  const char* name;
  SurfaceCase surface;
};
constexpr StepCase kStepCases[] = {
    {"step", kPlain},         {"step_shading", kShading},     {"step_friction", kFriction},
    {"step_texture", kNoise}, {"step_all", kAllFeatures},     {"step_stabilised", kStabilised},
    {"step_soft", kSoft},     {"step_soft_all", kSoftWithAll}};

/// The whole step of other scenes.
struct SceneCase {
  const char* name;
  StepReplay (*make)();
};
constexpr SceneCase kSceneCases[] = {{"step_tool", heldTool},
                                     {"step_bodies", slidingBodies},
                                     {"step_spring", springToPoint},
                                     {"step_path", springToPath},
                                     {"step_guide", guide}};

/// Of the plain step, from the device's position to its force.
constexpr const char* kAwaited = "step_awaited";

double sum = 0;  // keeps the ticks' results alive

}  // namespace

/// Nothing else is counted: its name is what the gate tells callgrind.
extern "C" [[gnu::noinline]] void countedTicks(Replay& replay) {
  for (int i = 0; i < kTicks; ++i) sum += replay.tick().penetration_m;
}

/// The same for whole steps.
extern "C" [[gnu::noinline]] void countedSteps(StepReplay& replay, int ticks) {
  for (int i = 0; i < ticks; ++i) sum += replay.tick().penetration_m;
}

/// The part of a step that the device waits for.
extern "C" [[gnu::noinline]] void countedForce(StepReplay& replay) { replay.feel(); }

int main(int argc, char** argv) {
  for (const Case& each : kCases) {
    if (argc != 2 || std::strcmp(argv[1], each.name) != 0) continue;
    Replay replay(each.trajectory.make(kSegmentsCounted));
    countedTicks(replay);
    std::cout << kTicks << '\n';
    return sum >= 0 ? 0 : 1;
  }
  for (const StepCase& each : kStepCases) {
    if (argc != 2 || std::strcmp(argv[1], each.name) != 0) continue;
    StepReplay replay(kRubbing.make(kSegmentsCounted), kSegmentsCounted, each.surface);
    countedSteps(replay, kTicks);
    std::cout << kTicks << '\n';
    return sum >= 0 ? 0 : 1;
  }
  for (const SceneCase& each : kSceneCases) {
    if (argc != 2 || std::strcmp(argv[1], each.name) != 0) continue;
    StepReplay replay = each.make();
    countedSteps(replay, kDearTicks);
    std::cout << kDearTicks << '\n';
    return sum >= 0 ? 0 : 1;
  }
  if (argc == 2 && std::strcmp(argv[1], kAwaited) == 0) {
    StepReplay replay(kRubbing.make(kSegmentsCounted), kSegmentsCounted, kPlain);
    for (int i = 0; i < kTicks; ++i) {
      replay.read();
      countedForce(replay);
      sum += replay.finish().penetration_m;
    }
    std::cout << kTicks << '\n';
    return sum >= 0 ? 0 : 1;
  }
  std::cerr << "usage: count_instructions " << kAwaited;
  for (const Case& each : kCases) std::cerr << ' ' << each.name;
  for (const StepCase& each : kStepCases) std::cerr << ' ' << each.name;
  for (const SceneCase& each : kSceneCases) std::cerr << ' ' << each.name;
  std::cerr << '\n';
  return 2;
}
