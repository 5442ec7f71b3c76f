#include "haptic_server/net/adoption_tracker.h"

#include <algorithm>
#include <utility>

namespace haptics {

void AdoptionTracker::adopted(std::uint64_t revision, std::uint64_t tick) {
  if (!adoptions_.empty() && revision <= adoptions_.back().revision) return;
  adoptions_.push_back({revision, tick});
  if (adoptions_.size() > kMaxAdoptions) adoptions_.pop_front();
}

void AdoptionTracker::accepted(std::uint64_t clientSeq, std::uint64_t revision) {
  awaited_.push_back({clientSeq, revision});
  if (awaited_.size() > kMaxAwaited) awaited_.pop_front();
}

std::vector<v1::EditLive> AdoptionTracker::take() {
  std::vector<v1::EditLive> live;
  std::deque<Awaited> waiting;
  for (const Awaited& edit : awaited_) {
    const auto felt = std::ranges::lower_bound(adoptions_, edit.revision, {}, &Adoption::revision);
    if (felt == adoptions_.end()) {
      waiting.push_back(edit);
      continue;
    }
    live.emplace_back();
    live.back().set_client_seq(edit.clientSeq);
    live.back().set_revision(edit.revision);
    live.back().set_tick(felt->tick);
  }
  awaited_ = std::move(waiting);
  return live;
}

}  // namespace haptics
