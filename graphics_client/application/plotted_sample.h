#pragma once

#include <numeric>
#include <vector>

#include "common/telemetry/telemetry_sample.h"
#include "graphics_client/application/plot_panel.h"
#include "graphics_client/session/recorded_moments.h"

namespace haptics {

[[nodiscard]] inline PlotPanel::Sample plotted(const TelemetrySample& sample, double time_s) {
  const double energy_J = std::accumulate(sample.energyGiven_J.begin(), sample.energyGiven_J.end(), 0.0);
  return {.time_s = time_s,
          .written_N = glm::length(sample.force.written),
          .spring_N = glm::length(sample.force.spring),
          .friction_N = glm::length(sample.force.friction),
          .texture_N = glm::length(sample.force.texture),
          .depth_mm = 1e3 * sample.penetration_m,
          .energy_mJ = 1e3 * energy_J};
}

/// Of the moments up to that time, as far back as curves go.
[[nodiscard]] inline std::vector<PlotPanel::Sample> plottedUntil(const RecordedMoments& moments, double time_s) {
  std::vector<PlotPanel::Sample> curves;
  const std::size_t last = moments.indexAt(time_s);
  for (std::size_t i = moments.indexAt(time_s - PlotPanel::kShown_s); i <= last; ++i) {
    curves.push_back(plotted(moments.list()[i].sample, moments.list()[i].time_s));
  }
  return curves;
}

}  // namespace haptics
