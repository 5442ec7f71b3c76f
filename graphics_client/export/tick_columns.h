#pragma once

#include <cstdint>
#include <span>

#include "common/telemetry/motion_state.h"
#include "common/telemetry/telemetry_sample.h"

namespace haptics {

/// What a tick's columns are read from.
struct TickValues {
  const TelemetrySample& sample;
  const ToolState& tool;
};

/// One quantity of a tick, for tables. Either reals or a whole number.
struct TickColumn {
  static constexpr std::size_t kMaxWidth = 7;

  const char* name;   ///< "force.written".
  const char* unit;   ///< "N"; "1": a number without.
  const char* frame;  ///< "world"; empty: it has none.
  const char* description;
  std::size_t width = 1;  ///< Reals: components x, y, z, or as the description says.
  void (*reals)(const TickValues& values, double* at) = nullptr;
  std::uint64_t (*number)(const TickValues& values) = nullptr;
};

/// In the order of a table.
[[nodiscard]] std::span<const TickColumn> tickColumns() noexcept;

}  // namespace haptics
