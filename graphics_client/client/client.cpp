#include "graphics_client/client/client.h"

#include <atomic>
#include <chrono>
#include <future>
#include <mutex>
#include <optional>
#include <utility>

#include "common/clock/monotonic.h"
#include "common/telemetry/tick_gaps.h"
#include "common/wire/convert.h"
#include "graphics_client/mirror/edit_reply.h"
#include "graphics_client/mirror/object_poses.h"
#include "graphics_client/mirror/server_link.h"

namespace haptics {
namespace {

[[nodiscard]] Client::Vector vectorOf(Vec3 v) noexcept { return {v.x, v.y, v.z}; }

template <class T>
[[nodiscard]] T valueOf(Result<T> result, const std::string& option) {
  if (!result) throw Refused(option + ": " + result.error().text());
  return *std::move(result);
}

[[nodiscard]] TicksCallback tickByTick(const std::function<void(const Client::Tick&)>& onTick) {
  return [onTick, gaps = TickGaps()](const v1::TelemetryBatch& batch) mutable {
    for (const v1::Telemetry& message : batch.sample()) {
      const TelemetrySample sample = fromWire(message);
      const TickGap gap = gaps.next(sample.tick, sample.missedTicks).value_or(TickGap{});
      onTick({sample.tick, sample.time_ns, vectorOf(sample.hip), vectorOf(sample.ihip), vectorOf(sample.force.written),
              sample.object, gap.missed, gap.lost});
    }
  };
}

[[nodiscard]] ServerLink::Options linkOptions(const Client::Options& options) {
  ServerLink::Options link;
  link.server = valueOf(parseEndpoint(options.server), "server");
  link.clientName = options.name;
  if (!options.credentials.empty())
    link.credentials = valueOf(readClientCredentials(options.credentials), "credentials");
  link.telemetryRate_Hz = options.telemetryRate_Hz;
  link.fetchAssets = false;
  if (options.onTick) link.onTicks = tickByTick(options.onTick);
  return link;
}

/// What is heard of one edit. Shared with the link's thread.
struct Answers {
  std::promise<v1::EditReply> reply;
  std::promise<std::optional<v1::EditLive>> live;  // nothing: the server has restarted without it
  std::atomic<std::uint64_t> heard_ns = monotonicNow_ns();
};

}  // namespace

struct Client::Impl {
  explicit Impl(const Options& options)
      : timeout(std::chrono::nanoseconds(static_cast<std::int64_t>(options.timeout_s * 1e9))),
        link(linkOptions(options)) {}

  std::chrono::nanoseconds timeout;
  ServerLink link;
  std::mutex mutex;  // guards what was said of poses
  std::string poseRefused;
  ObjectPoses poses{link, [this](const std::string& why) {
                      const std::lock_guard lock(mutex);
                      poseRefused = why;
                    }};

  [[noreturn]] void noConnection(const std::string& what) const { throw NoConnection(what + link.latest()->linkText); }

  /// For the timeout since it was last heard of.
  template <class T>
  [[nodiscard]] T await(std::future<T> answer, const std::atomic<std::uint64_t>& heard_ns,
                        const std::string& what) const {
    constexpr std::chrono::milliseconds kLook{50};
    while (answer.wait_for(kLook) != std::future_status::ready) {
      if (monotonicNow_ns() - heard_ns > static_cast<std::uint64_t>(timeout.count())) noConnection(what);
    }
    return answer.get();
  }
};

Client::Client(const Options& options) : impl_(std::make_unique<Impl>(options)) {
  const auto settled = [](const MirrorView& view) {
    return view.link == LinkState::kLive || view.link == LinkState::kRefused;
  };
  const auto view = impl_->link.waitUntil(settled, impl_->timeout);
  if (!view || view->link == LinkState::kRefused) impl_->noConnection(options.server + ": ");
}

Client::~Client() = default;
Client::Client(Client&&) noexcept = default;
Client& Client::operator=(Client&&) noexcept = default;

Client::State Client::state() const {
  const auto view = impl_->link.latest();
  State state;
  state.connected = view->link == LinkState::kLive;
  state.connection = view->linkText;
  state.revision = view->scene->revision();
  state.device = view->device;
  for (const auto& object : view->scene->objects()) {
    const Pose pose = view->poseOf(*object);
    const Quat& q = pose.rotation;
    state.bodies.push_back({object->id, object->name, vectorOf(pose.position), {q.w, q.x, q.y, q.z}});
  }
  if (!view->sample) return state;
  const TelemetrySample& sample = *view->sample;
  state.tick = sample.tick;
  state.age_s = view->telemetryAgeAt_s(monotonicNow_ns());
  state.hip_m = vectorOf(sample.hip);
  state.ihip_m = vectorOf(sample.ihip);
  state.force_N = vectorOf(sample.force.written);
  state.touched = sample.object;
  return state;
}

Client::Applied Client::apply(const std::string& edit) {
  auto transaction = parseSceneText(edit, "edit");
  if (!transaction) throw Refused(transaction.error().text());
  const auto answers = std::make_shared<Answers>();
  impl_->link.submit(*std::move(transaction),
                     {[answers](const v1::EditReply& reply) { answers->reply.set_value(reply); },
                      [answers](const v1::EditLive& live) { answers->live.set_value(live); },
                      [answers] { answers->live.set_value(std::nullopt); },
                      [answers](const v1::EditProgress&) { answers->heard_ns = monotonicNow_ns(); }});
  const auto accepted =
      outcomeOf(impl_->await(answers->reply.get_future(), answers->heard_ns, "no answer to the edit: "));
  if (!accepted) throw Refused(accepted.error().text());
  const std::string revision = "accepted as revision " + std::to_string(accepted->revision());
  auto heard = answers->live.get_future();
  if (heard.wait_for(impl_->timeout) != std::future_status::ready)
    throw NoConnection(revision + ", but the servo has not taken it up in time");
  const auto felt = heard.get();
  if (!felt) throw NoConnection(revision + ", but the server has restarted without its state");
  return {accepted->revision(), felt->tick(), {accepted->report().begin(), accepted->report().end()}};
}

void Client::drive(const std::string& body, const Vector& position_m, const std::array<double, 4>& rotation) {
  {
    const std::lock_guard lock(impl_->mutex);
    if (!impl_->poseRefused.empty()) throw Refused(std::exchange(impl_->poseRefused, {}));
  }
  const auto& [w, x, y, z] = rotation;
  impl_->poses.set(body, {Quat(w, x, y, z), Vec3(position_m[0], position_m[1], position_m[2])});
}

}  // namespace haptics
