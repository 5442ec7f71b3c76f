#include "graphics_client/ros2/edit_service.h"

#include <chrono>
#include <cstdint>
#include <string_view>
#include <thread>
#include <utility>

#include "common/wire/convert.h"
#include "common/wire/framing.h"
#include "graphics_client/mirror/edit_reply.h"
#include "graphics_client/ros2/message_parts.h"

namespace haptics {
namespace {

constexpr dds::Qos kServiceQos{.depth = 10};  // of ROS 2's own services

/// Whose answer it is.
struct Call {
  std::uint64_t caller;
  std::int64_t number;
};

std::string inLines(const v1::Accepted& accepted) {
  std::string lines;
  for (const std::string& line : accepted.report()) lines += (lines.empty() ? "" : "\n") + line;
  return lines;
}

}  // namespace

struct EditService::Replies {
  Replies(const dds::Participant& participant, const std::string& name)
      : writer(participant, dds::TopicName::repliesOf(name), kServiceQos) {}

  /// Who asks has a reader too, which may be found a moment after its writer; what is written before is lost to it.
  void awaitReaders(dds_entity_t requests) const {
    constexpr int kLooks = 20;
    constexpr std::chrono::milliseconds kLook{10};
    for (int i = 0; i < kLooks && !dds::allAreHeardBy(requests, writer.get()); ++i) std::this_thread::sleep_for(kLook);
  }
  void felt(const Call& call, std::uint64_t revision, std::uint64_t tick, const std::string& report) {
    send({call.caller, call.number, true, ros2::text(report), revision, tick});
  }
  void refused(const Call& call, const std::string& why) {
    send({call.caller, call.number, false, ros2::text(why), 0, 0});
  }

 private:
  dds::Writer<ros2::EditResponse> writer;

  void send(const ros2::EditResponse& response) {
    writer.write(response);
    writer.flush();
  }
};

EditService::EditService(const dds::Participant& participant, const std::string& name, ServerLink& link)
    : link_(link),
      replies_(std::make_shared<Replies>(participant, name)),
      subscription_(participant, dds::TopicName::requestsTo(name), kServiceQos,
                    [this](const ros2::EditRequest& request) { take(request); }) {}

void EditService::take(const ros2::EditRequest& request) {
  const Call call{request.caller, request.number};
  replies_->awaitReaders(subscription_.get());
  const auto view = link_.latest();
  if (view->link != LinkState::kLive) return replies_->refused(call, view->linkText);
  if (std::string_view(request.scene).size() > kMaxFrameBytes)
    return replies_->refused(call, "scene: longer than " + std::to_string(kMaxFrameBytes) + " bytes");
  auto edit = parseSceneText(request.scene, "scene");
  if (!edit) return replies_->refused(call, edit.error().text());
  // On the link's thread, one after another.
  const auto accepted = std::make_shared<v1::Accepted>();
  const auto replied = [replies = replies_, call, accepted](const v1::EditReply& reply) {
    const auto outcome = outcomeOf(reply);
    if (!outcome) return replies->refused(call, outcome.error().text());
    *accepted = *outcome;
  };
  const auto live = [replies = replies_, call, accepted](const v1::EditLive& news) {
    replies->felt(call, accepted->revision(), news.tick(), inLines(*accepted));
  };
  const auto lost = [replies = replies_, call] { replies->refused(call, "the server has restarted without it"); };
  link_.submit(*std::move(edit), {replied, live, lost, {}});
}

}  // namespace haptics
