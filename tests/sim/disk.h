#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "haptic_server/scene/edit_journal.h"
#include "haptic_server/scene/sequencer.h"
#include "tests/sim/mutant.h"

namespace haptics::sim {

/// What survives a crash of the server's process: every edit that the sequencer had it keep, with its meshes.
class Disk final : public EditJournal {
 public:
  using Write = std::function<void()>;
  /// When a write reaches the disk; at once unless a mutant delays it.
  using WriteLater = std::function<void(Write)>;

  explicit Disk(std::uint64_t epoch) : epoch_(epoch) {}

  [[nodiscard]] Result<void> keep(const SequencerState& before, const Edits& edits, const Meshes& meshes) override;
  void delayWrites(WriteLater later) { later_ = std::move(later); }

  /// The state that a new process finds; `mutant` says what was not written.
  [[nodiscard]] SequencerState recovered(Mutant mutant) const;
  [[nodiscard]] Sequencer::Meshes meshesOf(const SceneVersion& version) const;
  [[nodiscard]] std::uint64_t epoch() const noexcept { return epoch_; }
  [[nodiscard]] bool empty() const noexcept { return edits_.empty(); }

 private:
  std::uint64_t epoch_;
  Edits edits_;
  Meshes meshes_;
  WriteLater later_;
};

}  // namespace haptics::sim
