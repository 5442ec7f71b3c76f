#pragma once

#include <optional>
#include <span>
#include <string_view>

namespace haptics::sim {

/// Ways in which the protocol could be broken, to test the oracle: under each of them it must find fault. None is a
/// change of production code: the world around it (the server's host, or the wire at a client's end) does what the
/// broken code would do.
enum class Mutant {
  kNone,
  kNoDedupe,
  kNoCompareAndSet,
  kHalfTransactions,
  kDedupeLostAtRestart,
  kIdsReused,
  kEpochKeptWithoutState,
  kReplyBeforeDurable,
  kSwappedReplies,
  kLiveBeforeAdoption,
  kAnswersOfAnySize,
  kTokenOnlyAtHello,
  kAdoptionUntold,
  kSessionReordered,
  kPreconditionsJudgedEarly,
  kSuccessorLost,
  kBusyIsFinal,
  kLiveLostWithConnection,
  kEditsOfAnotherEpoch,
  kEditsOutOfOrder,
  kNoHashCheck,
  kNoHeartbeats,
  kIncrements,
  kCommitsReordered,
  kCommitLost,
  kCommitRepeated,
  kTornSnapshot,
  kResumesFromWrongRevision,
};

struct MutantInfo {
  Mutant mutant;
  std::string_view name;
  std::string_view what;
};

[[nodiscard]] std::span<const MutantInfo> allMutants();
[[nodiscard]] std::optional<Mutant> mutantNamed(std::string_view name);
/// It shows in the frames at a client's end, not in the server.
[[nodiscard]] bool isOnTheWire(Mutant mutant);

}  // namespace haptics::sim
