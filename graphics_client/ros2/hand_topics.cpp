#include "graphics_client/ros2/hand_topics.h"

#include "graphics_client/ros2/message_parts.h"

namespace haptics {
namespace {

/// Longer pauses of the ticks begin the velocity anew.
constexpr std::uint64_t kLongestGap_ticks = 100;
constexpr int kButtons = 32;  // bits of DeviceStatus::buttons

std::string named(const HandTopicOptions& options, const char* ours, const char* crtk) {
  return options.name + "/" + (options.crtkNames ? crtk : ours);
}

dds::Qos everyTick(const HandTopicOptions& options) { return {options.reliability, HandTopics::kDepth}; }

}  // namespace

HandTopics::HandTopics(const dds::Participant& participant, const HandTopicOptions& options)
    : pose_(participant, named(options, "pose", "measured_cp"), everyTick(options)),
      ihip_(participant, options.name + "/ihip", everyTick(options)),
      twist_(participant, named(options, "twist", "measured_cv"), everyTick(options)),
      wrench_(participant, named(options, "wrench", "measured_cf"), everyTick(options)),
      contact_(participant, options.name + "/contact", everyTick(options)),
      joy_(participant, options.name + "/joy", everyTick(options)),
      gripper_(participant, named(options, "gripper", "gripper/measured_js"), everyTick(options)),
      touched_(participant, options.name + "/touched", {.depth = 1, .transientLocal = true}) {}

void HandTopics::publish(std::int64_t stamp_ns, double period_s, const TelemetrySample& sample,
                         const std::optional<ToolState>& tool, const std::string& touched) {
  const ros2::Header header = ros2::header(stamp_ns);
  const ros2::Quaternion turned = ros2::quaternion(tool ? tool->deviceRotation : Quat(1, 0, 0, 0));
  const ros2::Vector3 torque = ros2::vector3(tool ? tool->written_Nm : Vec3(0)), none = {};
  count(pose_.writeToReaders({header, {ros2::point(sample.hip), turned}}));
  count(twist_.writeToReaders({header, {ros2::vector3(velocityAt(sample, period_s)), none}}));
  count(wrench_.writeToReaders({header, {ros2::vector3(sample.force.written), torque}}));
  count(ihip_.writeToReaders({header, {ros2::point(sample.ihip), turned}}));
  count(contact_.writeToReaders({header, {ros2::vector3(sample.force.contact), none}}));
  std::vector<std::int32_t> buttons(kButtons);
  for (int i = 0; i < kButtons; ++i)
    buttons[static_cast<std::size_t>(i)] = static_cast<std::int32_t>((sample.device.buttons >> i) & 1);
  count(joy_.writeToReaders({header, {}, ros2::sequenceOf<dds_sequence_long>(buttons)}));
  if (sample.handle.has(HandleReading::kGripper)) {
    std::vector<char*> names{ros2::text("gripper")};
    std::vector<double> angles{sample.handle.gripper_rad};
    count(gripper_.writeToReaders(
        {header, ros2::sequenceOf<dds_sequence_string>(names), ros2::sequenceOf<dds_sequence_double>(angles), {}, {}}));
  }
  if (touched != lastTouched_) {
    count(touched_.write({ros2::text(touched)}));
    lastTouched_ = touched;
  }
}

void HandTopics::flush() {
  pose_.flush();
  ihip_.flush();
  twist_.flush();
  wrench_.flush();
  contact_.flush();
  joy_.flush();
  gripper_.flush();
  touched_.flush();
}

Vec3 HandTopics::velocityAt(const TelemetrySample& sample, double period_s) {
  const std::uint64_t since = sample.tick - lastTick_;
  if (lastTick_ == 0 || sample.tick <= lastTick_ || since > kLongestGap_ticks) {
    velocity_ = VelocityEstimator(period_s);
    velocity_.reset(sample.hip);
  } else {
    velocity_.skip(since - 1);
    velocity_.update(sample.hip);
  }
  lastTick_ = sample.tick;
  return sample.handle.has(HandleReading::kVelocity) ? sample.handle.velocity : velocity_.velocity();
}

}  // namespace haptics
