#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "tests/sim/editor.h"
#include "tests/sim/line.h"
#include "tests/sim/sim_client.h"
#include "tests/sim/sim_server.h"
#include "tests/sim/stage.h"

namespace haptics::sim {

/// What goes wrong in one world. Drawn from its seed, so that each world has a few troubles of its own rather than all
/// of them a little.
struct Troubles {
  bool cuts, silences, stalls, slowLines, crumbs;              // the network
  bool restarts, resets, busyBuilder, slowServo, slowWorkers;  // the server
  bool badDisk, tokens;
  bool deaths, stops, corruption, oldConnections, flood;  // the clients
};

/// One server and its clients, from the first connection until every database is equal.
class Simulation {
 public:
  Simulation(std::uint64_t seed, Mutant mutant, EventLog::Mode mode);

  void run();
  [[nodiscard]] const Oracle& oracle() const noexcept { return stage_.oracle; }
  [[nodiscard]] const EventLog& log() const noexcept { return stage_.log; }
  [[nodiscard]] double lasted_s() const noexcept { return 1e-9 * static_cast<double>(stage_.time.now_ns()); }

 private:
  struct Seat {  // of one client
    Weather weather;
    std::string token = {};
    std::unique_ptr<SimClient> client;
    std::unique_ptr<Editor> editor;
  };

  Stage stage_;
  const Troubles troubles_;
  const std::uint64_t calmFrom_ns_;
  ServerPace pace_;
  std::vector<std::unique_ptr<Seat>> seats_;  // their weather outlives the server's ends of the lines
  SimServer server_;

  void sit(Seat& seat);
  void makeWeather(Seat& seat);
  /// Again and again until the calm, at random times.
  void often(double pause_ms, bool wanted, void (Simulation::*trouble)());
  void cutALine();
  void silenceALine();
  void changeWeather();
  void restartServer();
  void resetServer();
  void crashFor(bool keepState);
  void troubleTheDisk();
  void withdrawTokens();
  void withdraw(std::set<std::string> tokens);
  void killAClient();
  void stopAClient();
  void corruptAClient();
  void abandonALine();
  void calm();
  void awaitAnswers();
  void awaitEquality();
  [[nodiscard]] Seat& anySeat() { return *seats_[stage_.random.below(seats_.size())]; }
  [[nodiscard]] std::uint64_t untilCalm_ns() const { return calmFrom_ns_ - stage_.time.now_ns(); }
  [[nodiscard]] bool allEqual() const;
};

}  // namespace haptics::sim
