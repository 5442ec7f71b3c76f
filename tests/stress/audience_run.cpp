#include "tests/stress/audience_run.h"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <memory>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include "common/wire/convert.h"
#include "graphics_client/audience/session_subjects.h"
#include "tests/stress/child.h"
#include "tests/stress/findings.h"
#include "tests/stress/nats_cluster.h"
#include "tests/stress/run_files.h"
#include "tests/stress/server_process.h"
#include "tests/stress/watchers.h"

namespace haptics::stress {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kSession = "audience";
constexpr int kTurns = 2;
constexpr int kWatchersPerProcess = 125;
constexpr int kLowPriority = 10;            // watchers stand for other machines
constexpr double kAudiencePatience_s = 60;  // for a process to end
constexpr double kJoining_s = 300;          // until all watchers hold the scene
constexpr double kInStep_s = 60;            // the same, of those that held it before
constexpr int kEditsAtTheEnd = 10;
constexpr double kMove_m = 1e-4;
constexpr double kMaxAge_ms = 100, kMaxRelayShare = 0.25, kMinP = 1e-3;

double secondsSince(std::uint64_t began_ns) { return 1e-9 * static_cast<double>(monotonicNow_ns() - began_ns); }

/// Value that a share of the samples does not exceed, in ms.
double ageAt(const std::vector<std::uint64_t>& bins, double share) {
  std::uint64_t all = 0, below = 0;
  for (const std::uint64_t count : bins) all += count;
  for (std::size_t i = 0; i < bins.size(); ++i) {
    below += bins[i];
    if (static_cast<double>(below) >= share * static_cast<double>(all)) return kAgeBin_ms * static_cast<double>(i + 1);
  }
  return 0;
}

class AudienceRun {
 public:
  AudienceRun(const RunPlan& plan, const AudienceRunOptions& options)
      : plan_(plan), options_(options), cluster_(options.out, options.nodes) {
    std::ifstream file(options.scene);
    if (!file) throw std::runtime_error("--scene " + options.scene.string() + ": cannot be read");
    scene_.assign(std::istreambuf_iterator<char>(file), {});
    startServer();
  }

  void withoutAudience(double seconds) {
    tell("without an audience for " + std::to_string(static_cast<int>(seconds)) + " s");
    follow(seconds, 0);
  }

  /// Everything from the relay's start until all hold the last edit counts as time with an audience.
  void withAudience(double seconds, int kills) {
    const std::uint64_t began_ns = monotonicNow_ns();
    startRelay();
    waitUntil(kAudiencePatience_s, "the relay is connected: see relay.log", [this] {
      std::ifstream log(options_.out / "relay.log");
      return std::string(std::istreambuf_iterator<char>(log), {}).find("connected to") != std::string::npos;
    });
    startWatchers();
    awaitStep(kJoining_s);
    joining_s_ = std::max(joining_s_, secondsSince(began_ns));
    tell("all watchers hold the scene after " + std::to_string(static_cast<int>(secondsSince(began_ns))) + " s");
    follow(seconds, kills);
    awaitStep(kInStep_s);
    with_.emplace_back(began_ns, monotonicNow_ns());
  }

  /// What is not measured: another server, and a stream without its leader.
  void startAnew() {
    tell("the server starts anew");
    finishServer();
    startServer();
    editAFew();
    awaitStep(kInStep_s);
    if (options_.nodes < 3) return;
    leader_ = cluster_.killLeaderOf(SessionSubjects::of(kSession).value().sceneStream);
    tell("the stream's leader " + leader_ + " is killed");
    editAFew();
    awaitStep(kInStep_s);
  }

  void endAudience() {
    for (Child& process : watchers_) process.signal(SIGTERM);
    for (Child& process : watchers_) process.stop(kAudiencePatience_s);
    for (std::size_t i = 0; i < watchers_.size(); ++i) {
      const Json seen = readJson(summaryOf(i));
      for (const char* count :
           {"joins", "roots_that_differed", "commits", "commits_lost", "commits_doubled", "samples"})
        seen_[count] = seen_.value(count, std::uint64_t{0}) + seen.at(count).get<std::uint64_t>();
      const auto ages = seen.at("ages").get<std::vector<std::uint64_t>>();
      for (std::size_t bin = 0; bin < ages.size(); ++bin) ages_[bin] += ages[bin];
    }
    watchers_.clear();
    relay_s_ += relay_.processor_s();
    relay_.stop(kAudiencePatience_s);
  }

  Json report() {
    finishServer();
    const auto servo = judgeServo(pulses_, [this](std::uint64_t at_ns) -> std::optional<bool> {
      if (at_ns > with_.back().second) return std::nullopt;
      return std::ranges::any_of(with_, [at_ns](const auto& t) { return at_ns >= t.first && at_ns < t.second; });
    });
    double with_s = 0;
    for (const auto& [from, to] : with_) with_s += 1e-9 * static_cast<double>(to - from);
    const auto phase = [](const MissedTicks& ticks) {
      return Json{{"ticks", ticks.ticks}, {"missed", ticks.missed}, {"bursts", ticks.bursts}};
    };
    Json report{{"watchers", options_.watchers},
                {"of_them_with_all_assets", options_.viewers},
                {"nats_servers", options_.nodes},
                {"seconds", plan_.seconds},
                {"joining_s", joining_s_},
                {"servo",
                 {{"without", phase(servo.quiet)},
                  {"with", phase(servo.attack)},
                  {"p_bursts", servo.pBursts},
                  {"p_ticks", servo.pTicks}}},
                {"relay_share_of_a_core", relayMeasured_s_ / with_s},
                {"relays_killed", killed_},
                {"leader_killed", leader_},
                {"edits", asked_},
                {"edits_refused", refused_.load()},
                {"committed", committed_},
                {"seen", seen_},
                {"age_ms", {{"p50", ageAt(ages_, 0.5)}, {"p99", ageAt(ages_, 0.99)}, {"p99.9", ageAt(ages_, 0.999)}}}};
    const auto rate = [](const MissedTicks& of) {
      return static_cast<double>(of.bursts) / static_cast<double>(std::max<std::uint64_t>(1, of.ticks));
    };
    Json holds;
    // Fewer with an audience is the machine: the processor of a servo that sleeps less wakes sooner.
    holds["no_more_missed_ticks_with_an_audience"] = servo.pBursts > kMinP || rate(servo.attack) < rate(servo.quiet);
    holds["relay_takes_at_most_a_quarter_of_a_core"] = relayMeasured_s_ <= kMaxRelayShare * with_s;
    holds["age_p99_at_most_100_ms"] = seen_.value("samples", 0) > 0 && ageAt(ages_, 0.99) <= kMaxAge_ms;
    holds["no_commit_lost_or_doubled"] = seen_["commits_lost"] == 0 && seen_["commits_doubled"] == 0;
    holds["no_root_differed"] = seen_["roots_that_differed"] == 0;
    holds["every_edit_is_committed"] = refused_ == 0 && committed_ == static_cast<std::uint64_t>(asked_);
    report["pass"] = std::ranges::all_of(holds, [](const Json& one) { return one.get<bool>(); });
    report["holds"] = std::move(holds);
    return report;
  }

  void noteRelay() { relayMeasured_s_ = relay_s_ + relay_.processor_s(); }

 private:
  static void tell(const std::string& what) { std::fprintf(stderr, "haptic_stress: %s\n", what.c_str()); }

  void startServer() {
    server_ = std::make_unique<ServerProcess>(options_.out, scene_,
                                              std::vector<std::string>{"--assets", "/usr/share/inventor/data"}, port_);
    port_ = server_->port();
    const Endpoint endpoint{"127.0.0.1", port_};
    auditor_ = std::make_unique<Auditor>(endpoint, [] { return std::uint64_t{1}; });
    editor_ = std::make_unique<ServerLink>(
        ServerLink::Options{.server = endpoint, .clientName = "editor", .telemetryRate_Hz = 0, .fetchAssets = false});
    waitUntil(kAudiencePatience_s, "the scene is there", [this] {
      return !editor_->latest()->scene->objects().empty() && auditor_->latest()->sample.has_value();
    });
  }

  void finishServer() {
    if (!server_) return;
    committed_ += auditor_->commits().size();
    if (pulses_.empty()) pulses_ = auditor_->pulses();
    auditor_.reset();
    editor_.reset();
    if (!server_->stop()) throw std::runtime_error("the server has not ended well: see its log");
    server_.reset();
  }

  void startRelay() {
    std::filesystem::remove(options_.out / "relay.log");
    relay_ = Child(
        {(self().parent_path() / "haptic_relay").string(), "--connect", "127.0.0.1:" + std::to_string(port_), "--nats",
         cluster_.urls(), "--session", kSession, "--replicas", std::to_string(options_.nodes < 3 ? 1 : 3)},
        options_.out / "relay.log", [] {});
  }

  void killRelay() {
    relay_s_ += relay_.processor_s();
    relay_.kill();
    ++killed_;
    startRelay();
  }

  [[nodiscard]] std::filesystem::path logOf(std::size_t process) const {
    return options_.out / ("watchers_" + std::to_string(process) + ".log");
  }
  [[nodiscard]] std::filesystem::path summaryOf(std::size_t process) const {
    return options_.out / ("watchers_" + std::to_string(process) + ".json");
  }

  void startWatchers() {
    for (int left = options_.watchers; left > 0; left -= kWatchersPerProcess) {
      const std::size_t process = watchers_.size();
      std::filesystem::remove(logOf(process));
      const int viewers =
          left == options_.watchers ? std::min(options_.viewers, std::min(left, kWatchersPerProcess)) : 0;
      watchers_.emplace_back(
          std::vector<std::string>{self().string(), "watch", "--nats", cluster_.urls(), "--session", kSession,
                                   "--count", std::to_string(std::min(left, kWatchersPerProcess)), "--viewers",
                                   std::to_string(viewers), "--summary", summaryOf(process).string()},
          logOf(process), [] { static_cast<void>(nice(kLowPriority)); });
    }
  }

  /// Until all watchers hold what the server holds.
  void awaitStep(double patience_s) {
    const auto revision = editor_->latest()->scene->revision();
    waitUntil(patience_s, "all watchers hold revision " + std::to_string(revision), [&] {
      server_->checkAlive();
      if (!relay_.alive()) throw std::runtime_error("the relay has ended by itself: see relay.log");
      const auto scene = auditor_->latest()->scene;
      if (scene->revision() < revision) return false;
      for (std::size_t i = 0; i < watchers_.size(); ++i) {
        if (!watchers_[i].alive()) throw std::runtime_error("watchers have ended: see " + logOf(i).string());
        if (!lineOf(logOf(i), allHold(scene->revision(), scene->root()))) return false;
      }
      return true;
    });
  }

  /// Edits go on all the time; the relay is killed in equal distances.
  void follow(double seconds, int kills) {
    const std::uint64_t began_ns = monotonicNow_ns();
    for (int edits = 0, killed = 0; secondsSince(began_ns) < seconds;) {
      if (secondsSince(began_ns) * plan_.edits_Hz >= edits) {
        ++edits;
        edit();
      }
      if (killed < kills && secondsSince(began_ns) > (killed + 1) * seconds / (kills + 1)) {
        ++killed;
        killRelay();
      }
      server_->checkAlive();
      std::this_thread::sleep_for(kLook);
    }
    waitUntil(kAudiencePatience_s, "the last edit is answered", [this] { return answered_ == asked_; });
  }

  void editAFew() {
    for (int i = 0; i < kEditsAtTheEnd; ++i) edit();
    waitUntil(kAudiencePatience_s, "the last edit is answered", [this] { return answered_ == asked_; });
  }

  /// Moves the last object to and fro.
  void edit() {
    const auto scene = editor_->latest()->scene;
    v1::ObjectState object;
    toWire(*scene->objects().back(), object);
    v1::Transaction transaction;
    auto& move = *transaction.add_operations()->mutable_set_pose();
    move.mutable_object()->set_id(object.id());
    *move.mutable_pose() = object.pose();
    v1::Vector3& position = *move.mutable_pose()->mutable_position();
    position.set_x(position.x() + (asked_ % 2 == 0 ? kMove_m : -kMove_m));
    ++asked_;
    const auto replied = [this](const v1::EditReply& reply) {
      if (!reply.has_accepted()) ++refused_;
      ++answered_;
    };
    editor_->submit(std::move(transaction), {.replied = replied, .live = {}});
  }

  RunPlan plan_;
  AudienceRunOptions options_;
  NatsCluster cluster_;
  std::string scene_;
  std::uint16_t port_ = 0;
  std::unique_ptr<ServerProcess> server_;
  std::unique_ptr<Auditor> auditor_;
  Child relay_;
  std::vector<Child> watchers_;
  int asked_ = 0;
  std::atomic<int> answered_{0}, refused_{0};
  std::vector<std::pair<std::uint64_t, std::uint64_t>> with_;
  std::vector<Auditor::Pulse> pulses_;
  std::vector<std::uint64_t> ages_ = std::vector<std::uint64_t>(kAgeBins);
  Json seen_ = Json::object();
  std::string leader_;
  double relay_s_ = 0, relayMeasured_s_ = 0, joining_s_ = 0;
  int killed_ = 0;
  std::uint64_t committed_ = 0;
  std::unique_ptr<ServerLink> editor_;  // last: its thread answers
};

}  // namespace

Json runAudience(const RunPlan& plan, const AudienceRunOptions& options) {
  std::filesystem::create_directories(options.out);
  AudienceRun run(plan, options);
  const double turn_s = plan.seconds / kTurns;
  for (int turn = 0; turn < kTurns; ++turn) {
    run.withoutAudience(turn_s / 2);
    run.withAudience(turn_s, options.kills / kTurns + (turn < options.kills % kTurns ? 1 : 0));
    run.noteRelay();
    if (turn + 1 == kTurns) run.startAnew();
    run.endAudience();
  }
  return run.report();
}

}  // namespace haptics::stress
