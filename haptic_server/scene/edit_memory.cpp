#include "haptic_server/scene/edit_memory.h"

#include <algorithm>

namespace haptics {

EditMemory::Lookup EditMemory::find(SessionId session, std::uint64_t clientSeq) const {
  const auto at = sessions_.find(session);
  if (at == sessions_.end()) return {};
  const auto& results = at->second.results;
  const auto known = std::ranges::find(results, clientSeq, &Result::clientSeq);
  if (known != results.end()) return {Answer::kApplied, *known};
  return {clientSeq <= at->second.forgottenUpTo ? Answer::kForgotten : Answer::kNew, {}};
}

void EditMemory::remember(SessionId session, const Result& result) {
  const auto [at, isNew] = sessions_.try_emplace(session);
  Session& known = at->second;
  if (!isNew) byAge_.erase(known.age);
  known.age = byAge_.insert(byAge_.end(), session);
  known.results.push_back(result);
  if (known.results.size() > kResultsPerSession) {
    known.forgottenUpTo = std::max(known.forgottenUpTo, known.results.front().clientSeq);
    known.results.pop_front();
  }
  if (sessions_.size() > kSessions) {
    sessions_.erase(byAge_.front());
    byAge_.pop_front();
  }
}

}  // namespace haptics
