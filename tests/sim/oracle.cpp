#include "tests/sim/oracle.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

namespace haptics::sim {
namespace {

constexpr std::size_t kEnough = 8;  // violations; what follows from them is of no interest

std::string nameOf(SessionId session) { return "client " + std::to_string(session % 1000); }

std::string nameOf(SessionId session, std::uint64_t seq) { return nameOf(session) + "'s edit " + std::to_string(seq); }

/// Busy or too fast: for when an edit came, not for what it says.
bool isPassing(const v1::Rejected& rejected) { return rejected.field() == "busy" || rejected.field() == "rate"; }

/// From the records alone.
std::vector<ObjectRecord> recordsOf(const SceneVersion& scene) {
  std::vector<ObjectRecord> records;
  for (const auto& object : scene.objects()) records.push_back(*object);
  return records;
}

}  // namespace

void Oracle::fail(std::string what) {
  log_.add([&] { return "VIOLATION: " + what; });
  log_.end();
  if (violations_.size() < kEnough) violations_.push_back(std::move(what));
}

const Oracle::Revision* Oracle::find(std::uint64_t epoch, std::uint64_t revision) const {
  const auto at = epochs_.find(epoch);
  return at == epochs_.end() || revision >= at->second.size() ? nullptr : &at->second[revision];
}

void Oracle::serverStarted(const SceneHistory& history, Kept kept) {
  adoptions_.emplace_back();
  ++counts_.starts;
  if (kept == Kept::kNothing) {
    epoch_ = history.epoch;
    truth_ = history.version;
    epochs_[epoch_] = {{{}, history.version.root()}};
    lastCommitted_.clear();
    names_.clear();
    acknowledgedRevision_ = 0;
    return;
  }
  const std::uint64_t revision = history.version.revision();
  if (history.epoch != epoch_ && kept == Kept::kState)
    return fail("a server that kept its state announces another epoch");
  // What the old process wrote as it died, and had not told anyone.
  for (std::uint64_t next = truth_.revision() + 1; next <= revision; ++next) {
    const auto edit = history.find(next);
    if (!edit) return fail("the restarted server does not remember its revision " + std::to_string(next));
    committed(edit->session, edit->clientSeq, *edit);
    if (edit->session == kServerSession) continue;
    const SessionId session = clientOf_.at(edit->session);
    // What it decided together with this one nobody has heard either.
    const auto end = edits_.lower_bound({session, edit->clientSeq});
    for (auto earlier = edits_.lower_bound({session, 0}); earlier != end; ++earlier) {
      earlier->second.turnedDown = earlier->second.turnedDown || earlier->second.committedEpoch != epoch_;
    }
  }
  if (revision < acknowledgedRevision_) {
    fail("the restarted server stands at revision " + std::to_string(revision) + ", acknowledged was " +
         std::to_string(acknowledgedRevision_));
  }
  const Revision* known = find(epoch_, revision);
  if (known == nullptr || known->root != history.version.root()) {
    fail("the restarted server's revision " + std::to_string(revision) + " is another than before");
  }
  auto& revisions = epochs_[epoch_];
  for (; revisions.size() > revision + 1; revisions.pop_back()) edits_[revisions.back().by].committedEpoch = 0;
  truth_ = history.version;
  if (history.epoch == epoch_) return;
  epochs_[history.epoch] = revisions;
  epoch_ = history.epoch;
}

void Oracle::admitted(SessionId session, SessionId editSession) {
  const SessionId known = clientOf_.try_emplace(editSession, session).first->second;
  if (known != session) fail(nameOf(session) + "'s edits count as those of " + nameOf(known));
}

void Oracle::clientStarted(SessionId session, const std::string& token) { tokens_[session] = token; }

void Oracle::tokensWithdrawn(std::set<std::string> tokens) {
  withdrawn_ = std::move(tokens);
  anyWithdrawn_ = anyWithdrawn_ || !withdrawn_.empty();
  for (auto& [id, edit] : edits_) edit.withdrawn = edit.withdrawn && withdrawn_.contains(tokens_[id.first]);
  log_.add([&] { return std::to_string(withdrawn_.size()) + " tokens are withdrawn"; });
}

void Oracle::committed(SessionId editSession, std::uint64_t clientSeq, const AcceptedEdit& edit) {
  const SessionId session = editSession == kServerSession ? kServerSession : clientOf_.at(editSession);
  ++counts_.commits;
  auto& revisions = epochs_[epoch_];
  if (edit.commit.revision != revisions.size())
    fail("revision " + std::to_string(edit.commit.revision) + " is not the next");
  revisions.push_back({{session, clientSeq}, edit.commit.root});
  for (const ObjectRecord& put : edit.commit.put) {
    if (const auto known = names_.try_emplace(put.id, put.name).first; known->second != put.name) {
      fail("object " + std::to_string(put.id) + " was \"" + known->second + "\" and is now \"" + put.name + "\"");
    }
  }
  const SceneVersion before = truth_;
  const auto after = before.apply(edit.commit);
  if (!after || after->root() != edit.commit.root)
    return fail("revision " + std::to_string(edit.commit.revision) + " does not lead to its root");
  truth_ = *after;
  if (session == kServerSession) return;

  const std::string name = nameOf(session, clientSeq);
  log_.add([&] { return "server: revision " + std::to_string(edit.commit.revision) + " by " + name; });
  Edit& known = edits_[{session, clientSeq}];
  if (known.committedEpoch == epoch_) {
    fail(name + " was applied twice: revisions " + std::to_string(known.committedRevision) + " and " +
         std::to_string(edit.commit.revision));
  }
  if (known.acceptedEpoch != 0 && known.acceptedEpoch != epoch_)
    fail(name + ", acknowledged before the reset, was applied after it");
  known.committedEpoch = epoch_;
  known.committedRevision = edit.commit.revision;
  std::uint64_t& last = lastCommitted_[session];
  if (clientSeq < last) fail(name + " took effect after edit " + std::to_string(last));
  last = std::max(last, clientSeq);
  if (known.withdrawn && withdrawn_.contains(tokens_[session])) fail(name + " was applied without a token");
  judgeEffect(known, name, before, edit.commit);
}

void Oracle::turnedDown(SessionId editSession, std::uint64_t clientSeq, bool superseded) {
  if (editSession == kServerSession) return;
  const SessionId session = clientOf_.at(editSession);
  Edit& edit = edits_[{session, clientSeq}];
  if (superseded && !edit.turnedDown) fail(nameOf(session, clientSeq) + " was passed over by a later one");
  edit.turnedDown = true;
}

void Oracle::judgeEffect(const Edit& edit, const std::string& name, const SceneVersion& before, const Commit& commit) {
  if (edit.intent.kind == Intent::Kind::kDoomed) fail(name + " holds an impossible operation and was applied");
  const auto isPut = [&](const std::string& object) {
    return std::ranges::count(commit.put, object, &ObjectRecord::name) > 0;
  };
  if (!edit.intent.target.empty() && !isPut(edit.intent.target))
    fail(name + " hit another object than " + edit.intent.target);
  for (const std::string& counter : edit.intent.counters) {
    const auto old = before.find(counter);
    const auto put = std::ranges::find(commit.put, counter, &ObjectRecord::name);
    if (!old || put == commit.put.end() || put->pose.position.x != old->pose.position.x + 1) {
      fail(name + " was to add one to " + counter +
           (old ? ", which held " + std::to_string(old->pose.position.x) : "") +
           (put == commit.put.end() ? "" : " and got " + std::to_string(put->pose.position.x)));
    } else {
      ++counts_.increments;
    }
  }
}

void Oracle::adopted(std::uint64_t revision, std::uint64_t tick) { adoptions_.back()[tick] = revision; }

void Oracle::serverHolds(std::size_t backlog_bytes) {
  if (backlog_bytes > limits_.backlog_bytes + limits_.frames.frame_bytes) {
    fail("the server holds " + std::to_string(backlog_bytes) + " bytes for one client");
  }
}

void Oracle::submitted(SessionId session, std::uint64_t clientSeq, Intent intent) {
  ++counts_.edits;
  Edit& edit = edits_[{session, clientSeq}];
  edit.intent = std::move(intent);
  edit.withdrawn = withdrawn_.contains(tokens_[session]);
}

void Oracle::replied(SessionId session, const v1::EditReply& reply) {
  const EditId id{session, reply.client_seq()};
  const std::string name = nameOf(session, reply.client_seq());
  const auto at = edits_.find(id);
  if (at == edits_.end()) return fail(name + " was answered and never submitted");
  Edit& edit = at->second;
  if (++edit.replies > 1) fail(name + " was answered twice");
  if (reply.has_conflict()) ++counts_.conflicts;
  if (reply.has_rejected()) {
    ++counts_.refused;
    if (isPassing(reply.rejected()))
      fail(name + " was refused for good because it came too early: " + reply.rejected().reason());
    log_.add([&] { return name + " was refused: " + reply.rejected().field() + ": " + reply.rejected().reason(); });
  }
  if (reply.has_accepted()) return judgeAcceptance(edit, id, reply.accepted());
  // Until here it might have been applied and its answer lost; a refusal says that it was not, in this epoch.
  if (edit.committedEpoch == epoch_) fail(name + " was applied and answered with a refusal");
}

void Oracle::judgeAcceptance(Edit& edit, const EditId& id, const v1::Accepted& accepted) {
  ++counts_.accepted;
  const std::string name = nameOf(id.first, id.second);
  log_.add([&] { return name + " is acknowledged as revision " + std::to_string(accepted.revision()); });
  edit.acceptedRevision = accepted.revision();
  edit.acceptedEpoch = edit.committedEpoch;
  const Revision* made = find(edit.committedEpoch, accepted.revision());
  if (made == nullptr || made->by != id || made->root.asBytes() != accepted.root()) {
    fail(name + " was acknowledged as revision " + std::to_string(accepted.revision()) + ", which is not it");
  }
  if (edit.committedEpoch == epoch_) acknowledgedRevision_ = std::max(acknowledgedRevision_, accepted.revision());
}

void Oracle::live(SessionId session, const v1::EditLive& live) {
  const std::string name = nameOf(session, live.client_seq());
  Edit& edit = edits_[{session, live.client_seq()}];
  ++counts_.live;
  if (edit.acceptedEpoch == 0) fail(name + " was called live and not accepted");
  if (++edit.lives > 1) fail(name + " was called live twice");
  if (edit.stateLost) fail(name + " was called live after it was called lost");
  if (edit.acceptedEpoch != epoch_) return;  // said by a server that is no more
  // An older process of the same epoch may have said it.
  std::uint64_t felt = 0;
  for (const auto& process : adoptions_) {
    const auto after = process.upper_bound(live.tick());
    if (after != process.begin()) felt = std::max(felt, std::prev(after)->second);
  }
  if (felt < edit.acceptedRevision) {
    fail(name + ", revision " + std::to_string(edit.acceptedRevision) + ", was called live at tick " +
         std::to_string(live.tick()) + ", when the servo felt revision " + std::to_string(felt));
  }
}

void Oracle::stateLost(SessionId session, std::uint64_t clientSeq) {
  Edit& edit = edits_[{session, clientSeq}];
  ++counts_.lostWithState;
  if (edit.acceptedEpoch == 0 || edit.lives > 0 || edit.stateLost || edit.acceptedEpoch == epoch_) {
    fail(nameOf(session, clientSeq) + " was called lost and is not");
  }
  edit.stateLost = true;
}

void Oracle::clientDied(SessionId session) {
  dead_.insert(session);
  clients_.erase(session);
}

void Oracle::connectionOver(SessionId session, const std::string& why) {
  constexpr std::array kExpected{"the server has been silent", "none came within 3 s", "not a byte came for 3 s",
                                 "reads too slowly", "out of step with the server"};  // the last: viewed() judges it
  const auto expected = [&](const char* part) { return why.find(part) != std::string::npos; };
  if (anyWithdrawn_ && expected("hello.token")) return;
  if (std::ranges::none_of(kExpected, expected)) fail(nameOf(session) + " ended its connection: " + why);
}

void Oracle::viewed(SessionId session, const Mirror& mirror) {
  Client& client = clients_[session];
  const MirrorView& view = mirror.contents();
  if (view.resyncs != client.resyncs) {
    ++counts_.resyncs;
    log_.add([&] { return nameOf(session) + " resyncs"; });
    client.resyncs = view.resyncs;
    if (client.resyncs > client.corruptions) fail(nameOf(session) + " resynced though its memory is sound");
  }
  if (view.scene.get() == client.seen || view.epoch == 0) return;
  client.seen = view.scene.get();
  const std::uint64_t revision = view.scene->revision();
  if (view.epoch == client.epoch && revision < client.revision) {
    fail(nameOf(session) + " went back from revision " + std::to_string(client.revision) + " to " +
         std::to_string(revision));
  }
  if (view.epoch != client.epoch && client.epoch != 0) ++counts_.stateResets;
  client.epoch = view.epoch;
  client.revision = revision;
  const Revision* known = find(view.epoch, revision);
  if (known == nullptr || known->root != view.scene->root()) {
    fail(nameOf(session) + " shows a revision " + std::to_string(revision) + " that the server never had");
  }
}

void Oracle::corrupted(SessionId session) {
  ++counts_.corruptions;
  ++clients_[session].corruptions;
  log_.add([&] { return nameOf(session) + ": a value in its memory flips"; });
}

void Oracle::corruptionOverlooked(SessionId session) {
  fail(nameOf(session) + " overlooks that its memory is corrupted");
}

void Oracle::quiet(const SceneHistory& history, SessionId session, const MirrorView& view) {
  const auto ownRoot = recomputedRoot(view);
  const auto scene = SceneVersion::fromSnapshot(history.version.revision(), recordsOf(history.version));
  if (view.epoch != history.epoch)
    return fail(nameOf(session) + " is in another epoch than the server after 5 s of quiet");
  if (!ownRoot) return fail(nameOf(session) + " is incomplete after 5 s of quiet: " + ownRoot.error().text());
  if (!scene || *ownRoot != scene->root() || recordsOf(*view.scene) != recordsOf(history.version)) {
    fail(nameOf(session) + " differs from the server after 5 s of quiet, at revision " +
         std::to_string(view.scene->revision()) + " of " + std::to_string(history.version.revision()));
  }
  if (!view.hashesEqual) fail(nameOf(session) + " does not know that it equals the server");
}

void Oracle::stuck(SessionId session, std::size_t unanswered) {
  fail(nameOf(session) + " still waits for " + std::to_string(unanswered) + " answers 20 s after the last trouble");
}

Oracle::Counts& Oracle::Counts::operator+=(const Counts& other) {
  edits += other.edits, accepted += other.accepted, increments += other.increments, conflicts += other.conflicts;
  refused += other.refused, live += other.live, lostWithState += other.lostWithState, commits += other.commits;
  resyncs += other.resyncs, corruptions += other.corruptions, starts += other.starts, stateResets += other.stateResets;
  return *this;
}

void Oracle::settled() {
  for (const auto& [id, edit] : edits_) {
    if (dead_.contains(id.first)) continue;
    const std::string name = nameOf(id.first, id.second);
    if (edit.replies != 1) fail(name + " was answered " + std::to_string(edit.replies) + " times");
    if (edit.acceptedEpoch != 0 && edit.lives == 0 && !edit.stateLost)
      fail(name + " was accepted and never called live");
    if (edit.acceptedEpoch == epoch_) {
      const Revision* made = find(epoch_, edit.acceptedRevision);
      if (made == nullptr || made->by != id) fail(name + " was acknowledged and is lost");
    }
  }
}

}  // namespace haptics::sim
