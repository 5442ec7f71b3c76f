#include "haptic_server/scene/edit_memory.h"

#include <algorithm>
#include <utility>

namespace haptics {

EditMemory::Lookup EditMemory::find(SessionId session, std::uint64_t clientSeq) const {
  const auto at = sessions_.find(session);
  if (at == sessions_.end()) return {};
  const auto& [known, age] = at->second;
  const auto result = std::ranges::find(known.results, clientSeq, &Result::clientSeq);
  if (result != known.results.end()) return {Answer::kApplied, *result};
  return {clientSeq <= known.forgottenUpTo ? Answer::kForgotten : Answer::kNew, {}};
}

void EditMemory::remember(SessionId session, const Result& result) {
  const auto at = sessions_.find(session);
  if (at == sessions_.end()) return remember(SessionResults{session, 0, {result}});
  auto& [known, age] = at->second;
  byAge_.splice(byAge_.end(), byAge_, age);
  known.results.push_back(result);
  if (known.results.size() > kResultsPerSession) {
    known.forgottenUpTo = std::max(known.forgottenUpTo, known.results.front().clientSeq);
    known.results.pop_front();
  }
}

void EditMemory::remember(SessionResults session) {
  const SessionId id = session.session;
  sessions_[id] = {std::move(session), byAge_.insert(byAge_.end(), id)};
  if (sessions_.size() > kSessions) {
    sessions_.erase(byAge_.front());
    byAge_.pop_front();
  }
}

std::vector<EditMemory::SessionResults> EditMemory::sessions() const {
  std::vector<SessionResults> sessions;
  for (const SessionId id : byAge_) sessions.push_back(sessions_.at(id).known);
  return sessions;
}

}  // namespace haptics
