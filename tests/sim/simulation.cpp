#include "tests/sim/simulation.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <utility>

namespace haptics::sim {
namespace {

constexpr std::uint64_t kStep_ns = 100 * kMillisecond_ns;
constexpr std::uint64_t kAnswersWithin_ns = 20 * kSecond_ns;
constexpr std::uint64_t kEqualWithin_ns = 5 * kSecond_ns;
constexpr std::size_t kMaxClients = 6;
const std::set<std::string> kTokens{"token a", "token b", "token c"};
constexpr std::size_t kFlood = 1100;  // more than a server takes from one client at once

Troubles draw(Random& random) {
  const auto maybe = [&random](double chance = 0.4) { return random.chance(chance); };
  Troubles t{};
  t.cuts = maybe(0.6), t.silences = maybe(), t.stalls = maybe(), t.slowLines = maybe(0.2), t.crumbs = maybe(0.2);
  t.restarts = maybe(), t.resets = maybe(0.25), t.busyBuilder = maybe(0.3), t.slowServo = maybe(0.3);
  t.deaths = maybe(0.2), t.stops = maybe(0.3), t.corruption = maybe(0.5), t.oldConnections = maybe(0.3),
  t.flood = maybe(0.01);
  t.badDisk = maybe(0.15), t.tokens = maybe(0.15);
  t.slowWorkers = maybe(0.5);
  return t;
}

}  // namespace

Simulation::Simulation(std::uint64_t seed, Mutant mutant, EventLog::Mode mode)
    : stage_(seed, mutant, mode),
      troubles_(draw(stage_.random)),
      calmFrom_ns_(stage_.random.milliseconds(6000, 12000)),
      server_(stage_, pace_) {
  if (troubles_.busyBuilder) pace_ = {.build_ms = 60, .adopt_ms = 10, .builderQueue = 3};
  if (troubles_.slowServo) pace_.adopt_ms = 1500;
  if (troubles_.slowWorkers) pace_.prepare_ms = 1500;
  pace_.handDents = true;
  stage_.log.add([&limits = stage_.limits] {
    return std::to_string(limits.startObjects) + " objects, frames of " +
           std::to_string(limits.session.frames.frame_bytes) + " bytes, chunks of " +
           std::to_string(limits.session.frames.chunk_bytes) + ", details of " +
           std::to_string(limits.scene.details_bytes);
  });
  if (troubles_.tokens) withdraw({});
  server_.start(false);
  const std::size_t clients = 2 + stage_.random.below(kMaxClients - 1);
  for (std::size_t i = 0; i < clients; ++i) {
    seats_.push_back(std::make_unique<Seat>());
    makeWeather(*seats_.back());
    if (troubles_.tokens) seats_.back()->token = *std::next(kTokens.begin(), stage_.random.below(kTokens.size()));
    sit(*seats_.back());
  }
  often(1500, troubles_.cuts, &Simulation::cutALine);
  often(3000, troubles_.silences, &Simulation::silenceALine);
  often(1000, troubles_.stalls || troubles_.slowLines, &Simulation::changeWeather);
  often(3000, troubles_.restarts, &Simulation::restartServer);
  often(4000, troubles_.resets, &Simulation::resetServer);
  often(1000, troubles_.badDisk, &Simulation::troubleTheDisk);
  often(2000, troubles_.tokens, &Simulation::withdrawTokens);
  often(3000, troubles_.deaths, &Simulation::killAClient);
  often(2500, troubles_.stops, &Simulation::stopAClient);
  often(1000, troubles_.corruption, &Simulation::corruptAClient);
  often(1500, troubles_.oldConnections, &Simulation::abandonALine);
}

void Simulation::run() {
  stage_.time.runUntil(calmFrom_ns_);
  calm();
  awaitAnswers();
  awaitEquality();
  for (const auto& seat : seats_) stage_.oracle.quiet(*server_.history(), seat->client->id(), seat->client->view());
  stage_.oracle.settled();
}

void Simulation::sit(Seat& seat) {
  const auto dial = [this](const Weather& weather) -> std::optional<Line> {
    if (!server_.up()) return std::nullopt;
    Line line(stage_.time, stage_.random, weather);
    server_.accept(line.takeServer());
    return line;
  };
  Habits habits;
  habits.checksHashes = troubles_.corruption;
  if (troubles_.flood && &seat == seats_.front().get()) habits.flood = kFlood;
  seat.client = std::make_unique<SimClient>(stage_, seat.weather, dial, seat.token, troubles_.corruption);
  seat.editor = std::make_unique<Editor>(stage_, *seat.client, habits);
}

void Simulation::makeWeather(Seat& seat) {
  Random& random = stage_.random;
  seat.weather = {.latency_ms = random.uniform(0.1, 80), .jitter_ms = random.uniform(0, 20)};
  if (troubles_.stalls) seat.weather.stallChance = random.uniform(0, 0.05);
  if (troubles_.slowLines) seat.weather.bytesPerSecond = random.uniform(2e4, 2e5);
  if (troubles_.crumbs) seat.weather.largestPiece = 40;
}

void Simulation::often(double pause_ms, bool wanted, void (Simulation::*trouble)()) {
  if (!wanted) return;
  const double wait_ms = -std::log(1 - stage_.random.uniform(0, 0.999)) * pause_ms;
  stage_.time.after(stage_.random.milliseconds(wait_ms, wait_ms), [this, pause_ms, trouble] {
    if (stage_.time.now_ns() >= calmFrom_ns_) return;
    (this->*trouble)();
    often(pause_ms, true, trouble);
  });
}

void Simulation::cutALine() {
  anySeat().client->withLine([](Line& line) { line.cut(); });
}

void Simulation::silenceALine() {
  anySeat().client->withLine([](Line& line) { line.fallSilent(); });
}

void Simulation::changeWeather() { makeWeather(anySeat()); }

void Simulation::restartServer() {
  if (stage_.random.chance(0.5)) return crashFor(true);
  server_.dieInNextWrite([this] { crashFor(true); });
}

void Simulation::resetServer() { crashFor(false); }

void Simulation::crashFor(bool keepState) {
  if (!server_.up()) return;
  server_.crash();
  const std::uint64_t calmIn_ns = std::max(calmFrom_ns_, stage_.time.now_ns()) - stage_.time.now_ns();
  const std::uint64_t down_ns = std::min(stage_.random.milliseconds(10, 1500), calmIn_ns);
  stage_.time.after(down_ns, [this, keepState] { server_.start(keepState); });
}

void Simulation::troubleTheDisk() {
  if (stage_.random.chance(0.5)) return server_.disk().recover();
  stage_.log.add([] { return "the disk fails"; });
  server_.disk().fail();
}

void Simulation::withdrawTokens() {
  std::set<std::string> tokens;
  for (const std::string& token : kTokens) {
    if (stage_.random.chance(0.3)) tokens.insert(token);
  }
  withdraw(std::move(tokens));
}

/// Gives back those that were withdrawn before.
void Simulation::withdraw(std::set<std::string> tokens) {
  std::vector<std::string> known;
  std::ranges::set_difference(kTokens, tokens, std::back_inserter(known));
  stage_.oracle.tokensWithdrawn(std::move(tokens));
  server_.knowTokens(known);
}

void Simulation::killAClient() {
  Seat& seat = anySeat();
  stage_.log.add(
      [&] { return "client " + std::to_string(seat.client->id() % 1000) + ": dies, another takes its seat"; });
  if (stage_.random.chance(0.5)) seat.client->withLine([](Line& line) { line.fallSilent(); });
  stage_.oracle.clientDied(seat.client->id());
  seat.editor.reset();
  seat.client.reset();
  sit(seat);
}

void Simulation::stopAClient() {
  anySeat().client->stopFor(std::min(stage_.random.milliseconds(100, 5000), untilCalm_ns()));
}

void Simulation::corruptAClient() { anySeat().client->corruptMemory(); }

/// The client leaves and comes back at once; what it had sent before still arrives.
void Simulation::abandonALine() { anySeat().client->reconnect(); }

/// The last trouble is over: the network is good, the server is up and nobody asks for changes any more.
void Simulation::calm() {
  stage_.log.add([] { return "calm"; });
  pace_ = {};
  server_.disk().recover();
  for (const auto& seat : seats_) {
    seat->weather = {};
    seat->editor->stop();
    if (troubles_.cuts) seat->client->withLine([](Line& line) { line.cut(); });
  }
  if (troubles_.tokens) {
    withdraw({});
    stage_.time.runUntil(stage_.time.now_ns() + ClientSession::kRefusedDelay_ns);
  }
  while (!server_.up()) stage_.time.runUntil(stage_.time.now_ns() + kStep_ns);
}

void Simulation::awaitAnswers() {
  // A flood is let through at the rate of one client.
  const double flood_s = troubles_.flood ? static_cast<double>(kFlood) / stage_.limits.session.editsPerSecond : 0;
  const std::uint64_t end_ns =
      stage_.time.now_ns() + kAnswersWithin_ns + static_cast<std::uint64_t>(flood_s * static_cast<double>(kSecond_ns));
  const auto waiting = [](const auto& seat) { return seat->client->unanswered() > 0; };
  while (std::ranges::any_of(seats_, waiting) && stage_.time.now_ns() < end_ns) {
    stage_.time.runUntil(stage_.time.now_ns() + kStep_ns);
  }
  for (const auto& seat : seats_) {
    if (waiting(seat)) stage_.oracle.stuck(seat->client->id(), seat->client->unanswered());
  }
}

void Simulation::awaitEquality() {
  const std::uint64_t end_ns = stage_.time.now_ns() + kEqualWithin_ns;
  while (!allEqual() && stage_.time.now_ns() < end_ns) stage_.time.runUntil(stage_.time.now_ns() + kStep_ns);
}

bool Simulation::allEqual() const {
  return std::ranges::all_of(seats_, [this](const auto& seat) {
    const MirrorView view = seat->client->view();
    const auto root = recomputedRoot(view);
    return view.hashesEqual && view.epoch == server_.history()->epoch && root &&
           *root == server_.history()->version.root();
  });
}

}  // namespace haptics::sim
