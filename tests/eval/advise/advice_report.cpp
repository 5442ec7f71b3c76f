#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "tests/eval/advise/verdict.h"

namespace haptics::eval {
namespace {

const char* verdict(const Candidate& c) {
  if (c.opened) return "has holes";
  if (c.strayed) return "strays too far";
  if (c.difference.missedTicks > 0) return "loses contact";
  if (c.difference.wrongSideTicks > 0) return "pushes the wrong way";
  return c.good() ? "" : c.difference.epsilon_p99 < 1 ? "is nearly felt" : "is felt";
}

void printCandidates(const ObjectAdvice& object) {
  std::printf("  %10s  %12s  %8s  %8s  %7s  %8s  %8s\n", "triangles", "deviation mm", "error", "worst", "hot ns",
              "cold ns", "MB");
  for (std::size_t i = 0; i < object.candidates.size(); ++i) {
    const Candidate& c = object.candidates[i];
    std::printf("%s %10zu  %12.4f  %8.3f  %8.3f  %7.0f  %8.0f  %8.3f  %s%s\n", i == object.advised ? " >" : "  ",
                c.triangles, c.deviation_mm, c.difference.epsilon_p99, c.difference.epsilon_max, c.hot_ns, c.cold_ns,
                c.memory_MB, i == 0 ? "its own mesh" : verdict(c), i == object.advised ? " <- advised" : "");
  }
}

void printFeatures(const ObjectAdvice& object) {
  for (const SceneFeature& feature : object.features) {
    if (!feature.judged()) {
      std::printf("  %s: not judged: %s.\n", feature.name.c_str(), feature.whyNot.c_str());
    } else {
      std::printf("  %s: without it the error is %.2f: it is %s; it costs %.0f ns a tick.\n", feature.name.c_str(),
                  feature.epsilon_p99, feature.felt() ? "felt" : "not felt", feature.cost_ns);
    }
  }
  if (object.textureRate_Hz > 0) {
    std::printf("  Its finest pattern asks for %.0f Hz.\n", object.textureRate_Hz);
  }
}

void printMotions(const ObjectAdvice& object) {
  if (object.motions.empty()) {
    std::printf("  Failure motions: not tried, for the mesh is open and has no inside.\n");
    return;
  }
  std::string names;
  for (const FailureMotion& motion : object.motions) names += (names.empty() ? "" : ", ") + motion.name;
  if (object.holds()) {
    std::printf("  Failure motions, %s: the IHIP stays outside.\n", names.c_str());
    return;
  }
  for (const FailureMotion& motion : object.motions) {
    if (motion.holds()) continue;
    std::printf("  %s: THE IHIP IS INSIDE in %d ticks, %d in a row, up to %.3f mm deep.\n", motion.name.c_str(),
                motion.insideTicks, motion.longestInside, motion.deepestInside_mm);
  }
}

void printMeshSteps(const ObjectAdvice& object) {
  const Candidate& here = object.mesh();
  if (object.advised > 0) {
    const Candidate& up = object.candidates[object.advised - 1];
    std::printf("  A step up, %zu triangles: %+.3f MB, %+.0f ns; error %.3f instead of %.3f.\n", up.triangles,
                up.memory_MB - here.memory_MB, up.hot_ns - here.hot_ns, up.difference.epsilon_p99,
                here.difference.epsilon_p99);
  }
  if (object.advised + 1 < object.candidates.size()) {
    const Candidate& down = object.candidates[object.advised + 1];
    std::printf("  A step down, %zu triangles: %+.3f MB, %+.0f ns; %s: error %.3f.\n", down.triangles,
                down.memory_MB - here.memory_MB, down.hot_ns - here.hot_ns,
                down.good() ? "it is not felt" : (std::string("but it ") + verdict(down)).c_str(),
                down.difference.epsilon_p99);
  }
}

std::string steadyFromText(const MaterialOption& option) {
  const auto rate = option.steadyFrom();
  return rate ? std::to_string(std::lround(kRates_Hz[*rate])) + " Hz" : "no rate";
}

/// A row for each stiffness, a column for each damping.
void printOptions(const SceneAdvice& advice, const ObjectAdvice& object) {
  const MaterialOption& advised = advice.optionOf(object);
  std::printf("\n  %10s  %10s  %s\n  %10s  %10s", "stiffness", "1 N goes",
              "lowest steady rate and (error) at a damping, Ns/m, of", "N/m", "in, mm");
  double row = object.options.front().stiffness_N_per_m;
  for (const MaterialOption& option : object.options) {
    if (option.stiffness_N_per_m == row) std::printf("  %19.3g", option.damping_Ns_per_m);
  }
  row = 0;
  for (const MaterialOption& option : object.options) {
    if (option.stiffness_N_per_m != row) {
      row = option.stiffness_N_per_m;
      std::printf("\n%s %10.0f  %10.3f", row == advised.stiffness_N_per_m ? " >" : "  ", row, option.depth_mm());
    }
    std::printf("  %s%8s (%6.2f)", &option == &advised ? "> " : "  ", steadyFromText(option).c_str(),
                option.atBest().epsilon_p99());
  }
  std::printf("\n");
}

void printMaterialSteps(const SceneAdvice& advice, const ObjectAdvice& object) {
  const MaterialOption& here = advice.optionOf(object);
  for (const MaterialOption& other : object.options) {
    const std::string step = object.stepBetween(here, other);
    if (step.empty()) continue;
    const bool up = step.ends_with("up");
    std::printf("  A step %s, ", up ? "up" : "down");
    if (step.starts_with("stiffness")) {
      std::printf("%.0f N/m: 1 N goes %.3f mm %s", other.stiffness_N_per_m,
                  std::abs(other.depth_mm() - here.depth_mm()), up ? "less deep" : "deeper");
    } else {
      std::printf("%.3g Ns/m: %.3g Ns/m %s damping", other.damping_Ns_per_m,
                  std::abs(other.damping_Ns_per_m - here.damping_Ns_per_m), up ? "more" : "less");
    }
    const Trial& best = other.atBest();
    const std::string rate = steadyFromText(other);
    std::printf("; steady from %s%s; it is %s: error %.2f.\n", rate.c_str(), rate == steadyFromText(here) ? " too" : "",
                best.sameFeel() ? "not felt" : "felt", best.epsilon_p99());
  }
  if (!here.own) {
    std::printf("  Its own damping, %.3g Ns/m, is steady from %s.\n", object.ownOption().damping_Ns_per_m,
                steadyFromText(object.ownOption()).c_str());
  }
}

std::string listed(const std::vector<std::string>& items) {
  std::string list;
  for (const std::string& item : items) list += (list.empty() ? "" : ", ") + item;
  return list;
}

void printRates(const SceneAdvice& advice, const DevicePreset& device) {
  std::printf(
      "\nrate, a %s on each object as advised: rest with 1 N, with no hand and a light one; tap and stroke at 0.1 m/s, "
      "the force\nheld from tick to tick, against %.0f Hz; pattern: ten ticks to a wave of the finest that is felt, at "
      "0.1 m/s\n",
      device.title.data(), kRates_Hz.back());
  std::printf("  %10s  %8s  %14s  %17s  %17s\n", "Hz", "error", "limit cycle um", "passive alone N/m",
              "contact, % of core");
  for (std::size_t i = 0; i < kRates_Hz.size(); ++i) {
    const RateSummary at = summaryAt(advice, i, device);
    const bool advised = advice.rate == i;
    std::printf("%s %10.0f  %8.3f  %14.1f  %17.0f  %17.4f  %s%s\n", advised ? " >" : "  ", kRates_Hz[i], at.epsilon_p99,
                at.worstCycle_um, at.passiveTo_N_per_m, 100 * at.core_ratio,
                at.good() ? "" : ("fails: " + listed(at.fails)).c_str(), advised ? "<- advised" : "");
    for (const std::string& where : at.unsteady) std::printf("              %s\n", where.c_str());
  }
  std::printf(
      "  Passive alone: up to where the device needs neither stabiliser nor hand to rest (Abbott and Okamura 2005). It "
      "is "
      "steady\n  on stiffer surfaces by the stabiliser, which every server has.\n");
  if (!advice.rate) {
    std::printf("  No rate is steady on every object and feels the same: see the options above.\n");
    return;
  }
  std::printf("  %.0f Hz is enough; %s.\n", kRates_Hz[*advice.rate], decidedBy(advice, device).c_str());
}

const char* verdict(const SpacingCandidate& c) {
  if (c.difference.wrongSideTicks > 0) return "pushes the wrong way";
  return c.good() ? "" : c.isFelt() ? "is felt" : "is nearly felt";
}

void printTool(const ToolAdvice& tool) {
  std::printf("\n%s, held as a tool\n", tool.name.c_str());
  if (tool.candidates.empty()) {
    std::printf("  There is nothing that it gets to from above: not judged.\n");
    return;
  }
  std::printf("  %10s  %8s  %8s  %8s  %8s  %8s\n", "spacing mm", "points", "error", "worst", "torque", "tick ns");
  for (std::size_t i = 0; i < tool.candidates.size(); ++i) {
    const SpacingCandidate& c = tool.candidates[i];
    std::printf("%s %10.3f  %8zu  %8.3f  %8.3f  %8.3f  %8.0f  %s%s\n", i == tool.advised ? " >" : "  ",
                1e3 * c.spacing_m, c.points, c.difference.epsilon_p99, c.difference.epsilon_max, c.torque_p99, c.hot_ns,
                i == 0 ? "its own spacing" : verdict(c), i == tool.advised ? " <- advised" : "");
  }
}

}  // namespace

void print(const SceneAdvice& advice, const DevicePreset& device) {
  std::printf(
      "error: of the force, against the scene as it is, in units of what a hand just notices; 99 %% of the ticks, at "
      "places\n"
      "that no force moves. Steady, limit cycle: a device that the force moves, with the stabiliser, as the server has "
      "it by\n"
      "default; stiffness and damping as set, where the server would take no more than half of what the device "
      "bears\n");
  std::printf("\n");
  if (advice.tool) std::printf("%s: %s\n", advice.tool->name.c_str(), verdictOf(*advice.tool).c_str());
  for (const ObjectAdvice& object : advice.objects) {
    std::printf("%s: %s\n", object.name.c_str(), object.verdict.text.c_str());
    if (const std::string note = notJudgedOf(object); !note.empty()) std::printf("  not judged: %s\n", note.c_str());
    if (const std::string note = notFeltOf(object); !note.empty()) std::printf("  not felt: %s\n", note.c_str());
  }
  if (advice.tool) printTool(*advice.tool);
  double all_MB = 0;
  double advised_MB = 0;
  for (const ObjectAdvice& object : advice.objects) {
    std::printf("\n%s\n", object.name.c_str());
    if (!object.judged()) {
      std::printf("  No hand gets to it from above: not judged.\n");
      continue;
    }
    printFeatures(object);
    printMotions(object);
    printCandidates(object);
    printMeshSteps(object);
    printOptions(advice, object);
    printMaterialSteps(advice, object);
    all_MB += object.candidates.front().memory_MB;
    advised_MB += object.mesh().memory_MB;
  }
  if (std::ranges::none_of(advice.objects, &ObjectAdvice::judged)) {
    std::printf("\nNo hand gets to any object from above: there is nothing to advise.\n");
    return;
  }
  printRates(advice, device);
  std::printf("\nall objects: %.3f MB instead of %.3f\n", advised_MB, all_MB);
}

}  // namespace haptics::eval
