#include "haptic_server/scene/edit_memory.h"

#include <algorithm>
#include <utility>

namespace haptics {

EditDeduplicator::Lookup EditDeduplicator::find(SessionId session, std::uint64_t clientSeq) const {
  const auto at = sessions_.find(session);
  if (at == sessions_.end()) return {};
  const SessionResults& known = at->second.known;
  const auto result = std::ranges::find(known.results, clientSeq, &Result::clientSeq);
  if (result != known.results.end()) return {Answer::kApplied, *result};
  if (clientSeq <= known.forgottenUpTo) return {Answer::kForgotten, {}};
  const bool superseded = !known.results.empty() && clientSeq < known.results.back().clientSeq;
  return {superseded ? Answer::kSuperseded : Answer::kNew, {}};
}

void EditDeduplicator::remember(SessionId session, const Result& result) {
  const auto at = sessions_.find(session);
  if (at == sessions_.end()) return remember(SessionResults{session, 0, {result}});
  auto& [known, lastEdit] = at->second;
  byLastEdit_.erase(lastEdit);
  lastEdit = ++edits_;
  byLastEdit_[lastEdit] = session;
  known.results.push_back(result);
  if (known.results.size() > kResultsPerSession) {
    known.forgottenUpTo = std::max(known.forgottenUpTo, known.results.front().clientSeq);
    known.results.pop_front();
  }
}

void EditDeduplicator::remember(SessionResults session) {
  const SessionId id = session.session;
  sessions_[id] = {std::move(session), ++edits_};
  byLastEdit_[edits_] = id;
  if (sessions_.size() > kSessions) {
    sessions_.erase(byLastEdit_.begin()->second);
    byLastEdit_.erase(byLastEdit_.begin());
  }
}

std::vector<EditDeduplicator::SessionResults> EditDeduplicator::sessions() const {
  std::vector<SessionResults> sessions;
  for (const auto& [lastEdit, id] : byLastEdit_) sessions.push_back(sessions_.at(id).known);
  return sessions;
}

}  // namespace haptics
