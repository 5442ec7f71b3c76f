#include "tests/sim/mutant.h"

#include <algorithm>

namespace haptics::sim {
namespace {

constexpr MutantInfo kMutants[] = {
    {Mutant::kNoDedupe, "no-dedupe", "a resent edit is applied again"},
    {Mutant::kNoCompareAndSet, "no-compare-and-set", "preconditions are not looked at"},
    {Mutant::kHalfTransactions, "half-transactions", "of two operations only the first is carried out"},
    {Mutant::kDedupeLostAtRestart, "dedupe-lost-at-restart",
     "a restarted server knows the scene but not whose edits made it"},
    {Mutant::kIdsReused, "ids-reused", "a restarted server gives a removed object's number to another"},
    {Mutant::kEpochKeptWithoutState, "epoch-kept-without-state", "a server that lost its state does not say so"},
    {Mutant::kReplyBeforeDurable, "reply-before-durable", "an edit is acknowledged before a crash could not undo it"},
    {Mutant::kSwappedReplies, "swapped-replies", "two replies change places"},
    {Mutant::kLiveBeforeAdoption, "live-before-adoption", "an edit is called live when it is accepted"},
    {Mutant::kAnswersOfAnySize, "answers-of-any-size", "an edit is accepted whose commit fits no frame"},
    {Mutant::kTokenOnlyAtHello, "token-only-at-hello", "an open connection outlives the withdrawal of its token"},
    {Mutant::kAdoptionUntold, "adoption-untold", "a new connection is not told what the servo feels already"},
    {Mutant::kSessionReordered, "session-reordered", "an edit passes an earlier one of its session that takes long"},
    {Mutant::kPreconditionsJudgedEarly, "preconditions-judged-early",
     "preconditions are looked at before an edit is prepared, not when it takes effect"},
    {Mutant::kSuccessorLost, "successor-lost", "what a session asks for after a cancelled edit is never carried out"},
    {Mutant::kBusyIsFinal, "busy-is-final", "an edit that only came too early is refused for good"},
    {Mutant::kLiveLostWithConnection, "live-lost-with-connection", "heartbeats do not say what the servo feels"},
    {Mutant::kEditsOfAnotherEpoch, "edits-of-another-epoch",
     "revisions of a lost state are taken for those of the new one"},
    {Mutant::kEditsOutOfOrder, "edits-out-of-order", "two edits of a session change places on their way"},
    {Mutant::kNoHashCheck, "no-hash-check", "a client believes whatever root it is told"},
    {Mutant::kNoHeartbeats, "no-heartbeats", "a client compares at commits only"},
    {Mutant::kIncrements, "increments", "commits say by how much values change, not what they become"},
    {Mutant::kCommitsReordered, "commits-reordered", "two commits change places"},
    {Mutant::kCommitRepeated, "commit-repeated", "a commit comes twice"},
    {Mutant::kCommitLost, "commit-lost", "a commit is left out"},
    {Mutant::kTornSnapshot, "torn-snapshot", "a snapshot holds objects of two revisions"},
    {Mutant::kResumesFromWrongRevision, "resumes-from-wrong-revision",
     "deltas begin at another revision than the client's"},
};

}  // namespace

std::span<const MutantInfo> allMutants() { return kMutants; }

std::optional<Mutant> mutantNamed(std::string_view name) {
  const auto at = std::ranges::find(kMutants, name, &MutantInfo::name);
  return at == std::end(kMutants) ? std::nullopt : std::optional(at->mutant);
}

bool isOnTheWire(Mutant mutant) { return mutant >= Mutant::kBusyIsFinal; }

}  // namespace haptics::sim
