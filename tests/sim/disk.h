#pragma once

#include <cstdint>
#include <memory>

#include "haptic_server/scene/asset_store.h"
#include "haptic_server/scene/lost_parts.h"
#include "haptic_server/state/state_folder.h"
#include "tests/haptic_server/state/simulated_files.h"
#include "tests/sim/mutant.h"
#include "tests/sim/random.h"

namespace haptics::sim {

/// The disk with the server's state folder. It outlives the server's processes, and what was not waited for may be lost
/// with the power.
class Disk {
 public:
  /// Of a folder that is made anew. Chance outlives it.
  Disk(std::uint64_t epoch, Random& random, Mutant mutant);

  struct Found {
    std::unique_ptr<StateFolder> folder;
    RestoredState restored;
    /// Since a process that found the same epoch, or that the one before had begun: the log's end may be anything, and of
    /// what is found there each process begins an epoch anew, until there is space to keep one.
    bool powerWasLost = false;
  };
  /// What a new process finds.
  [[nodiscard]] Result<Found> open(AssetStore& store);
  [[nodiscard]] std::uint64_t epoch() const noexcept { return epoch_; }

  /// In the middle of one of the next calls that change something the process dies: test::PowerFailure is thrown.
  void dieInNextWrite();
  /// The process is gone, perhaps with the power.
  void processDied();
  /// For a while, calls fail now and then, or there is little space; or again no longer.
  void fail();
  void recover();

 private:
  const std::uint64_t epoch_;
  Random& random_;
  const Mutant mutant_;
  std::shared_ptr<test::SimulatedFiles> files_;
  bool isNew_ = true;
  bool powerWasLost_ = false;
  std::uint64_t foundEpoch_ = 0;  ///< By the last process.
};

}  // namespace haptics::sim
