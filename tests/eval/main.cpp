#include <malloc.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <iterator>
#include <stdexcept>

#include "common/text/printable.h"
#include "haptic_server/device/presets.h"
#include "tests/eval/verb_options.h"
#include "tests/eval/verbs.h"
#include "tests/eval/worst/import_hunt.h"

namespace haptics::eval {
namespace {

constexpr int kExitFailed = 1;

/// Every verb of this program.
void addVerbs(Command& app, Arguments& arguments);

/// Parses what makes a sweep; it runs nothing.
std::unique_ptr<Sweep> makeSweep(const SweepArguments& sweep, const std::filesystem::path& out) {
  constexpr const char* kSweeps[] = {"failures", "walk", "stability", "worst"};
  const std::string verb = sweep.empty() ? "" : sweep.front();
  if (std::ranges::find(kSweeps, verb) == std::end(kSweeps)) throw std::invalid_argument(verb + " is no sweep");
  CommandLine app;
  Arguments arguments;
  arguments.fromElsewhere = true;
  addVerbs(app, arguments);
  SweepArguments whole = sweep;
  whole.insert(whole.end(), {"--out", out.string()});
  if (const auto parsed = app.parse(whole); !parsed) throw std::invalid_argument(verb + ": " + parsed.error().text());
  if (!arguments.sweep) throw std::invalid_argument(verb + ": these options make no sweep");
  return std::move(arguments.sweep);
}

Option addNats(Command& verb, NatsServer& nats, const char* about) {
  const Option url = verb.option("--nats", nats.url, about).typeName("URL");
  verb.option("--nats-credentials", nats.credentials,
              "For NATS: lines \"user: NAME\" and \"password: TEXT\", and perhaps the certificate to trust")
      .typeName("FILE")
      .existingFile()
      .needs(url);
  return url;
}

}  // namespace

void addSweep(Command& verb, Arguments& arguments) {
  const auto isShard = [](const std::string& text) -> Result<void> {
    if (!Shard::fromText(text)) return refused("", text + ": give I/N, the I-th of N, such as 2/8");
    return {};
  };
  const Option shard = verb.option(
                               "--shard",
                               [&arguments](const std::string& text) -> Result<void> {
                                 arguments.shard = Shard::fromText(text);
                                 return {};
                               },
                               "Run only every N-th part from the I-th on, for haptic_eval merge")
                           .typeName("I/N")
                           .check(isShard);
  addNats(verb, arguments.nats, "Let the workers at this NATS server run it, such as nats://127.0.0.1:4222")
      .excludes(shard);
}

namespace {

void addTextures(Command& app, Arguments& arguments) {
  Command verb = addVerb(
      app,
      {"textures", "Texture families, friction and force shading, measured, with a contact sheet", "--out results"},
      arguments.textures.out);
  addSeed(verb, arguments.textures.seed);
  setRun(verb, [&arguments] { arguments.good = runTextures(arguments.textures); });
}

void addTable1(Command& app, Arguments& arguments) {
  Command verb = addVerb(app,
                         {"table1", "The paper's Table I: rates of the servo loop with the viewer connected",
                          "--seconds 10 --out results", "Ctrl-C ends it early: what was measured is written."},
                         arguments.table1.out);
  Table1Options& options = arguments.table1;
  const Option seconds =
      verb.option("--seconds", options.seconds, "For each object").check(moreThanZero()).showDefault();
  const Option runs = addCount(verb, "--runs", options.runs, "As many times that long");
  verb.flag("--paper", arguments.asInPaper, "Three times three minutes for each object, as in the paper")
      .excludes(seconds)
      .excludes(runs);
  addFinest(verb, options.finest, "Leave out spheres of more triangles, besides the paper's objects");
  setRun(verb, [&arguments, &options] {
    constexpr double kPaper_s = 180;
    constexpr int kPaperRuns = 3;
    if (arguments.asInPaper) {
      options.seconds = kPaper_s;
      options.runs = kPaperRuns;
    }
    arguments.good = runTable1(options);
  });
}

void addStability(Command& app, Arguments& arguments) {
  Command verb = addVerb(
      app,
      {"stability", "How stiff a surface every device bears: methods side by side, theory, robustness, energy",
       "--out results",
       "The whole takes some minutes, --full an hour. Exit status 0: every limit of ours is kept and the plant agrees\n"
       "with the formulas of the literature."},
      arguments.stability.out);
  StabilityOptions& options = arguments.stability;
  const Option shortRun =
      verb.flag("--short", options.shortRun, "Three devices and the least of everything; draws nothing");
  verb.flag("--full", options.full, "Every hand, rate and delay").excludes(shortRun);
  addFile(verb, "--from", options.from, "Draw this stability.json of an earlier run again, and measure nothing");
  addSweep(verb, arguments);
  setRun(verb, [&arguments, &options] {
    if (options.from.empty()) {
      arguments.sweep = makeStabilitySweep(options);
      arguments.sweepOut = &options.out;
    } else {
      redrawStability(options);
    }
  });
}

void addTeleoperation(Command& app, Arguments& arguments) {
  Command verb = addVerb(
      app,
      {"teleoperation", "A robot that a hand leads over lines with delay, jitter and loss: passivity, rest, packets",
       "--out results",
       "This runtime's coupling beside wave variables, position-force and position-position without an\n"
       "account of energy. Exit status 0: ours makes no energy, is at rest within 1 s, and sends at most\n"
       "a quarter of the packets. --full takes some minutes."},
      arguments.teleoperation.out);
  TeleoperationOptions& options = arguments.teleoperation;
  addSeed(verb, options.seed);
  const Option shortRun =
      verb.flag("--short", options.shortRun, "Ours without delay and with the longest; draws nothing");
  verb.flag("--full", options.full, "Ours also with every device, over ten lines each").excludes(shortRun);
  setRun(verb, [&arguments, &options] { arguments.good = runTeleoperation(options); });
}

void addAdvise(Command& app, Arguments& arguments) {
  constexpr const char* kInventorModels = "/usr/share/inventor/data";  // Debian's: the demo scene's head
  AdviseOptions& options = arguments.advise;
  options.devicePreset = kDefaultDevicePreset;
  if (std::filesystem::is_directory(kInventorModels)) options.assets.emplace_back(kInventorModels);
  Command verb = addVerb(
      app,
      {"advise",
       "What your own scene needs: the cheapest meshes, the lowest rate, stiffness and damping, a tool's spacing",
       "deploy/scenes/demo.scene --out results",
       "A line for each object says which mesh to use, and what of it is not felt or not judged: what moves,\n"
       "yields or is held. A shaded object is judged by its shaded force. Of a tool it looks at the spacing of\n"
       "its points; the other objects are judged under a point then too. --apply writes the advised scene,\n"
       "ready for haptic_server, and tries it on other strokes. Exit status 1: it is felt to differ, or the IHIP was\n"
       "inside a body.\n"
       "  haptic_eval advise deploy/scenes/demo.scene --out results --apply results/advised"},
      arguments.advise.out);
  verb.option("SCENE", options.scene, "Scene file, as haptic_server takes it").required();
  verb.option("--assets", options.assets, "Folder of meshes that the scene names, besides the scene's own")
      .typeName("DIR")
      .existingFolder()
      .showDefault();
  verb.option("--device-preset", options.devicePreset, "Device that is to rest on the objects").showDefault();
  verb.option("--tolerance", options.tolerance,
              "How far a copy may stray from the scene's mesh, as a part of the object's longest side")
      .check(moreThanZero())
      .showDefault();
  verb.option("--apply", options.apply,
              "Write the advised scene, with its meshes beside it, into this folder; nothing there is replaced")
      .typeName("DIR");
  setRun(verb, [&arguments, &options] { arguments.good = runAdvise(options); });
}

void addReplay(Command& app, Arguments& arguments) {
  Command verb = addVerb(app,
                         {"replay", "A recording of haptic_server again: is every force the same, bit for bit?",
                          "ticks.haptics --telemetry felt",
                          "haptic_server --record FILE makes recordings, and so do faults and hapticctl dump."},
                         arguments.out);
  ReplayOptions& options = arguments.replay;
  verb.option("FILE", options.recording, "Recording").required();
  verb.option("--telemetry", options.telemetry,
              "Write what was felt in each tick here (length-delimited haptics.v1.Telemetry)")
      .typeName("FILE");
  setRun(verb, [&arguments, &options] { arguments.good = runReplay(options, arguments.out); });
}

void addWorst(Command& app, Arguments& arguments) {
  Command verb = addVerb(
      app,
      {"worst", "Hunts for the slowest tick: scenes and motions changed towards more work",
       "--seconds 300 --out results",
       "Exit status 1: a tick took more than the instructions of 250 us at 1 kHz, in proportion at other rates.\n"
       "  haptic_eval worst --family soup --without-allowance\n"
       "  haptic_eval worst --kept results/worst.json --rate 4000\n"
       "  haptic_eval worst --import --seconds 300 --out results\n"
       "With --import: the slowest import of a mesh, which may take 2 s for 100,000 triangles and grow with the power "
       "1.2\n"
       "of their number."},
      arguments.worst.out);
  WorstOptions& options = arguments.worst;
  addSeed(verb, options.seed);
  verb.option("--seconds", options.seconds, "Of the hunt; counting and drawing come after it")
      .check(moreThanZero())
      .showDefault();
  const Option rate = verb.option("--rate", options.rate_Hz, "Of the servo, Hz").range(100.0, 16000.0).showDefault();
  verb.option("--family", options.family, "Only scenes of this one, such as soup").typeName("NAME");
  const Option without =
      verb.flag("--without-allowance", options.withoutAllowance, "Ticks that take as long as they take");
  verb.flag("--import", arguments.worstImport, "Imports of meshes in place of ticks").excludes(rate).excludes(without);
  addFile(verb, "--kept", options.kept, "The worst ones of an earlier hunt again: its worst.json");
  addSweep(verb, arguments);
  setRun(verb, [&arguments, &options] {
    if (arguments.worstImport && (arguments.shard || !arguments.nats.url.empty()))
      throw std::invalid_argument("--import: hunts for imports are not divided; leave out --shard and --nats");
    if (arguments.worstImport) {
      arguments.good = runWorstImport(options);
    } else {
      arguments.sweep = makeWorstSweep(options);
      arguments.sweepOut = &options.out;
    }
  });
}

void addMerge(Command& app, Arguments& arguments) {
  Command verb = addVerb(app,
                         {"merge", "What the shards of a verb came to together, as if it had been run at once",
                          "shards/failures.shard-*.json --out results",
                          "  haptic_eval failures --seeds 1000 --shard 1/4 --out shards\n"
                          "Any number of shards may run at once, on any machines, by one build of this program."},
                         arguments.out);
  verb.option("FILES", arguments.shards, "What --shard I/N wrote, of each shard").required();
  setRun(verb, [&arguments] {
    const auto make = [&arguments](const SweepArguments& sweep) { return makeSweep(sweep, arguments.out); };
    arguments.good = mergeShards(arguments.shards, make);
  });
}

void addWorker(Command& app, Arguments& arguments) {
  Command verb = app.verb("worker", "Runs parts of verbs that are given --nats, until Ctrl-C");
  verb.footer(
      "Example:\n  haptic_eval worker --nats nats://127.0.0.1:4222\n"
      "One for each core, on any machine, of the build that the verb itself is run with. It may be ended at any time:\n"
      "another one runs its part again.");
  addNats(verb, arguments.nats, "Where the parts are, such as nats://127.0.0.1:4222").required();
  setRun(verb, [&arguments] {
    workOnSweeps(arguments.nats, [](const SweepArguments& sweep) { return makeSweep(sweep, "."); });
  });
}

void addVerbs(Command& app, Arguments& arguments) {
  for (const auto add : {addFailures, addJudge, addAccuracy, addCombinations, addChart, addTextures, addTable1, addWalk,
                         addAdvise, addStability, addTeleoperation, addReplay, addFuzz, addWorst, addMerge, addWorker})
    add(app, arguments);
}

bool runDivided(Arguments& arguments, const SweepArguments& sweep) {
  if (!arguments.nats.url.empty()) return runSweepOverNats(*arguments.sweep, sweep, arguments.nats);
  if (!arguments.shard) return runSweep(*arguments.sweep);
  runShard(*arguments.sweep, *arguments.shard, sweep, *arguments.sweepOut);
  return true;
}

void mustBeVerb(const Command& app, const std::string& name) {
  std::string known;
  for (const std::string& verb : app.verbs()) {
    if (verb == name) return;
    known += (known.empty() ? "" : ", ") + verb;
  }
  throw std::invalid_argument("there is no verb " + name + "; there are " + known);
}

int run(int argc, char** argv) {
  CommandLine app{"Evaluates the haptic step and baselines in virtual time, and the server's loop against the paper's.",
                  "haptic_eval"};
  app.version("haptic_eval " HAPTICS_VERSION);
  app.needVerb();
  app.footer("Exit status 1: ours failed somewhere, or a baseline passed or failed where it is not expected to.");
  Arguments arguments;
  addVerbs(app, arguments);
  if (argc > 1 && argv[1][0] != '-') mustBeVerb(app, argv[1]);
  if (const auto code = app.parse(argc, argv)) return *code;
  if (arguments.sweep) arguments.good = runDivided(arguments, sweepArguments(argc, argv));
  return arguments.good ? 0 : kExitFailed;
}

}  // namespace
}  // namespace haptics::eval

int main(int argc, char** argv) {
  // What a trial frees the next one takes: pages that go back to the system are cleared for each.
  mallopt(M_MMAP_THRESHOLD, 32 << 20);
  mallopt(M_TRIM_THRESHOLD, 256 << 20);
  try {
    return haptics::eval::run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "haptic_eval: %s\n", haptics::printable(error.what()).c_str());
    return haptics::eval::kExitFailed;
  }
}
