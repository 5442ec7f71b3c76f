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
#include <utility>

#include "common/clock/monotonic.h"
#include "common/wire/convert.h"
#include "graphics_client/audience/audience_link.h"
#include "graphics_client/audience/published_messages.h"
#include "graphics_client/audience/relayed_session.h"
#include "graphics_client/audience/stored_session.h"

namespace haptics::stress {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kWatchersLook{4};
constexpr milliseconds kBetweenJoins{2};  // one after the other, as people come
constexpr int kLooksPerScene = 12;        // between looks at what all hold
constexpr std::uint64_t kRetryAfter_ns = 500'000'000;
constexpr int kJoiningThreads = 3;

std::atomic<bool> stopRequested{false};

/// Of all watchers of the process; their threads count.
struct Counts {
  std::atomic<std::uint64_t> joins{0}, rootsThatDiffered{0}, commits{0}, lost{0}, doubled{0}, samples{0};
  std::array<std::atomic<std::uint32_t>, kAgeBins> ages{};

  void commit(std::uint64_t revision, std::uint64_t before) {
    ++commits;
    if (revision <= before) ++doubled;
    if (revision > before + 1) lost += revision - before - 1;
  }
  void sample(const v1::Telemetry& telemetry) {
    ++samples;
    const double age_ms = 1e-6 * static_cast<double>(monotonicNow_ns() - telemetry.time_ns());
    ++ages[std::min(static_cast<std::size_t>(std::max(0.0, age_ms / kAgeBin_ms)), kAgeBins - 1)];
  }
};

/// Holds the records of the session without a thread of its own: a machine of two cores has room for hundreds.
class Watcher {
 public:
  Watcher(const NatsOptions& nats, const SessionSubjects& subjects, Counts& counts)
      : nats_(nats), subjects_(subjects), counts_(counts) {}

  /// On a thread that may wait. Does nothing while it watches.
  void joinIfDue() {
    if (isWatching_.load(std::memory_order_acquire) || monotonicNow_ns() < nextTry_ns_) return;
    live_.reset();
    connection_.reset();
    if (join()) {
      ++counts_.joins;
      isWatching_.store(true, std::memory_order_release);
    } else {
      nextTry_ns_ = monotonicNow_ns() + kRetryAfter_ns;
    }
  }

  /// On the one thread that looks at all.
  void look() {
    if (!isWatching_.load(std::memory_order_acquire)) return;
    while (auto message = live_->next(milliseconds(0))) {
      if (!take(*message)) return leave();
    }
    if (connection_->failure() || monotonicNow_ns() > lastSign_ns_ + kSignWithin_ns) leave();
  }

  /// As look(). Null: it is not in step.
  [[nodiscard]] const SceneVersion* held() const {
    return isWatching_.load(std::memory_order_acquire) ? &*scene_ : nullptr;
  }

 private:
  void leave() {
    nextTry_ns_ = monotonicNow_ns() + kRetryAfter_ns;
    isWatching_.store(false, std::memory_order_release);
  }

  [[nodiscard]] bool join() {
    auto connection = NatsConnection::open(nats_);
    if (!connection) return false;
    connection_ = *std::move(connection);
    auto live = connection_->subscribe(subjects_.live);
    if (!live) return false;
    live_ = *std::move(live);
    const auto sign = live_->next(milliseconds(kSignWithin_ns / 1'000'000));
    if (!sign || sign->subject != subjects_.sample) return false;
    auto stored = readStoredSession(*connection_, subjects_);
    if (!stored || !*stored) return false;
    scene_ = (**stored).scene;
    epoch_ = (**stored).welcome.epoch();
    heartbeatsAhead_ = 0;
    lastSign_ns_ = monotonicNow_ns();
    return true;
  }

  /// False: to be begun anew.
  [[nodiscard]] bool take(const NatsMessage& message) {
    lastSign_ns_ = monotonicNow_ns();
    if (message.subject == subjects_.commit) {
      const auto published = readPublishedCommit(message.bytes);
      return published && published->epoch() == epoch_ && apply(published->commit());
    }
    if (live_->waiting() > kMaxBehindSample) return true;
    const auto sample = readLiveMessage(message.bytes);
    if (!sample || sample->epoch() != epoch_) return false;
    if (sample->has_telemetry()) counts_.sample(sample->telemetry());
    if (!sample->has_heartbeat()) return true;
    const bool isAhead = sample->heartbeat().revision() > scene_->revision();
    heartbeatsAhead_ = isAhead ? heartbeatsAhead_ + 1 : 0;
    return heartbeatsAhead_ <= RelayedSession::kMaxHeartbeatsAhead;
  }

  [[nodiscard]] bool apply(const v1::Commit& message) {
    const auto commit = fromWire(message);
    if (!commit) return false;
    if (commit->revision <= scene_->revision()) return true;  // was stored when it joined
    counts_.commit(commit->revision, scene_->revision());
    auto next = scene_->apply(*commit);
    if (!next || commit->prevRoot != scene_->root() || commit->root != next->root()) {
      ++counts_.rootsThatDiffered;
      return false;
    }
    scene_ = *std::move(next);
    return true;
  }

  const NatsOptions& nats_;
  const SessionSubjects& subjects_;
  Counts& counts_;
  std::atomic<bool> isWatching_{false};  // what follows is the joining thread's until then
  std::unique_ptr<NatsConnection> connection_;
  std::optional<NatsSubscription> live_;
  std::optional<SceneVersion> scene_;
  std::uint64_t epoch_ = 0, lastSign_ns_ = 0, nextTry_ns_ = 0;
  int heartbeatsAhead_ = 0;
};

/// What a viewer has, but for the picture: all assets, and threads of its own.
std::unique_ptr<ServerLink> startViewer(const WatchersOptions& options, const SessionSubjects& subjects,
                                        Counts& counts) {
  const auto last = std::make_shared<std::uint64_t>(0);
  const auto snapshot = [&counts, last](const SceneVersion& scene) {
    ++counts.joins;
    *last = scene.revision();
  };
  const auto commit = [&counts, last](const v1::Commit& message, const SceneVersion&) {
    counts.commit(message.revision(), std::exchange(*last, message.revision()));
  };
  const auto telemetry = [&counts](const v1::Telemetry& sample) { counts.sample(sample); };
  return std::make_unique<ServerLink>(ServerLink::Options{
      .server = {},
      .clientName = "viewer",
      .connect = connectThroughNats({.url = options.nats, .clientName = "viewer"}, subjects, options.session),
      .follower = {.welcomed = {}, .snapshot = snapshot, .commit = commit, .telemetry = telemetry}});
}

struct Held {
  std::uint64_t revision = 0;
  ContentHash root;
  auto operator<=>(const Held&) const = default;
};

/// Nothing: they are not in step with each other.
std::optional<Held> heldByAll(const std::vector<std::unique_ptr<Watcher>>& watchers,
                              const std::vector<std::unique_ptr<ServerLink>>& viewers) {
  std::optional<Held> held;
  const auto differs = [&held](const SceneVersion& scene) {
    const Held here{scene.revision(), scene.root()};
    return here != held.value_or(here) || !(held = here);
  };
  for (const auto& watcher : watchers) {
    if (const SceneVersion* scene = watcher->held(); scene == nullptr || differs(*scene)) return std::nullopt;
  }
  for (const auto& viewer : viewers) {
    const auto view = viewer->latest();
    if (view->link != LinkState::kLive || !view->hashesEqual || differs(*view->scene)) return std::nullopt;
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
  const NatsOptions nats{.url = options.nats, .clientName = "watcher"};
  Counts counts;
  std::vector<std::unique_ptr<Watcher>> watchers;
  std::vector<std::unique_ptr<ServerLink>> viewers;
  for (int i = 0; i < options.count - options.viewers; ++i)
    watchers.push_back(std::make_unique<Watcher>(nats, subjects, counts));
  for (int i = 0; i < options.viewers; ++i) viewers.push_back(startViewer(options, subjects, counts));
  std::vector<std::jthread> joining;
  for (std::size_t first = 0; first < kJoiningThreads; ++first) {
    joining.emplace_back([&watchers, first](const std::stop_token& stop) {
      while (!stop.stop_requested()) {
        for (std::size_t i = first; i < watchers.size() && !stop.stop_requested(); i += kJoiningThreads) {
          watchers[i]->joinIfDue();
          std::this_thread::sleep_for(kBetweenJoins);
        }
      }
    });
  }
  std::string said;
  for (int look = 0; !stopRequested; ++look) {
    for (const auto& watcher : watchers) watcher->look();
    const auto held = look % kLooksPerScene == 0 ? heldByAll(watchers, viewers) : std::nullopt;
    if (const std::string line = held ? allHold(held->revision, held->root) : said; line != said) {
      said = line;
      std::puts(line.c_str());
      std::fflush(stdout);
    }
    std::this_thread::sleep_for(kWatchersLook);
  }
  joining.clear();
  for (const auto& viewer : viewers) counts.rootsThatDiffered += viewer->latest()->resyncs;
  viewers.clear();
  std::size_t used = kAgeBins;
  while (used > 0 && counts.ages[used - 1] == 0) --used;
  const std::vector<std::uint32_t> ages(counts.ages.begin(), counts.ages.begin() + static_cast<std::ptrdiff_t>(used));
  const nlohmann::ordered_json summary{{"watchers", options.count},
                                       {"joins", counts.joins.load()},
                                       {"roots_that_differed", counts.rootsThatDiffered.load()},
                                       {"commits", counts.commits.load()},
                                       {"commits_lost", counts.lost.load()},
                                       {"commits_doubled", counts.doubled.load()},
                                       {"samples", counts.samples.load()},
                                       {"ages", ages}};
  std::ofstream(options.summary) << summary << '\n';
}

}  // namespace haptics::stress
