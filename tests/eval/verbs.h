#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/command_line/command_line.h"
#include "tests/eval/accuracy.h"
#include "tests/eval/advise/advise.h"
#include "tests/eval/chart.h"
#include "tests/eval/combinations/combinations.h"
#include "tests/eval/exchange/judge.h"
#include "tests/eval/failures.h"
#include "tests/eval/fuzz/contact_fuzz.h"
#include "tests/eval/replay/replay_verb.h"
#include "tests/eval/stability/stability.h"
#include "tests/eval/sweep/nats_sweep.h"
#include "tests/eval/sweep/sweep.h"
#include "tests/eval/table1/table1.h"
#include "tests/eval/teleoperation/teleoperation.h"
#include "tests/eval/textures/textures.h"
#include "tests/eval/walk/walk.h"
#include "tests/eval/worst/worst.h"

// Each verb in a function of its own; parsing the command line runs it.
namespace haptics::eval {

struct Arguments {
  bool fromElsewhere = false;       ///< Somebody else's sweep: it starts no program of its choice here.
  std::filesystem::path out = ".";  ///< Of verbs whose options have none.
  FailuresOptions failures;
  JudgeOptions judge;
  AccuracyOptions accuracy;
  CombinationsOptions combinations;
  ChartOptions chart;
  std::filesystem::path toolBench;
  Table1Options table1;
  bool asInPaper = false;
  WalkOptions walk;
  bool walkTool = false;
  TexturesOptions textures;
  AdviseOptions advise;
  StabilityOptions stability;
  TeleoperationOptions teleoperation;
  ReplayOptions replay;
  FuzzOptions fuzz;
  WorstOptions worst;
  bool worstImport = false;
  std::string fuzzMethod;  ///< Empty: the contact core.
  std::filesystem::path fuzzRecording;

  std::unique_ptr<Sweep> sweep;  ///< Of a verb that is one: it is run when all is known.
  const std::filesystem::path* sweepOut = &out;
  std::optional<Shard> shard;
  NatsServer nats;
  std::vector<std::filesystem::path> shards;

  bool good = true;  ///< What the verb came to.
};

/// With --shard and --nats: how a verb is run that is a sweep.
void addSweep(Command& verb, Arguments& arguments);
void addMethod(Command& verb, std::string& method, const char* about);

// Those that a method can be given to.
void addFailures(Command& app, Arguments& arguments);
void addJudge(Command& app, Arguments& arguments);
void addAccuracy(Command& app, Arguments& arguments);
void addCombinations(Command& app, Arguments& arguments);
void addChart(Command& app, Arguments& arguments);
void addWalk(Command& app, Arguments& arguments);
void addFuzz(Command& app, Arguments& arguments);

}  // namespace haptics::eval
