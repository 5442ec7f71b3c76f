#include "tests/stress/run.h"

#include <unistd.h>

#include <atomic>
#include <csignal>
#include <fstream>
#include <stdexcept>
#include <thread>

#include "common/clock/monotonic.h"
#include "tests/eval/figure/virtual_display.h"
#include "tests/stress/child.h"
#include "tests/stress/network.h"
#include "tests/stress/stress_scene.h"

namespace haptics::stress {
namespace {

using std::chrono::milliseconds;

constexpr double kStart_s = 5;         // until all have joined
constexpr double kRest_s = 9;          // after the last attack; they have 5 s to be equal
constexpr double kRunPatience_s = 30;  // for a process to start or to end
constexpr double kStopped_s = 5;       // longer than the server waits for a byte
constexpr milliseconds kRunLook{50};

std::filesystem::path programs() { return std::filesystem::read_symlink("/proc/self/exe").parent_path(); }

std::string lastMatch(const std::filesystem::path& file, const std::string& prefix) {
  std::ifstream in(file);
  std::string found;
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with(prefix)) found = line.substr(prefix.size());
  }
  return found;
}

/// The processes of one run.
class ProcessSet {
 public:
  ProcessSet(RunPlan& plan, const RunOptions& options, Network& network)
      : plan_(plan), out_(options.out), network_(network), viewers_(options.viewer) {
    std::ofstream(out_ / "stress.scene") << sceneText(plan.clients);
    startServer();
    address_ = network_.clientAddress(port_);
    plan_.began_ns = monotonicNow_ns() + static_cast<std::uint64_t>(kStart_s * 1e9);
    network_.start();
    clients_.resize(static_cast<std::size_t>(plan.clients) +
                    1);  // the last one only views, and is stopped now and then
    lives_.resize(clients_.size());
    for (int client = 0; client <= plan.clients; ++client) startClient(client);
    if (viewers_ && std::filesystem::exists(programs() / "graphics_client")) startViewer();
    std::thread([this] {
      network_.enterServerSide();
      auditor_ =
          std::make_unique<Auditor>(Endpoint{network_.serverHost(), port_}, [this] { return serverLife_.load(); });
    }).join();
  }

  void startServer() {
    ++serverLife_;
    const auto log = out_ / ("server_" + std::to_string(serverLife_) + ".log");
    std::vector<std::string> command{(programs() / "haptic_server").string(),
                                     "--scene",
                                     (out_ / "stress.scene").string(),
                                     "--state",
                                     (out_ / "state").string(),
                                     "--summary",
                                     (out_ / "server.json").string(),
                                     "--allow-insecure-lan",
                                     "--listen",
                                     network_.serverHost() + ":" + std::to_string(port_)};
    server_ = Child(command, log, [this] { network_.enterServerSide(); });
    serverBegan_ns_ = monotonicNow_ns();
    std::string where;
    for (double waited_s = 0; (where = lastMatch(log, "listening on ")).empty(); waited_s += 0.02) {
      if (waited_s > kRunPatience_s || !server_.alive())
        throw std::runtime_error("the server does not start: see " + log.string());
      std::this_thread::sleep_for(milliseconds(20));
    }
    port_ = static_cast<std::uint16_t>(std::stoi(where.substr(where.rfind(':') + 1)));
  }

  void startClient(int client) {
    const auto at = static_cast<std::size_t>(client);
    const std::uint64_t life = ++lives_[at];
    std::vector<std::string> command{std::filesystem::read_symlink("/proc/self/exe").string(),
                                     "client",
                                     "--number",
                                     std::to_string(client),
                                     "--life",
                                     std::to_string(life),
                                     "--connect",
                                     address_,
                                     "--journal",
                                     journalOf(client, life).string()};
    if (datagrams(client)) command.emplace_back("--udp");
    if (client == plan_.clients) command.emplace_back("--view");
    for (const auto& argument : toArguments(plan_)) command.push_back(argument);
    clients_[at] = Child(command, out_ / "clients.log", [this] { network_.enterClientSide(); });
  }

  void startViewer() {
    if (!display_) {
      auto display = eval::VirtualDisplay::ensure();
      if (!display) return;
      display_ = *std::move(display);
    }
    viewer_ = Child({(programs() / "graphics_client").string(), "--connect", address_, "--offscreen", "--size",
                     "320x256", "--fps-limit", "4", "--udp"},
                    viewerLog(), [this] { network_.enterClientSide(); });
  }

  void startDribbler() {
    dribbler_ = Child({std::filesystem::read_symlink("/proc/self/exe").string(), "dribble", "--connect", address_},
                      out_ / "clients.log", [this] { network_.enterClientSide(); });
  }
  void stopDribbler() { dribbler_.kill(); }

  /// Number `turn` of an endless round: every process is killed in its turn, the viewer stopped.
  std::string disturb(std::size_t turn) {
    const std::size_t victim = turn % (static_cast<std::size_t>(plan_.clients) + 3);
    if (victim == 0) {
      clients_.back().signal(SIGSTOP);
      continueAt_ns_ = monotonicNow_ns() + static_cast<std::uint64_t>(kStopped_s * 1e9);
      return "viewer stopped";
    }
    if (victim == 1) {
      server_.kill();
      startServer();
      return "server killed";
    }
    if (victim == 2) {
      if (viewer_.id() == 0) return "";
      viewer_.kill();
      startViewer();
      return "graphics_client killed";
    }
    const int client = static_cast<int>(victim) - 3;
    clients_[static_cast<std::size_t>(client)].kill();
    startClient(client);
    return "client " + std::to_string(client) + " killed";
  }

  void look() {
    const std::uint64_t now_ns = monotonicNow_ns();
    if (continueAt_ns_ != 0 && now_ns >= continueAt_ns_) resume();
    if (!server_.alive()) throw std::runtime_error("the server has ended by itself: see its log in " + out_.string());
    if (1e-9 * static_cast<double>(now_ns - serverBegan_ns_) > kStart_s) {
      resident_MB_[serverLife_].push_back(server_.resident_MB());
    }
  }
  void resume() {
    clients_.back().signal(SIGCONT);
    continueAt_ns_ = 0;
  }

  /// Stops everything in order and hands over what it left.
  Evidence finish(bool& serverEndedWell) {
    Evidence evidence;
    for (Child& client : clients_) client.signal(SIGTERM);
    for (Child& client : clients_) client.stop(kRunPatience_s);
    if (viewer_.id() != 0) {
      viewer_.stop(kRunPatience_s);
      std::string held = lastMatch(viewerLog(), "scene revision ");
      evidence.roots["graphics_client"] = held.ends_with(" equal") ? held.substr(held.find("root ") + 5, 64) : held;
    }
    evidence.commits = auditor_->commits();
    evidence.pulses = auditor_->pulses();
    evidence.auditorGaps = auditor_->gaps();
    evidence.roots["auditor"] = auditor_->latest()->scene->root().hex();
    auditor_.reset();
    serverEndedWell = server_.stop(kRunPatience_s) == 0;
    std::ifstream summary(out_ / "server.json");
    const auto json = nlohmann::json::parse(summary, nullptr, false);
    evidence.roots["server"] = json.is_object() ? json.value("scene_hash", "") : "";
    evidence.serverResident_MB = resident_MB_;
    for (int client = 0; client <= plan_.clients; ++client) gather(client, evidence);
    return evidence;
  }

 private:
  [[nodiscard]] static bool datagrams(int client) { return client % 2 == 1; }
  [[nodiscard]] std::filesystem::path journalOf(int client, std::uint64_t life) const {
    return out_ / ("client_" + std::to_string(client) + "_" + std::to_string(life) + ".journal");
  }
  [[nodiscard]] std::filesystem::path viewerLog() const { return out_ / "graphics_client.log"; }

  void gather(int client, Evidence& evidence) const {
    const std::uint64_t lives = lives_[static_cast<std::size_t>(client)];
    for (std::uint64_t life = 1; life <= lives; ++life) {
      evidence.lives.push_back(
          {client, life, datagrams(client), client == plan_.clients, readJournal(journalOf(client, life))});
      for (const Record& record : evidence.lives.back().records) {
        if (record.kind == Record::Kind::kFinal && life == lives) {
          evidence.roots["client " + std::to_string(client)] = record.root.hex();
        }
      }
    }
    evidence.roots.try_emplace("client " + std::to_string(client), "");
  }

  RunPlan& plan_;
  std::filesystem::path out_;
  Network& network_;
  bool viewers_;
  std::string address_;
  std::uint16_t port_ = 0;
  std::unique_ptr<eval::VirtualDisplay> display_;
  Child server_, viewer_, dribbler_;
  std::vector<Child> clients_;
  std::vector<std::uint64_t> lives_;
  std::atomic<std::uint64_t> serverLife_{0};
  std::uint64_t serverBegan_ns_ = 0, continueAt_ns_ = 0;
  std::map<std::uint64_t, std::vector<double>> resident_MB_;
  std::unique_ptr<Auditor> auditor_;
};

}  // namespace

std::vector<std::string> toArguments(const RunPlan& plan) {
  return {"--clients",   std::to_string(plan.clients),    "--rtt-ms",   std::to_string(plan.rtt_ms),
          "--jitter-ms", std::to_string(plan.jitter_ms),  "--loss-pct", std::to_string(plan.loss_pct),
          "--cut-every", std::to_string(plan.cutEvery_s), "--cut-ms",   std::to_string(plan.cut_ms),
          "--seconds",   std::to_string(plan.seconds),    "--edits",    std::to_string(plan.edits_Hz),
          "--seed",      std::to_string(plan.seed),       "--began",    std::to_string(plan.began_ns)};
}

RunResult run(RunPlan plan, const RunOptions& options) {
  std::filesystem::create_directories(options.out);
  for (const auto& entry : std::filesystem::directory_iterator(options.out)) {
    const auto extension = entry.path().extension();
    if (extension == ".journal" || extension == ".log") std::filesystem::remove(entry);
  }
  std::filesystem::remove_all(options.out / "state");

  RunResult result{.plan = plan};
  auto network = options.relay ? nullptr : makeNamespaces(result.plan);
  if (!network) network = makeRelay(result.plan);
  result.network = network->kind();
  ProcessSet cast(result.plan, options, *network);
  std::size_t turn = 0;
  int block = -1;
  bool disturbed = false;
  const std::uint64_t over_ns = result.plan.end_ns() + static_cast<std::uint64_t>(kRest_s * 1e9);
  for (std::uint64_t now_ns = monotonicNow_ns(); now_ns < over_ns; now_ns = monotonicNow_ns()) {
    const bool attack = result.plan.attackAt(now_ns);
    if (result.plan.blockAt(now_ns) != block) {
      block = result.plan.blockAt(now_ns);
      disturbed = false;
      cast.stopDribbler();
      if (attack) cast.startDribbler();
    }
    const double inBlock_s = result.plan.secondsAt(now_ns) - block * result.plan.block_s();
    if (attack && !disturbed && inBlock_s > 0.3 * result.plan.block_s()) {
      disturbed = true;
      const std::string what = cast.disturb(turn++);
      if (!what.empty()) result.disturbances.push_back({now_ns, what});
    }
    cast.look();
    std::this_thread::sleep_for(kRunLook);
  }
  result.evidence = cast.finish(result.serverEndedWell);
  result.counts = network->counts();
  return result;
}

}  // namespace haptics::stress
