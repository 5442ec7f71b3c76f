#include "tests/stress/watchers.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <memory>
#include <optional>
#include <thread>

#include "common/clock/monotonic.h"
#include "graphics_client/audience/audience_link.h"

namespace haptics::stress {
namespace {

constexpr std::chrono::milliseconds kLook{50};

std::atomic<bool> stopRequested{false};

/// Of all watchers of the process; their threads count.
struct Counts {
  std::atomic<std::uint64_t> commits{0}, lost{0}, doubled{0}, snapshots{0}, samples{0};
  std::array<std::atomic<std::uint32_t>, kAgeBins> ages{};
};

/// The callbacks of one watcher, all on its link's thread.
SessionFollower followerInto(Counts& counts) {
  const auto last = std::make_shared<std::uint64_t>(0);
  return {.welcomed = {},
          .snapshot =
              [&counts, last](const SceneVersion& scene) {
                ++counts.snapshots;
                *last = scene.revision();
              },
          .commit =
              [&counts, last](const v1::Commit& commit, const SceneVersion&) {
                ++counts.commits;
                if (commit.revision() <= *last) ++counts.doubled;
                if (commit.revision() > *last + 1) counts.lost += commit.revision() - *last - 1;
                *last = commit.revision();
              },
          .telemetry =
              [&counts](const v1::Telemetry& sample) {
                ++counts.samples;
                const double age_ms = 1e-6 * static_cast<double>(monotonicNow_ns() - sample.time_ns());
                const auto bin = static_cast<std::size_t>(std::max(0.0, age_ms / kAgeBin_ms));
                ++counts.ages[std::min(bin, kAgeBins - 1)];
              }};
}

/// The scene that all hold with every asset, each equal to its server's as last announced; null: they do not.
std::shared_ptr<const SceneVersion> heldByAll(const std::vector<std::unique_ptr<ServerLink>>& watchers) {
  std::shared_ptr<const SceneVersion> held;
  for (const auto& watcher : watchers) {
    const auto view = watcher->latest();
    if (view->link != LinkState::kLive || !view->hashesEqual) return nullptr;
    if (held && (held->revision() != view->scene->revision() || held->root() != view->scene->root())) return nullptr;
    held = view->scene;
  }
  return held;
}

}  // namespace

std::string allHold(std::uint64_t revision, const ContentHash& root) {
  return "all hold revision " + std::to_string(revision) + " root " + root.hex();
}

void runWatchers(const WatchersOptions& options) {
  std::signal(SIGTERM, [](int) { stopRequested = true; });
  const auto subjects = SessionSubjects::of(options.session).value();
  Counts counts;
  std::vector<std::unique_ptr<ServerLink>> watchers;
  for (int i = 0; i < options.count && !stopRequested; ++i) {
    const NatsOptions nats{.url = options.nats, .clientName = "watcher " + std::to_string(i)};
    watchers.push_back(
        std::make_unique<ServerLink>(ServerLink::Options{.server = {},
                                                         .clientName = nats.clientName,
                                                         .connect = connectThroughNats(nats, subjects, options.session),
                                                         .follower = followerInto(counts)}));
  }
  std::string said;
  while (!stopRequested) {
    const auto held = heldByAll(watchers);
    if (const std::string line = held ? allHold(held->revision(), held->root()) : said; line != said) {
      said = line;
      std::puts(line.c_str());
      std::fflush(stdout);
    }
    std::this_thread::sleep_for(kLook);
  }
  std::uint64_t connections = 0, resyncs = 0;
  for (const auto& watcher : watchers) {
    connections += watcher->latest()->connections;
    resyncs += watcher->latest()->resyncs;
  }
  watchers.clear();
  std::size_t used = kAgeBins;
  while (used > 0 && counts.ages[used - 1] == 0) --used;
  std::vector<std::uint32_t> ages(counts.ages.begin(), counts.ages.begin() + static_cast<std::ptrdiff_t>(used));
  const nlohmann::ordered_json summary{{"watchers", options.count},
                                       {"connections", connections},
                                       {"snapshots", counts.snapshots.load()},
                                       {"roots_that_differed", resyncs},
                                       {"commits", counts.commits.load()},
                                       {"commits_lost", counts.lost.load()},
                                       {"commits_doubled", counts.doubled.load()},
                                       {"samples", counts.samples.load()},
                                       {"ages", ages}};
  std::ofstream(options.summary) << summary << '\n';
}

}  // namespace haptics::stress
