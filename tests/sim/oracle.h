#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "graphics_client/mirror/mirror.h"
#include "haptic_server/net/server_session.h"
#include "haptic_server/scene/scene_history.h"
#include "haptics/v1/envelope.pb.h"
#include "tests/sim/event_log.h"

// What "two databases, provably equal" means here. In every run, whatever the network, the processes and the memory
// did:
//
//  1. Nothing acknowledged is lost: an edit's acceptance names a revision of the present epoch that is this edit, with
//     that root; a server that restarts with its state still has it. (A server that lost its state says so by a new
//     epoch, and each client's accepted edits that were not yet live hear it.)
//  2. Nothing is applied twice: one edit makes at most one revision of an epoch, however often it was resent, and one
//     that was acknowledged makes none in a later epoch.
//  3. No increment is lost: each read-modify-write adds exactly one to what the object held before it.
//  4. A transaction is atomic: one with an impossible operation in it changes nothing.
//  5. One session's edits take effect in the order in which they were submitted: none is passed over that was not
//     refused before. Those of different sessions may overtake each other, whatever rests on what they find.
//  6. Each edit is answered exactly once. A refusal is for what the edit says, never for when it came.
//  7. Each accepted edit is called live exactly once, not before the servo adopted its revision or a later one.
//  8. Whatever revision a client shows, it has the root that the server gave this revision; within an epoch a client
//     never goes back.
//  9. A client whose memory was corrupted finds it by hash within two heartbeats (and the 3 s by which a connection that
//     counts as alive may delay them), and is repaired by one snapshot. Without corruption there is never a resync.
// 10. Within 5 s of quiet all roots are equal, recomputed from every byte on both sides, and so is every field.
// 11. No session is stuck: soon after the last fault every edit, upload and status request is answered.
// 12. What the server holds for a client that does not read stays within its bound.
// 13. Every message of the server fits a frame, decodes and applies at the client: no connection ends but for silence or
//     a client that reads too slowly or whose token is withdrawn.
// 14. What is submitted while the client's token is withdrawn is not applied as long as it is.
namespace haptics::sim {

/// What a client means by an edit, so that its effect can be judged.
struct Intent {
  enum class Kind { kIncrement, kBlind, kDoomed };
  Kind kind = Kind::kBlind;
  std::vector<std::string> counters = {};  ///< kIncrement: objects whose position.x grows by one.
  std::string target = {};                 ///< kBlind: the object that it is about, if it is about one.
};

/// Looks at everything that happens at the server and at the clients, and writes down what must not be.
class Oracle {
 public:
  /// The log outlives it.
  Oracle(EventLog& log, const SessionLimits& limits) : log_(log), limits_(limits) {}

  // ---- The server ----
  /// After a loss of power the log may end in what is not a torn record: the server then begins an epoch, with the same
  /// state.
  enum class Kept { kNothing, kState, kStateAfterPowerLoss };
  void serverStarted(const SceneHistory& history, Kept kept);
  void committed(SessionId editSession, std::uint64_t clientSeq, const AcceptedEdit& edit);
  /// \param superseded  The server said that it came after later edits of its session.
  void turnedDown(SessionId editSession, std::uint64_t clientSeq, bool superseded);
  /// The edits of this client count for this session.
  void admitted(SessionId session, SessionId editSession);
  void adopted(std::uint64_t revision, std::uint64_t tick);
  void tokensWithdrawn(std::set<std::string> tokens);  ///< All that are at present.
  void serverHolds(std::size_t backlog_bytes);

  // ---- The clients ----
  void clientStarted(SessionId session, const std::string& token);
  void submitted(SessionId session, std::uint64_t clientSeq, Intent intent);
  void replied(SessionId session, const v1::EditReply& reply);
  void live(SessionId session, const v1::EditLive& live);
  void stateLost(SessionId session, std::uint64_t clientSeq);
  void clientDied(SessionId session);
  /// It has no more use for its connection, for this reason.
  void connectionOver(SessionId session, const std::string& why);
  /// After everything that may have changed what a client shows.
  void viewed(SessionId session, const Mirror& mirror);
  /// A byte of the client's memory has flipped in an object that it shows.
  void corrupted(SessionId session);
  /// The client still holds what was corrupted though it could have known for so long.
  void corruptionOverlooked(SessionId session);

  // ---- The end ----
  void quiet(const SceneHistory& history, SessionId session, const MirrorView& view);
  void settled();
  void stuck(SessionId session, std::size_t unanswered);
  void fail(std::string what);

  [[nodiscard]] const std::vector<std::string>& violations() const noexcept { return violations_; }
  struct Counts {
    std::uint64_t edits = 0, accepted = 0, increments = 0, conflicts = 0, refused = 0, live = 0, lostWithState = 0;
    std::uint64_t commits = 0, resyncs = 0, corruptions = 0, starts = 0, stateResets = 0;

    Counts& operator+=(const Counts& other);
  };
  [[nodiscard]] const Counts& counts() const noexcept { return counts_; }

 private:
  using EditId = std::pair<SessionId, std::uint64_t>;
  struct Revision {
    EditId by;
    ContentHash root;
  };
  struct Edit {
    Intent intent;
    bool withdrawn = false;   // the client's token, ever since it was submitted
    bool turnedDown = false;  // by a server, whether or not the client heard it
    int replies = 0;
    int lives = 0;
    bool stateLost = false;
    std::uint64_t acceptedEpoch = 0;  // 0: not acknowledged
    std::uint64_t acceptedRevision = 0;
    std::uint64_t committedEpoch = 0;  // the last
    std::uint64_t committedRevision = 0;
  };
  struct Client {
    const SceneVersion* seen = nullptr;
    std::uint64_t epoch = 0;
    std::uint64_t revision = 0;
    std::uint64_t resyncs = 0;
    std::uint64_t corruptions = 0;
  };

  EventLog& log_;
  const SessionLimits limits_;
  SceneVersion truth_;                                     // of the present epoch: all commits applied
  std::uint64_t epoch_ = 0;                                // of the server that runs, or ran last
  std::map<std::uint64_t, std::vector<Revision>> epochs_;  // revision 0 first
  std::map<EditId, Edit> edits_;
  std::map<SessionId, Client> clients_;
  std::map<SessionId, std::uint64_t> lastCommitted_;  // number, in the present epoch
  std::map<ObjectId, std::string> names_;             // of all objects that there have been in the present epoch
  std::vector<std::map<std::uint64_t, std::uint64_t>> adoptions_;  // of each server process: tick, revision
  std::set<SessionId> dead_;
  std::map<SessionId, SessionId> clientOf_;  // by the session that its edits count for
  std::map<SessionId, std::string> tokens_;
  std::set<std::string> withdrawn_;
  bool anyWithdrawn_ = false;               // so far
  std::uint64_t acknowledgedRevision_ = 0;  // highest of the present epoch
  std::vector<std::string> violations_;
  Counts counts_;

  [[nodiscard]] const Revision* find(std::uint64_t epoch, std::uint64_t revision) const;
  void judgeEffect(const Edit& edit, const std::string& name, const SceneVersion& before, const Commit& commit);
  void judgeAcceptance(Edit& edit, const EditId& id, const v1::Accepted& accepted);
};

}  // namespace haptics::sim
