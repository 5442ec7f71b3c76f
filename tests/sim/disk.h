#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <unordered_map>

#include "haptic_server/scene/edit_journal.h"
#include "haptic_server/scene/sequencer.h"
#include "haptic_server/state/saved_state.h"
#include "tests/sim/mutant.h"
#include "tests/sim/random.h"

namespace haptics::sim {

/// What survives a crash of the server's process: the bytes of the production log, and the meshes that it names.
class Disk final : public EditJournal {
 public:
  using Write = std::function<void()>;
  using WriteLater = std::function<void(Write)>;

  /// Chance outlives it.
  Disk(std::uint64_t epoch, Random& random);

  [[nodiscard]] Result<void> keep(const SequencerState& before, const Edits& edits, const Assets& assets) override;
  void resetTo(const SequencerState& state, const Assets& assets) override;
  /// Writes reach the disk when this says so; empty: before keep() returns.
  void delayWrites(WriteLater later) { later_ = std::move(later); }
  /// In the middle of the next write the process dies: some of the bytes are there, and `died` is called.
  void dieInNextWrite(std::function<void()> died) { died_ = std::move(died); }

  /// The state that a new process finds; `mutant` says what it overlooks.
  [[nodiscard]] Result<SequencerState> recover(Mutant mutant);
  [[nodiscard]] Sequencer::Assets assetsOf(const SceneVersion& version) const;
  [[nodiscard]] std::uint64_t epoch() const noexcept { return epoch_; }
  [[nodiscard]] bool empty() const noexcept { return log_.empty(); }

 private:
  const std::uint64_t epoch_;
  Random& random_;
  std::string log_;
  RecordWriter writer_;
  std::size_t checkpointAt_bytes_ = 0;
  std::unordered_map<ContentHash, std::shared_ptr<const Asset>> assets_;
  WriteLater later_;
  std::function<void()> died_;

  void checkpoint(const SequencerState& state);
};

}  // namespace haptics::sim
