#include "graphics_client/ros2/bridge.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <vector>

#include "common/clock/monotonic.h"
#include "common/clock/unix_time.h"
#include "common/telemetry/tick_gaps.h"
#include "common/wire/convert.h"
#include "graphics_client/mirror/object_poses.h"
#include "graphics_client/mirror/server_link.h"
#include "graphics_client/mirror/tick_queue.h"
#include "graphics_client/ros2/edit_service.h"
#include "graphics_client/ros2/hand_topics.h"
#include "graphics_client/ros2/message_parts.h"
#include "graphics_client/ros2/scene_topics.h"
#include "graphics_client/ros2/stamp_clock.h"
#include "graphics_client/ros2/wrench_topic.h"

namespace haptics {
namespace {

constexpr std::chrono::milliseconds kLongestWait{20};  // for ticks; the scene may change without any
constexpr std::uint64_t kBetweenLosses_ns = 5'000'000'000;
constexpr const char* kNothing = "";

/// Objects' poses as other programs publish them.
class PoseReader {
 public:
  PoseReader(const dds::Participant& participant, const std::string& name, ServerLink& link, ObjectPoses::Say say)
      : prefix_(name.substr(1) + "/"),
        poses_(link, std::move(say)),
        subscription_(participant, name + "/set_objects", {dds::Reliability::kBestEffort, kDepth},
                      [this](const ros2::TFMessage& message) { take(message); }) {}

 private:
  static constexpr int kDepth = 100;  // of ROS 2's /tf

  std::string prefix_;
  ObjectPoses poses_;
  dds::Subscription<ros2::TFMessage> subscription_;  // its thread ends first

  void take(const ros2::TFMessage& message) {
    for (std::uint32_t i = 0; i < message.transforms._length; ++i) {
      const ros2::TransformStamped& given = message.transforms._buffer[i];
      std::string_view object = given.child_frame_id;
      if (object.starts_with(prefix_)) object.remove_prefix(prefix_.size());
      const auto& [at, turned] = given.transform;
      if (std::string_view(given.header.frame_id) == ros2::kWorld) {
        poses_.set(object, {Quat(turned.w, turned.x, turned.y, turned.z), Vec3(at.x, at.y, at.z)});
      } else {
        poses_.refuse(object, "its frame has to be \"world\"");
      }
    }
  }
};

class Bridge {
 public:
  Bridge(const BridgeOptions& options, const dds::Participant& participant,
         const std::function<void(const std::string&)>& say)
      : options_(options),
        participant_(participant),
        say_(say),
        link_({.server = options.server,
               .clientName = "haptic_ros2",
               .credentials = options.credentials,
               .onTicks = [this](const v1::TelemetryBatch& batch) { queue_.put(batch); }}),
        scene_(participant, options.name),
        poses_(participant, options.name, link_, say),
        edits_(participant, options.name + "/edit", link_) {
    addHand(options.name);
  }

  void run(const std::atomic<bool>& stop) {
    while (!stop) {
      const auto ticks = queue_.take(kLongestWait);
      const auto view = link_.latest();
      if (view->linkText != linkText_) say_(linkText_ = view->linkText);
      learnClock(*view, ticks.empty() ? nullptr : &ticks.back().sample);
      for (const TickQueue::Tick& tick : ticks) publish(*view, tick);
      for (const auto& hand : hands_) hand->flush();
      if (view->link == LinkState::kLive) scene_.update(*view, unixNow_ns(), monotonicNow_ns());
      tellLosses();
    }
  }

 private:
  const BridgeOptions& options_;
  const dds::Participant& participant_;
  const std::function<void(const std::string&)>& say_;
  TickQueue queue_;
  ServerLink link_;  // its thread ends before the queue
  SceneTopics scene_;
  std::vector<std::unique_ptr<HandTopics>> hands_;      // the second one's from when it is there
  std::vector<std::unique_ptr<WrenchTopic>> wrenches_;  // likewise
  PoseReader poses_;
  EditService edits_;
  StampClock clock_;
  TickGaps gaps_;
  std::optional<ToolState> tool_;
  std::string linkText_;
  std::uint64_t lost_ = 0, unwritten_ = 0, quietUntil_ns_ = 0;

  void addHand(const std::string& name) {
    hands_.push_back(
        std::make_unique<HandTopics>(participant_, HandTopicOptions{name, options_.crtkNames, options_.reliability}));
    wrenches_.push_back(std::make_unique<WrenchTopic>(
        participant_, name + (options_.crtkNames ? "/servo_cf" : "/add_wrench"), wrenches_.size(), link_, say_));
  }

  void learnClock(const MirrorView& view, const v1::Telemetry* newest) {
    const std::uint64_t now_ns = monotonicNow_ns();
    const std::int64_t here_ns = unixNow_ns() - static_cast<std::int64_t>(now_ns);  // since 1970 minus monotonic
    if (view.sample) {
      const auto server_ns =
          static_cast<std::int64_t>(view.sample->time_ns) + static_cast<std::int64_t>(view.telemetryAge_s * 1e9);
      clock_.learn(here_ns + static_cast<std::int64_t>(view.takenAt_ns) - server_ns, now_ns);
    } else if (newest != nullptr) {
      clock_.learn(unixNow_ns() - static_cast<std::int64_t>(newest->time_ns()), now_ns);
    }
  }

  void publish(const MirrorView& view, const TickQueue::Tick& tick) {
    const TelemetrySample first = fromWire(tick.sample);
    gaps_.next(first.tick, first.missedTicks);
    if (tick.tellsAll) tool_ = toolFromWire(tick.sample);
    const std::int64_t stamp_ns = clock_.stamp_ns(first.time_ns);
    publish(*hands_[0], view, first, stamp_ns, tool_);
    const auto second = secondHandFromWire(tick.sample);
    if (!second) return;
    if (hands_.size() < 2) addHand(options_.name + "/second");
    TelemetrySample with = *second;
    with.tick = first.tick;
    publish(*hands_[1], view, with, stamp_ns, std::nullopt);
  }

  static void publish(HandTopics& hand, const MirrorView& view, const TelemetrySample& sample, std::int64_t stamp_ns,
                      const std::optional<ToolState>& tool) {
    constexpr double kUsualRate_Hz = 1000;
    const double rate_Hz = view.servoRate_Hz > 0 ? view.servoRate_Hz : kUsualRate_Hz;
    const auto touched = view.scene->find(ObjectId{sample.object});
    hand.publish(stamp_ns, 1 / rate_Hz, sample, tool, touched ? touched->name : kNothing);
  }

  void tellLosses() {
    std::uint64_t unwritten = 0;
    for (const auto& hand : hands_) unwritten += hand->unwritten();
    const std::uint64_t now_ns = monotonicNow_ns();
    if (now_ns < quietUntil_ns_ || (gaps_.lost() == lost_ && unwritten == unwritten_)) return;
    quietUntil_ns_ = now_ns + kBetweenLosses_ns;
    if (gaps_.lost() > lost_) say_(std::to_string(gaps_.lost() - lost_) + " ticks were lost on the way here");
    if (unwritten > unwritten_) say_("DDS did not take " + std::to_string(unwritten - unwritten_) + " messages");
    lost_ = gaps_.lost();
    unwritten_ = unwritten;
  }
};

}  // namespace

Result<void> checkNamespace(const std::string& name) {
  const auto isLetter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
  const auto isDigit = [](char c) { return c >= '0' && c <= '9'; };
  char before = 0;
  for (const char c : name) {
    const bool begins = before == 0 || before == '/';
    const bool fits = before == 0 ? c == '/' : isLetter(c) || (!begins && (isDigit(c) || c == '/'));
    if (!fits)
      return refused("--namespace",
                     "it has to be like /haptics or /lab/left: / before each word of letters, digits and _");
    before = c;
  }
  constexpr std::size_t kLongest = 128;
  if (name.size() < 2 || before == '/' || name.size() > kLongest)
    return refused("--namespace", "it has to be like /haptics, and at most 128 characters long");
  return {};
}

Result<void> runBridge(const BridgeOptions& options, const std::atomic<bool>& stop,
                       const std::function<void(const std::string&)>& say) {
  const auto participant = dds::Participant::join(options.domain, options.interface, options.ddsSettings);
  if (!participant) return tl::unexpected(participant.error());
  std::string where = ", for this machine alone";
  if (!options.interface.empty()) where = ", by the interface " + options.interface;
  if (!options.ddsSettings.empty()) where = ", by what CYCLONEDDS_URI says";
  say("topics below " + options.name + " in DDS domain " + std::to_string(options.domain) + where);
  Bridge(options, *participant, say).run(stop);
  return {};
}

}  // namespace haptics
