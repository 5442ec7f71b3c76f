#include "tests/sim/disk.h"

#include <cstddef>
#include <limits>
#include <string>
#include <utility>

namespace haptics::sim {
namespace {

constexpr const char* kFolder = "/state";
constexpr std::size_t kMaxBetweenCheckpoints_bytes = 40'000;
constexpr std::size_t kReserve_bytes = 20'000;
constexpr std::size_t kMaxCallsToDeath = 8;
constexpr double kFailing = 0.05;

}  // namespace

Disk::Disk(std::uint64_t epoch, Random& random, Mutant mutant)
    : epoch_(epoch),
      random_(random),
      mutant_(mutant),
      files_(std::make_shared<test::SimulatedFiles>(random.bits(), mutant == Mutant::kReplyBeforeDurable
                                                                       ? test::FileMutant::kLogNotSynced
                                                                       : test::FileMutant::kNone)) {}

Result<Disk::Found> Disk::open(AssetStore& store) {
  const std::uint64_t freshEpoch = std::exchange(isNew_, false) ? epoch_ : random_.bits();
  StateFolder::Options options;
  options.checkpointAfter_bytes = random_.below(kMaxBetweenCheckpoints_bytes);
  options.reserve_bytes = kReserve_bytes;
  options.files = files_;
  auto opened = StateFolder::open(kFolder, freshEpoch, std::move(options));
  if (!opened) return tl::unexpected(std::move(opened).error());
  const auto read = [&](const AssetName& name) -> Result<std::shared_ptr<const Asset>> {
    auto bytes = opened->folder->readAsset(name.hash);
    if (!bytes) return tl::unexpected(std::move(bytes).error());
    return store.internEncoded(name, *std::move(bytes));
  };
  RestoredState restored = restore(std::move(opened->state), read, store, freshEpoch);
  if (restored.changed) return refused("state", "an asset is lost: " + restored.warnings.front());
  SequencerState& state = restored.state;
  if (mutant_ == Mutant::kDedupeLostAtRestart) state.memory = {};
  if (mutant_ == Mutant::kIdsReused) {
    for (const auto& object : state.history->version.objects()) state.nextId = object->id + 1;
  }
  const bool isAnother = std::exchange(foundEpoch_, state.history->epoch) != state.history->epoch;
  const bool powerWasLost = std::exchange(powerWasLost_, powerWasLost_ && isAnother);
  return Found{std::move(opened->folder), std::move(restored), powerWasLost};
}

void Disk::dieInNextWrite() { files_->powerFailsAfter(static_cast<std::int64_t>(random_.below(kMaxCallsToDeath))); }

void Disk::processDied() {
  files_->powerFailsAfter(-1);
  if (random_.chance(0.5)) return;
  files_->loseWhatWasNotWaitedFor();
  powerWasLost_ = true;
}

void Disk::fail() {
  recover();
  if (random_.chance(0.5)) {
    files_->failing = kFailing;
  } else {
    files_->capacity_bytes = files_->used_bytes() + random_.below(kReserve_bytes);
  }
}

void Disk::recover() {
  files_->failing = 0;
  files_->capacity_bytes = std::numeric_limits<std::size_t>::max();
}

}  // namespace haptics::sim
