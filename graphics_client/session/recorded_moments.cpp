#include "graphics_client/session/recorded_moments.h"

#include <algorithm>
#include <utility>

namespace haptics {
namespace {

/// Times are quotients of whole ticks.
constexpr double kRounding_s = 1e-9;

}  // namespace

bool RecordedMoments::wants(double time_s) const {
  return list_.empty() || time_s >= list_.back().time_s + interval_s_ - kRounding_s;
}

void RecordedMoments::add(RecordedMoment moment) {
  list_.push_back(std::move(moment));
  bytes_ += bytesOf(list_.size() - 1);
  while (bytes_ > maxBytes_ && list_.size() > 2) thinOut();
}

std::size_t RecordedMoments::indexAt(double time_s) const {
  const auto after = std::ranges::upper_bound(list_, time_s + kRounding_s, {},
                                              [](const RecordedMoment& moment) { return moment.time_s; });
  return after == list_.begin() ? 0 : static_cast<std::size_t>(after - list_.begin()) - 1;
}

/// Moments that follow each other share their motion while nothing moves.
std::size_t RecordedMoments::bytesOf(std::size_t index) const {
  const auto& motion = list_[index].motion;
  std::size_t bytes = sizeof(RecordedMoment);
  if (motion && (index == 0 || list_[index - 1].motion != motion)) {
    bytes +=
        sizeof(RecordedMotion) + motion->bodies.size() * sizeof(BodyState) + motion->dents.size() * sizeof(ObjectDent);
  }
  return bytes;
}

void RecordedMoments::thinOut() {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < list_.size(); i += 2) list_[kept++] = list_[i];
  list_.resize(kept);
  interval_s_ *= 2;
  bytes_ = 0;
  for (std::size_t i = 0; i < list_.size(); ++i) bytes_ += bytesOf(i);
}

}  // namespace haptics
