#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <unordered_map>
#include <vector>

#include "common/hash/content_hash.h"
#include "haptic_server/scene/scene_history.h"

namespace haptics {

/// Which edits of which session were applied, so that a resent one is answered and not applied again. Bounded: the
/// last kResultsPerSession of each of the kSessions that edited last. A resend from a forgotten session would be
/// applied twice; at one edit a second from each, a session is remembered for over an hour.
class EditDeduplicator {
 public:
  static constexpr std::size_t kResultsPerSession = 64;
  static constexpr std::size_t kSessions = 4096;

  struct Result {
    std::uint64_t clientSeq = 0;
    std::uint64_t revision = 0;
    ContentHash root;
  };
  enum class Answer { kNew, kApplied, kSuperseded, kForgotten };
  struct Lookup {
    Answer answer = Answer::kNew;
    Result result;  ///< For kApplied.
  };

  /// The remembered edits of one session.
  struct SessionResults {
    SessionId session = kServerSession;
    std::uint64_t forgottenUpTo = 0;  ///< Highest clientSeq dropped from the results.
    std::deque<Result> results;       ///< Oldest first.
  };

  /// kSuperseded: not applied, and a later one was. kForgotten: so old that it may have been applied.
  [[nodiscard]] Lookup find(SessionId session, std::uint64_t clientSeq) const;
  void remember(SessionId session, const Result& result);

  /// Everything, least recent editor first; remembering it in this order makes an equal memory.
  [[nodiscard]] std::vector<SessionResults> sessions() const;
  void remember(SessionResults session);  ///< A session that is not remembered yet, as the most recent editor.

 private:
  struct Session {
    SessionResults known;
    std::uint64_t lastEdit = 0;  // a number that grows with each
  };
  std::unordered_map<SessionId, Session> sessions_;
  std::map<std::uint64_t, SessionId> byLastEdit_;
  std::uint64_t edits_ = 0;
};

}  // namespace haptics
