#include "graphics_client/ros2/wrench_topic.h"

#include <chrono>
#include <string_view>
#include <utility>

#include "common/clock/monotonic.h"
#include "common/wire/convert.h"
#include "common/wire/parts.h"
#include "graphics_client/ros2/message_parts.h"

namespace haptics {
namespace {

constexpr std::chrono::milliseconds kBetween{1};
constexpr std::uint64_t kBetweenWords_ns = 1'000'000'000;

}  // namespace

WrenchTopic::WrenchTopic(const dds::Participant& participant, const std::string& topic, std::size_t hand,
                         ServerLink& link, Say say)
    : link_(link),
      hand_(hand),
      topic_(topic),
      say_(std::move(say)),
      subscription_(
          participant, topic, {dds::Reliability::kBestEffort, 1},
          [this](const ros2::WrenchStamped& message) { take(message); }, kBetween) {}

void WrenchTopic::take(const ros2::WrenchStamped& message) {
  if (std::string_view(message.header.frame_id) != ros2::kWorld) return refuse("its frame has to be \"world\"");
  if (!link_.latest()->mayEdit) return refuse("the server takes one from an editor alone (--credentials)");
  const auto& [force, torque] = message.wrench;
  v1::AddWrench asked;
  toWire(Vec3(force.x, force.y, force.z), *asked.mutable_force_n());
  toWire(Vec3(torque.x, torque.y, torque.z), *asked.mutable_torque_nm());
  const auto wrench = fromWire(asked);
  if (!wrench) return refuse(wrench.error().text());
  link_.addWrench(hand_, *wrench);
}

void WrenchTopic::refuse(const std::string& why) {
  const std::uint64_t now_ns = monotonicNow_ns();
  if (now_ns < quietUntil_ns_) return;
  quietUntil_ns_ = now_ns + kBetweenWords_ns;
  say_("a wrench of " + topic_ + " is not taken: " + why);
}

}  // namespace haptics
