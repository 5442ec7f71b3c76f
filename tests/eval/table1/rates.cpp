#include "tests/eval/table1/rates.h"

#include <cstdio>

namespace haptics::eval {
namespace {

constexpr double kMinRatio = 0.9;          // of 64,800 polygons to 12
constexpr double kMinContactShare = 0.98;  // the recording's own is 0.99

}  // namespace

bool Rates::measured() const noexcept { return viewerHeld && contactTicks >= kMinContactShare * ticks; }

Record describe(const TableObject& object, Rates& rates, const Table1Run& run) {
  const MeshCounts counts = countsOf(object.mesh);
  Record record{{"method", "ours"},      {"scene", object.name},        {"vertices", counts.vertices},
                {"lines", counts.lines}, {"polygons", counts.polygons}, {"boundary_lines", counts.boundaryLines}};
  if (object.paperLow_kHz > 0) {
    record["paper_rate_low_kHz"] = object.paperLow_kHz;
    record["paper_rate_high_kHz"] = object.paperHigh_kHz;
  }
  record["blocks"] = rates.complete_kHz.count();
  record["complete_step_rate_kHz"] = rates.complete_kHz.quantile(0.5);
  record["complete_step_rate_per_processor_s_kHz"] = rates.processor_kHz.quantile(0.5);
  record["complete_step_to_12_polygons_ratio"] = rates.ratio.quantile(0.5);
  record["complete_step_to_12_polygons_p10_ratio"] = rates.ratio.quantile(0.1);
  record["complete_step_to_12_polygons_p90_ratio"] = rates.ratio.quantile(0.9);
  if (!rates.bare_kHz.empty()) {
    record["bare_step_rate_kHz"] = rates.bare_kHz.quantile(0.5);
    record["bare_step_to_12_polygons_ratio"] = rates.bareRatio.quantile(0.5);
  }
  record["contact_ticks_ratio"] = rates.contactTicks / rates.ticks;
  record["ticks"] = rates.ticks;
  record["viewer_held_the_scene"] = rates.viewerHeld;
  record["viewer_frames_per_s"] = run.viewer_Hz;
  record["complete"] = run.complete;
  const bool judged = counts.polygons == 64'800;
  record["pass"] = rates.measured() && (!judged || rates.ratio.quantile(0.5) >= kMinRatio);
  return record;
}

void printTable(const std::vector<Record>& records) {
  std::printf("%-20s %9s %9s %9s  %10s  %15s  %17s  %5s %13s  %9s  %5s\n", "", "vertices", "lines", "polygons",
              "paper, kHz", "whole step, kHz", "same on own clock", "ratio", "(p10 to p90)", "bare, kHz", "ratio");
  for (const Record& r : records) {
    char paper[32] = "";
    if (r.contains("paper_rate_low_kHz")) {
      std::snprintf(paper, sizeof paper, "%g to %g", r["paper_rate_low_kHz"].get<double>(),
                    r["paper_rate_high_kHz"].get<double>());
    }
    std::printf("%-20s %9d %9d %9d  %10s  %15.0f  %17.0f  %5.3f (%.3f-%.3f)  %9.0f  %5.3f%s\n",
                r["scene"].get<std::string>().c_str(), r["vertices"].get<int>(), r["lines"].get<int>(),
                r["polygons"].get<int>(), paper, r["complete_step_rate_kHz"].get<double>(),
                r["complete_step_rate_per_processor_s_kHz"].get<double>(),
                r["complete_step_to_12_polygons_ratio"].get<double>(),
                r["complete_step_to_12_polygons_p10_ratio"].get<double>(),
                r["complete_step_to_12_polygons_p90_ratio"].get<double>(), r.value("bare_step_rate_kHz", 0.0),
                r.value("bare_step_to_12_polygons_ratio", 0.0), r["pass"].get<bool>() ? "" : "  FAIL");
  }
}

}  // namespace haptics::eval
