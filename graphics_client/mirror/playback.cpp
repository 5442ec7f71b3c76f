#include "graphics_client/mirror/playback.h"

#include <algorithm>
#include <utility>

namespace haptics {
namespace {

double time_s(const MirrorView& view, const MirrorView& since) {
  return 1e-9 * (static_cast<double>(view.sample->time_ns) - static_cast<double>(since.sample->time_ns));
}

/// What is felt goes over from one sample to the next as a whole; only where things are is between them.
TelemetrySample between(const TelemetrySample& a, const TelemetrySample& b, double s) {
  TelemetrySample sample = s < 0.5 ? a : b;
  sample.hip = glm::mix(a.hip, b.hip, s);
  if (a.object != b.object) return sample;
  sample.ihip = glm::mix(a.ihip, b.ihip, s);
  sample.stickingPoint = glm::mix(a.stickingPoint, b.stickingPoint, s);
  sample.force.written = glm::mix(a.force.written, b.force.written, s);
  return sample;
}

}  // namespace

std::shared_ptr<const MirrorView> Playback::at(View view, std::uint64_t now_ns) {
  if (!view->sample || view->bodies.empty()) {
    past_.clear();
    return view;
  }
  remember(view);
  const double age_s = view->telemetryAgeAt_s(now_ns);
  followAge(age_s, now_ns);
  const MirrorView& newest = *past_.back();
  const double moment_s = age_s - lag_s_;  // against the newest sample
  if (past_.size() < 2 || moment_s >= 0) return view;

  const auto after =
      std::find_if(past_.begin() + 1, past_.end(), [&](const View& v) { return time_s(*v, newest) >= moment_s; });
  const MirrorView& a = **(after - 1);
  const MirrorView& b = **after;
  const double s = std::clamp((moment_s - time_s(a, newest)) / time_s(b, a), 0.0, 1.0);
  auto shown = std::make_shared<MirrorView>(*view);
  shown->sample = between(*a.sample, *b.sample, s);
  shown->dents = (s < 0.5 ? a : b).dents;
  shown->telemetryAge_s = lag_s_;
  shown->takenAt_ns = now_ns;
  for (auto& [object, body] : shown->bodies) {
    const auto from = a.bodies.find(object);
    const auto to = b.bodies.find(object);
    const bool known = from != a.bodies.end() && to != b.bodies.end();
    if (known && !(from->second.pose == to->second.pose)) {
      body.pose = interpolate(from->second.pose, to->second.pose, s);
    }
  }
  return shown;
}

void Playback::remember(const View& view) {
  constexpr std::size_t kKept = 16;
  if (!past_.empty()) {
    const MirrorView& last = *past_.back();
    if (last.epoch == view->epoch && last.sample->tick == view->sample->tick) {
      past_.back() = view;  // of the same moment, with what else is new
      return;
    }
    if (last.epoch != view->epoch || time_s(*view, last) <= 0) past_.clear();
  }
  past_.push_back(view);
  if (past_.size() > kKept) past_.pop_front();
}

void Playback::followAge(double age_s, std::uint64_t now_ns) {
  const auto memory_ns = static_cast<std::uint64_t>(1e9 * kLagMemory_s);
  const double since_s = ages_.empty() ? 0 : 1e-9 * static_cast<double>(now_ns - ages_.back().when_ns);
  while (!ages_.empty() && now_ns - ages_.front().when_ns > memory_ns) ages_.pop_front();
  ages_.push_back({now_ns, age_s});
  const double oldest_s = std::ranges::max(ages_, {}, &Age::age_s).age_s;
  lag_s_ = std::min(std::max(oldest_s, lag_s_ - kCatchUp * since_s), kMostLag_s);
}

}  // namespace haptics
