#include <cstdio>

#include "tests/eval/advise/advice.h"

namespace haptics::eval {
namespace {

const char* verdict(const Candidate& c) {
  if (c.opened) return "has holes";
  if (c.strayed) return "strays too far";
  if (c.missedTicks > 0) return "loses contact";
  if (c.wrongSideTicks > 0) return "pushes the wrong way";
  return c.epsilon_p99 < 1 ? "" : "is felt";
}

void printCandidates(const ObjectAdvice& object) {
  std::printf("  %10s  %12s  %8s  %8s  %7s  %8s  %8s\n", "triangles", "deviation mm", "error", "worst", "hot ns",
              "cold ns", "MB");
  for (std::size_t i = 0; i < object.candidates.size(); ++i) {
    const Candidate& c = object.candidates[i];
    std::printf("%s %10zu  %12.4f  %8.3f  %8.3f  %7.0f  %8.0f  %8.3f  %s%s\n", i == object.advised ? " >" : "  ",
                c.triangles, c.deviation_mm, c.epsilon_p99, c.epsilon_max, c.hot_ns, c.cold_ns, c.memory_MB,
                i == 0 ? "its own mesh" : verdict(c), i == object.advised ? " <- advised" : "");
  }
}

void printSteps(const ObjectAdvice& object) {
  const Candidate& here = object.candidates[object.advised];
  if (object.advised > 0) {
    const Candidate& up = object.candidates[object.advised - 1];
    std::printf("  A step up, %zu triangles: %+.3f MB, %+.0f ns; error %.3f instead of %.3f.\n", up.triangles,
                up.memory_MB - here.memory_MB, up.hot_ns - here.hot_ns, up.epsilon_p99, here.epsilon_p99);
  }
  if (object.advised + 1 < object.candidates.size()) {
    const Candidate& down = object.candidates[object.advised + 1];
    std::printf("  A step down, %zu triangles: %+.3f MB, %+.0f ns; but it %s: error %.3f.\n", down.triangles,
                down.memory_MB - here.memory_MB, down.hot_ns - here.hot_ns, verdict(down), down.epsilon_p99);
  }
}

double tickOf(const SceneAdvice& advice) {
  double slowest_ns = 0;
  for (const ObjectAdvice& o : advice.objects) {
    if (!o.candidates.empty()) slowest_ns = std::max(slowest_ns, o.candidates[o.advised].hot_ns);
  }
  return slowest_ns;
}

Record recordOf(const ObjectAdvice& object, std::size_t i) {
  const Candidate& c = object.candidates[i];
  return {{"method", "ours"},
          {"scene", object.name},
          {"triangles", c.triangles},
          {"own_mesh", i == 0},
          {"advised", i == object.advised},
          {"deviation_mm", c.deviation_mm},
          {"ticks", c.ticks},
          {"epsilon_p99_ratio", c.epsilon_p99},
          {"epsilon_max_ratio", c.epsilon_max},
          {"missed_contact_ticks", c.missedTicks},
          {"wrong_side_ticks", c.wrongSideTicks},
          {"opened", c.opened},
          {"strayed", c.strayed},
          {"hot_tick_p50_ns", c.hot_ns},
          {"cold_tick_p50_ns", c.cold_ns},
          {"memory_MB", c.memory_MB},
          {"pass", c.good()}};
}

}  // namespace

void print(const SceneAdvice& advice, const DevicePreset& device) {
  std::printf(
      "error: of the force, against the scene's own mesh, in units of what a hand just notices; 99 %% of the ticks\n");
  double all_MB = 0;
  double advised_MB = 0;
  for (const ObjectAdvice& object : advice.objects) {
    std::printf("\n%s\n", object.name.c_str());
    if (object.candidates.empty()) {
      std::printf("  No hand gets to it from above: not judged.\n");
      continue;
    }
    printCandidates(object);
    printSteps(object);
    all_MB += object.candidates.front().memory_MB;
    advised_MB += object.candidates[object.advised].memory_MB;
  }
  std::printf("\nrate, a %s resting with 1 N, no hand and a light one\n", device.title.data());
  const RateAdvice* advised = advice.advisedRate();
  for (const RateAdvice& r : advice.rates) {
    std::printf("%s %7.0f Hz  %-8s  limit cycle %6.1f um  passive to %5.0f N/m  contact takes %.4f %% of a core%s\n",
                &r == advised ? " >" : "  ", r.rate_Hz, r.steady ? "steady" : "UNSTEADY", r.worstCycle_um,
                r.passiveTo_N_per_m, tickOf(advice) * r.rate_Hz * 1e-7, &r == advised ? " <- advised" : "");
    for (const std::string& where : r.unsteady) std::printf("              %s\n", where.c_str());
  }
  if (!advised)
    std::printf("  No rate is steady on every object: another stiffness or damping is needed, or another device.\n");
  std::printf("\nall objects: %.3f MB instead of %.3f\n", advised_MB, all_MB);
}

std::vector<Record> recordsOf(const SceneAdvice& advice) {
  std::vector<Record> records;
  for (const ObjectAdvice& object : advice.objects) {
    for (std::size_t i = 0; i < object.candidates.size(); ++i) records.push_back(recordOf(object, i));
  }
  for (const RateAdvice& r : advice.rates) {
    records.push_back({{"method", "ours"},
                       {"scene", "all objects"},
                       {"rate_Hz", r.rate_Hz},
                       {"advised", &r == advice.advisedRate()},
                       {"limit_cycle_um", r.worstCycle_um},
                       {"unsteady", r.unsteady},
                       {"passive_to_N_per_m", r.passiveTo_N_per_m},
                       {"processor_ratio", tickOf(advice) * r.rate_Hz * 1e-9},
                       {"pass", r.steady}});
  }
  return records;
}

}  // namespace haptics::eval
