#include "tests/eval/accuracy.h"

#include <array>
#include <cstdio>
#include <map>
#include <utility>

#include "tests/eval/accuracy_run.h"
#include "tests/eval/adapters/outside_method.h"
#include "tests/eval/closed_loop_rest.h"

namespace haptics::eval {
namespace {

constexpr std::array kDepths_m{0.0005, 0.001, 0.002, 0.005};
constexpr double kPrintedDepth_m = 0.002;

void print(const Record& r) {
  std::printf(
      "%-25s %-12s %8d triangles  IHIP %.4f rms %.4f max mm  dF %.4f max N  angle %.3f max deg  epsilon %.3f  "
      "%.0f ns  cycle %.1f um  K_crit %.0f N/m%s\n",
      r["method"].get<std::string>().c_str(), r["scene"].get<std::string>().c_str(), r["triangles"].get<int>(),
      r["ihip_error_rms_mm"].get<double>(), r["ihip_error_max_mm"].get<double>(), r["force_error_max_N"].get<double>(),
      r.value("direction_error_max_deg", 0.0), r["epsilon_p99_ratio"].get<double>(), r["tick_p50_ns"].get<double>(),
      r["limit_cycle_um"].get<double>(), r["K_crit_N_per_m"].get<double>(), r["pass"].get<bool>() ? "" : "  FAIL");
}

/// What does not depend on the depth. K_crit takes long: of the first shape alone, for all of as many triangles.
class Steadiness {
 public:
  [[nodiscard]] Record of(const Method& method, const Sample& sample, int triangles) {
    auto critical = critical_N_per_m_.find({method.name, triangles});
    if (critical == critical_N_per_m_.end())
      critical =
          critical_N_per_m_.emplace(std::pair{method.name, triangles}, criticalOnMesh_N_per_m(method, sample)).first;
    const ClosedLoopRest rest = restOnMesh(method, sample);
    return {{"limit_cycle_um", rest.limitCycle_um},
            {"limit_cycle_allowed_um", rest.allowed_um},
            {"steady", rest.steady()},
            {"K_crit_N_per_m", critical->second}};
  }

 private:
  std::map<std::pair<std::string_view, int>, double> critical_N_per_m_;  ///< By method and triangles asked for.
};

}  // namespace

bool runAccuracy(const AccuracyOptions& options) {
  const std::span<const Method> chosen =
      options.method.empty() ? methods() : std::span(&findMethod(options.method, methods()), 1);
  std::vector<Record> records;
  Steadiness steadiness;
  bool good = true;
  std::printf("depth %g mm\n", kPrintedDepth_m * 1e3);
  for (const AnalyticShape& shape : analyticShapes()) {
    for (const int triangles : kMeshTriangles) {
      if (triangles > options.finest) break;
      const Sample sample = makeSample(shape, triangles);
      for (const Method& method : chosen) {
        const Record about{{"method", method.name},
                           {"scene", shape.name},
                           {"seed", options.seed},
                           {"triangles", sample.mesh.triangles.size()}};
        Record measures = about;
        if (!runOrExplain(measures, [&] { measures = steadiness.of(method, sample, triangles); })) {
          std::printf("%s\n", measuresText(measures).c_str());
          records.push_back(std::move(measures));
          continue;
        }
        for (const double depth : kDepths_m) {
          const bool compare = method.name == kOurs && triangles <= kFinestMesh;
          Record& record = records.emplace_back(about);
          record["depth_mm"] = depth * 1e3;
          if (!runOrExplain(record, [&] { record = measureAccuracy(method, sample, depth, options.seed, compare); })) {
            std::printf("%s\n", measuresText(record).c_str());
            continue;
          }
          record.update(measures);
          if (depth == kPrintedDepth_m) print(record);
          if (method.name == kOurs) good = good && record["pass"].get<bool>() && measures["steady"].get<bool>();
        }
      }
    }
  }
  writeRecords(options.out, "accuracy", records);
  return good;
}

}  // namespace haptics::eval
