#include "tests/sim/disk.h"

#include <algorithm>
#include <utility>

namespace haptics::sim {
namespace {

constexpr std::size_t kMostBetweenCheckpoints_bytes = 40'000;

}  // namespace

Disk::Disk(std::uint64_t epoch, Random& random) : epoch_(epoch), random_(random) {}

Result<void> Disk::keep(const SequencerState& before, const Edits& edits, const Assets& assets) {
  if (!later_ && log_.size() >= checkpointAt_bytes_) checkpoint(before);
  for (const auto& asset : assets) assets_[asset->name.hash] = asset;
  std::string records;
  for (const auto& edit : edits) writer_.append(records, editRecord(*edit));
  if (died_) {
    log_.append(records, 0, random_.below(records.size() + 1));
    std::exchange(died_, nullptr)();
    return refused("state", "the process is dead");
  }
  if (later_) {
    later_([this, records] { log_ += records; });
  } else {
    log_ += records;
  }
  return {};
}

void Disk::resetTo(const SequencerState& state, const Assets& assets) {
  for (const auto& asset : assets) assets_[asset->name.hash] = asset;
  checkpoint(state);
}

void Disk::checkpoint(const SequencerState& state) {
  log_ = kLogHead;
  writer_ = RecordWriter();
  writer_.append(log_, checkpointRecord(state));
  checkpointAt_bytes_ = log_.size() + random_.below(kMostBetweenCheckpoints_bytes);
}

Result<SequencerState> Disk::recover(Mutant mutant) {
  died_ = nullptr;
  later_ = nullptr;
  SequencerState state;
  if (empty()) {
    state.history = std::make_shared<const SceneHistory>(SceneHistory{.epoch = epoch_, .version = {}, .edits = {}});
    return state;
  }
  auto saved = readLog(log_);
  if (!saved) return tl::unexpected<Error>(std::move(saved).error());
  if (saved->damage && !saved->damage->torn) return refused("log", saved->damage->reason);
  if (saved->damage) log_.resize(saved->damage->offset);
  writer_ = saved->writer;
  state = std::move(saved->state);
  if (mutant == Mutant::kDedupeLostAtRestart) state.memory = {};
  if (mutant == Mutant::kIdsReused) {
    for (const auto& object : state.history->version.objects()) state.nextId = object->id + 1;
  }
  return state;
}

Sequencer::Assets Disk::assetsOf(const SceneVersion& version) const {
  const auto lookUp = [this](const AssetName& name) {
    return Result<std::shared_ptr<const Asset>>(assets_.at(name.hash));
  };
  Sequencer::Assets assets;
  for (const auto& object : version.objects()) assets[object->id] = gatherAssets(*object, lookUp).value();
  return assets;
}

}  // namespace haptics::sim
