#include <atomic>
#include <cstdio>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "haptic_server/recording/recording_bytes.h"
#include "haptic_server/recording/recording_player.h"
#include "haptic_server/recording/replay.h"
#include "haptic_server/servo/servo_loop.h"
#include "tests/eval/fuzz/fuzz.h"
#include "tests/eval/fuzz/live_world.h"
#include "tests/eval/or_throw.h"
#include "tests/eval/report.h"
#include "tests/eval/table1/interruption.h"

namespace haptics::eval {
namespace {

constexpr double kDuration_s = 20;
constexpr std::uint64_t kPlayedOf = 4;   // worlds, one is played too
constexpr std::uint64_t kProgress = 50;  // worlds from one line about it to the next

struct Replayed {
  std::uint64_t ticks = 0, contactTicks = 0, accepted = 0;
  double rate_Hz = 0;
  std::size_t hands = 0;
  std::string wrong;  // empty: nothing
};

[[nodiscard]] std::string verdictOn(const Result<ReplayOutcome>& replayed, std::uint64_t ticks) {
  if (!replayed) return "refused: " + replayed.error().text();
  if (replayed->refusal) return "refused: " + replayed->refusal->text();
  if (replayed->ticks != ticks)
    return std::to_string(replayed->ticks) + " of " + std::to_string(ticks) + " ticks are in it";
  return differenceIn(*replayed);
}

/// As a server that plays the recording comes to. Empty: nothing is wrong.
[[nodiscard]] std::string verdictOfPlayer(const std::filesystem::path& file, std::uint64_t ticks) {
  AssetStore store;
  auto player = orThrow(RecordingPlayer::open(file));
  orThrow(player->prepare(store, [](const RemadeScene&) { return true; }));
  SceneMailbox mailbox;
  const RecordingFacts& facts = player->facts();
  ServoLoop loop(player->device(), mailbox, facts.config, false);
  if (facts.secondHand) loop.addHand(player->device(1), facts.secondHand->config);
  player->start();
  loop.runFlatOut(*player);
  player->finish();
  if (const auto verdict = player->verdict(); !verdict) return "played: " + verdict.error().text();
  return player->played().ticks == ticks ? "" : "played: not all ticks";
}

[[nodiscard]] Replayed runWorld(std::uint64_t seed, const std::filesystem::path& file) {
  Replayed result;
  {
    LiveWorld world(seed, kDuration_s, file);
    orThrow(world.run());
    result = {.ticks = world.ticks(),
              .contactTicks = world.contactTicks(),
              .accepted = world.accepted(),
              .rate_Hz = world.setup().rate_Hz,
              .hands = world.setup().hands,
              .wrong = {}};
  }
  result.wrong = verdictOn(replay(orThrow(RecordingBytes::open(file))), result.ticks);
  if (seed % kPlayedOf == 0 && result.wrong.empty()) result.wrong = verdictOfPlayer(file, result.ticks);
  return result;
}

class ReplayLiveFuzz {
 public:
  ReplayLiveFuzz(const FuzzOptions& options, const std::filesystem::path& out) : options_(options), out_(out) {}

  [[nodiscard]] bool run() {
    std::filesystem::create_directories(out_);
    std::vector<std::thread> threads;
    for (unsigned i = std::max(1U, std::thread::hardware_concurrency()); i > 0; --i)
      threads.emplace_back([this] { work(); });
    for (std::thread& thread : threads) thread.join();
    report();
    return findings_.empty();
  }

 private:
  const FuzzOptions& options_;
  const std::filesystem::path& out_;
  Interruption interruption_;
  std::atomic<std::uint64_t> next_{0};

  std::mutex mutex_;  // guards the below
  std::uint64_t done_ = 0, ticks_ = 0, contactTicks_ = 0, accepted_ = 0, twoHands_ = 0;
  std::vector<Record> findings_;

  void work() {
    for (std::uint64_t i = next_++; i < options_.scenes && !interruption_.came(); i = next_++) {
      const std::uint64_t seed = options_.seed + i;
      const std::filesystem::path file = out_ / ("replay-live-" + std::to_string(seed) + ".haptics");
      Replayed result;
      try {
        result = runWorld(seed, file);
      } catch (const std::exception& failure) {
        result.wrong = failure.what();
      }
      if (result.wrong.empty()) std::filesystem::remove(file);
      add(seed, result);
    }
  }

  void add(std::uint64_t seed, const Replayed& result) {
    const std::lock_guard lock(mutex_);
    ticks_ += result.ticks;
    contactTicks_ += result.contactTicks;
    accepted_ += result.accepted;
    twoHands_ += result.hands > 1 ? 1 : 0;
    if (!result.wrong.empty()) {
      Record record{{"fuzz", "replay-live"}, {"seed", seed},          {"rate_Hz", result.rate_Hz},
                    {"hands", result.hands}, {"wrong", result.wrong}, {"pass", false}};
      std::printf("  %s\n", measuresText(record).c_str());
      std::fflush(stdout);
      findings_.push_back(std::move(record));
    }
    if (++done_ % kProgress == 0)
      std::fprintf(stderr, "%llu of %llu worlds, %zu differ\n", static_cast<unsigned long long>(done_),
                   static_cast<unsigned long long>(options_.scenes), findings_.size());
  }

  void report() {
    std::vector<Record> records{{{"fuzz", "replay-live"},
                                 {"seed", options_.seed},
                                 {"worlds", done_},
                                 {"two_hands", twoHands_},
                                 {"ticks", ticks_},
                                 {"contact_ticks", contactTicks_},
                                 {"edits", accepted_},
                                 {"pass", findings_.empty()}}};
    records.insert(records.end(), findings_.begin(), findings_.end());
    writeRecords(out_, "fuzz", records);
    if (interruption_.came()) std::printf("interrupted: this is what was found by then\n");
    std::printf("%llu worlds (%llu with two hands), %llu ticks, %.0f %% in contact, %llu edits: %zu do not replay\n",
                static_cast<unsigned long long>(done_), static_cast<unsigned long long>(twoHands_),
                static_cast<unsigned long long>(ticks_),
                ticks_ > 0 ? 100.0 * static_cast<double>(contactTicks_) / static_cast<double>(ticks_) : 0,
                static_cast<unsigned long long>(accepted_), findings_.size());
  }
};

}  // namespace

bool runFuzzReplayLive(const FuzzOptions& options, const std::filesystem::path& out) {
  return ReplayLiveFuzz(options, out).run();
}

}  // namespace haptics::eval
