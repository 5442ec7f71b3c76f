#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "common/error/error.h"
#include "common/telemetry/motion_state.h"
#include "common/telemetry/telemetry_sample.h"
#include "common/telemetry/tick_gaps.h"
#include "graphics_client/mirror/mirror_view.h"

// A session as data: what comes from a recording or a server, in order, and whoever writes it into a file. SI units, the
// server's world frame (right-handed).
namespace haptics {

/// What is the same all the time.
struct SessionFacts {
  std::string source;              ///< File of the recording, or the server's address.
  std::string server;              ///< Name and version.
  std::string device;              ///< Of the first hand.
  std::string secondDevice;        ///< Empty: there is one hand.
  double rate_Hz = 0;              ///< Nominal, of the servo.
  double maxForce_N = 0;           ///< The device's limit.
  std::int64_t began_unix_ns = 0;  ///< When the first tick was.
};

/// One tick. Valid during the call.
struct SessionTick {
  const TelemetrySample& sample;
  const TelemetrySample* second;     ///< Of the second hand; null: there is none.
  const ToolState& tool;             ///< That the first hand holds; object 0: none.
  std::span<const BodyState> moved;  ///< Bodies whose pose or condition is another than in the ticks before.
  const MotionState* dents;          ///< Null: dents are as in the last call.
};

struct SessionEnd {
  std::uint64_t ticks = 0;
  std::uint64_t missed = 0;  ///< Ticks that the servo slept through.
  std::uint64_t lost = 0;    ///< Ticks that were computed and are not here.
  std::string note;          ///< Why it is not whole, or not what was recorded; empty: it is.
};

/// Writes a session. Every method is refused where the file cannot be written, and the file is of no use then.
class SessionSink {
 public:
  virtual ~SessionSink() = default;
  /// A scene that the servo felt first in the tick that comes next. `view` holds its objects and their meshes.
  [[nodiscard]] virtual Result<void> scene(std::uint64_t tick, const MirrorView& view) = 0;
  [[nodiscard]] virtual Result<void> add(const SessionTick& tick) = 0;
  /// Before the tick that comes next.
  [[nodiscard]] virtual Result<void> gap(const TickGap& gap) = 0;
  [[nodiscard]] virtual Result<void> finish(const SessionEnd& end) = 0;
};

}  // namespace haptics
