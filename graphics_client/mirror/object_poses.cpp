#include "graphics_client/mirror/object_poses.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "common/clock/monotonic.h"
#include "common/text/printable.h"
#include "common/wire/convert.h"
#include "graphics_client/mirror/edit_reply.h"

namespace haptics {
namespace {

constexpr std::uint64_t kBetweenWords_ns = 1'000'000'000;

}  // namespace

// Replies come on the link's thread, also after the owner has gone.
struct ObjectPoses::Stream {
  ServerLink& link;
  Say say;
  std::mutex mutex;  // guards what follows
  std::map<std::string, Pose, std::less<>> waiting;
  std::set<std::string, std::less<>> refused;  // last; each goes alone, for what is beside it is refused with it
  std::string lastAlone;
  bool wasAlone = false;
  bool inFlight = false;
  bool isOver = false;
  std::uint64_t quietUntil_ns = 0;

  Stream(ServerLink& l, Say s) : link(l), say(std::move(s)) {}

  void complain(const std::string& words) {
    const std::uint64_t now_ns = monotonicNow_ns();
    {
      const std::lock_guard lock(mutex);
      if (isOver || now_ns < quietUntil_ns) return;
      quietUntil_ns = now_ns + kBetweenWords_ns;
    }
    say(printable(words));
  }

  /// Taken out of `waiting`, which is not empty: all that were not refused, and one that was, in turn.
  std::map<std::string, Pose, std::less<>> next() {
    const auto wasRefused = [this](const auto& entry) { return refused.contains(entry.first); };
    auto alone = std::find_if(waiting.upper_bound(lastAlone), waiting.end(), wasRefused);
    if (alone == waiting.end()) alone = std::find_if(waiting.begin(), alone, wasRefused);
    const bool isAny = alone != waiting.end();
    wasAlone = isAny && (!wasAlone || std::all_of(waiting.begin(), waiting.end(), wasRefused));
    std::map<std::string, Pose, std::less<>> taken;
    if (wasAlone) {
      lastAlone = alone->first;
      taken.insert(waiting.extract(alone));
      return taken;
    }
    for (auto at = waiting.begin(); at != waiting.end();) {
      const auto here = at++;
      if (!wasRefused(*here)) taken.insert(waiting.extract(here));
    }
    return taken;
  }

  void note(const std::vector<std::string>& sent, bool accepted) {
    const std::lock_guard lock(mutex);
    for (const std::string& name : sent) {
      if (accepted) {
        refused.erase(name);
      } else {
        refused.insert(name);
      }
    }
  }

  static void sendNext(const std::shared_ptr<Stream>& self) {
    v1::Transaction transaction;
    std::vector<std::string> sent;
    {
      const std::lock_guard lock(self->mutex);
      self->inFlight = !self->isOver && !self->waiting.empty();
      if (!self->inFlight) return;
      for (const auto& [object, pose] : self->next()) {
        v1::SetPose& set = *transaction.add_operations()->mutable_set_pose();
        set.mutable_object()->set_name(object);
        toWire(pose, *set.mutable_pose());
        set.set_kinematic(true);
        sent.push_back(object);
      }
    }
    const auto replied = [self, sent = std::move(sent)](const v1::EditReply& reply) {
      const auto outcome = outcomeOf(reply);
      self->note(sent, outcome.has_value());
      if (!outcome) self->complain("an object's pose was refused: " + outcome.error().text());
      sendNext(self);
    };
    self->link.submit(std::move(transaction), {.replied = replied, .live = {}});
  }
};

ObjectPoses::ObjectPoses(ServerLink& link, Say say) : stream_(std::make_shared<Stream>(link, std::move(say))) {}

ObjectPoses::~ObjectPoses() {
  const std::lock_guard lock(stream_->mutex);
  stream_->isOver = true;
}

void ObjectPoses::set(std::string_view object, const Pose& pose) {
  std::string name(object);
  const double length = glm::length(pose.rotation);
  if (!isFinite(pose) || !std::isfinite(length) || length <= 0)
    return refuse(object, "finite numbers and a rotation other than 0 are needed");
  if (!stream_->link.latest()->scene->find(name)) return refuse(object, "the scene has no such object");
  {
    const std::lock_guard lock(stream_->mutex);
    stream_->waiting[std::move(name)] = {pose.rotation * (1 / length), pose.position};
    if (stream_->inFlight) return;
    stream_->inFlight = true;
  }
  Stream::sendNext(stream_);
}

void ObjectPoses::refuse(std::string_view object, const std::string& why) {
  stream_->complain("the pose of \"" + std::string(object) + "\" is not taken: " + why);
}

}  // namespace haptics
