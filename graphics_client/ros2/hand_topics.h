#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/telemetry/motion_state.h"
#include "common/telemetry/telemetry_sample.h"
#include "graphics_client/ros2/dds.h"
#include "graphics_client/ros2/message_types.h"
#include "haptic_server/engine/force/velocity_estimator.h"

namespace haptics {

/// How the topics of a hand are called and sent.
struct HandTopicOptions {
  std::string name;        ///< Namespace, "/haptics".
  bool crtkNames = false;  ///< measured_cp, measured_cv, measured_cf for pose, twist, wrench.
  dds::Reliability reliability = dds::Reliability::kReliable;
};

/// What a hand does and feels in each tick, in seven topics (README.md).
class HandTopics {
 public:
  /// Ticks that are kept for a reader that lost some: two seconds. More is sent again to who stood still so long, and holds up what is new.
  static constexpr int kDepth = 2000;

  HandTopics(const dds::Participant& participant, const HandTopicOptions& options);

  /// @param tool  As last told. @param touched  Name of what the hand touches; empty: nothing.
  void publish(std::int64_t stamp_ns, double period_s, const TelemetrySample& sample,
               const std::optional<ToolState>& tool, const std::string& touched);
  /// What was published is sent: packets of many ticks, which a reader that is held up for a moment has room for.
  void flush();
  /// Messages that DDS did not take.
  [[nodiscard]] std::uint64_t unwritten() const noexcept { return unwritten_; }

 private:
  dds::Writer<ros2::PoseStamped> pose_, ihip_;
  dds::Writer<ros2::TwistStamped> twist_;
  dds::Writer<ros2::WrenchStamped> wrench_, contact_;
  dds::Writer<ros2::Joy> joy_;
  dds::Writer<ros2::JointState> gripper_;
  dds::Writer<ros2::String> touched_;
  VelocityEstimator velocity_;
  std::uint64_t lastTick_ = 0;  // 0: none yet
  std::optional<std::string> lastTouched_;
  std::uint64_t unwritten_ = 0;

  [[nodiscard]] Vec3 velocityAt(const TelemetrySample& sample, double period_s);
  void count(bool written) { unwritten_ += written ? 0 : 1; }
};

}  // namespace haptics
