#pragma once

#include <numeric>

#include "common/telemetry/telemetry_sample.h"
#include "graphics_client/application/plot_panel.h"

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

}  // namespace haptics
