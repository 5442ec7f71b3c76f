#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/command_line/command_line.h"
#include "common/text/printable.h"
#include "haptic_server/device/presets.h"
#include "tests/eval/accuracy.h"
#include "tests/eval/adapters/outside_method.h"
#include "tests/eval/advise/advise.h"
#include "tests/eval/chart.h"
#include "tests/eval/combinations/combinations.h"
#include "tests/eval/exchange/judge.h"
#include "tests/eval/failures.h"
#include "tests/eval/figure/figure.h"
#include "tests/eval/fuzz/contact_fuzz.h"
#include "tests/eval/methods.h"
#include "tests/eval/replay/replay_verb.h"
#include "tests/eval/report.h"
#include "tests/eval/stability/stability.h"
#include "tests/eval/sweep/nats_sweep.h"
#include "tests/eval/sweep/sweep.h"
#include "tests/eval/table1/table1.h"
#include "tests/eval/textures/textures.h"
#include "tests/eval/verb_options.h"
#include "tests/eval/walk/tool_walk.h"
#include "tests/eval/walk/walk.h"
#include "tests/eval/worst/import_hunt.h"
#include "tests/eval/worst/worst.h"

// Each verb in a function of its own; parsing the command line runs it.
namespace haptics::eval {
namespace {

constexpr int kExitFailed = 1;

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

/// How a verb is run that is a sweep.
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

void addMethod(Command& verb, std::string& method, const char* about) {
  verb.option("--method", method, about).typeName("NAME");
}

void mustNotBeDivided(const Arguments& arguments, const std::string& because) {
  if (arguments.fromElsewhere || arguments.shard || !arguments.nats.url.empty())
    throw std::invalid_argument(because + ": runs whole and here; leave out --shard and --nats");
}
/// A method from outside is a program, which only who types its name may start.
void mustRunHere(const Arguments& arguments, const std::string& method) {
  if (!isOutside(method)) return;
  mustNotBeDivided(arguments, "--method " + method);
}

void addFailures(Command& app, Arguments& arguments) {
  Command verb = addVerb(
      app,
      {"failures", "Scripted motion that breaks methods of rendering: who holds where", "--seeds 20 --out results",
       "The scenes are S1 to S40; S13 to S15 are for methods that have surface properties, S16\n"
       "for those whose bodies yield, S18 to S20, S23 to S30 and S40 for ours, of these S26 to S28, S30\n"
       "and S40 for springs_between_bodies too. Ten seeds wander a million ticks in S20."},
      arguments.failures.out);
  FailuresOptions& options = arguments.failures;
  addSeed(verb, options.seed);
  addSeeds(verb, options.seeds);
  addMethod(verb, options.method, "Only this one, such as ours, ./FILE.so or 'python3 FILE.py'");
  verb.option("--scene", options.scene, "Only this one, such as S17").typeName("NAME");
  verb.option("--export", options.exportTo,
              "Write motion, forces and verdict of each run into a folder here, for haptic_eval judge")
      .typeName("DIR");
  addSweep(verb, arguments);
  setRun(verb, [&arguments, &options] {
    mustRunHere(arguments, options.method);
    if (!options.exportTo.empty()) mustNotBeDivided(arguments, "--export");
    arguments.sweep = makeFailuresSweep(options);
    arguments.sweepOut = &options.out;
  });
}

void addJudge(Command& app, Arguments& arguments) {
  Command verb = addVerb(app,
                         {"judge", "Verdicts on forces in files, ours or anybody's, without the method that gave them",
                          "runs --out results",
                          "  haptic_eval failures --scene S1 --export runs\n"
                          "Exit status 1: a verdict is not that of verdict.json, or fails where there is none."},
                         arguments.judge.out);
  verb.option("FOLDER", arguments.judge.folder, "Of one run, or of such folders").required().existingFolder();
  setRun(verb, [&arguments] { arguments.good = runJudge(arguments.judge); });
}

void addAccuracy(Command& app, Arguments& arguments) {
  Command verb =
      addVerb(app,
              {"accuracy", "Error against exact shapes, by method, mesh resolution and depth", "--finest 12288",
               "Beside the errors: peak to peak of the HIP that 1 N holds at rest on the mesh (limit_cycle_um), and\n"
               "the largest stiffness up to which a press or a tap comes to rest (K_crit_N_per_m; for all shapes\n"
               "that of the sphere of as many triangles), both of the default device in nobody's hand behind the\n"
               "server's stabiliser; ticks of the stroke that took the thread more than a period, 1 ms, of processor\n"
               "time (deadline_misses)."},
              arguments.accuracy.out);
  AccuracyOptions& options = arguments.accuracy;
  addSeed(verb, options.seed);
  addFinest(verb, options.finest);
  addMethod(verb, options.method, "Only this one, such as ours, ./FILE.so or 'python3 FILE.py'");
  setRun(verb, [&arguments, &options] { arguments.good = runAccuracy(options); });
}

void addCombinations(Command& app, Arguments& arguments) {
  Command verb = addVerb(
      app,
      {"combinations", "Surface features, two at a time: is what is felt that of both?", "--seeds 20 --out results",
       "The features are texture, shading, friction, softness, plastic, lattice, motion and several (surfaces that "
       "hold\n"
       "the IHIP together); a pair is called such as texture-softness. Each seed draws place, direction, speed, depth "
       "and\n"
       "parameters. With --ablate only the pairs run that it is about, and each has to fail.\n"
       "  haptic_eval combinations --pair shading-softness --seeds 5\n"
       "  haptic_eval combinations --ablate facets"},
      arguments.combinations.out);
  CombinationsOptions& options = arguments.combinations;
  addSeed(verb, options.seed);
  addSeeds(verb, options.seeds);
  verb.option("--pair", options.pair, "Only this one, such as texture-softness").typeName("NAME");
  verb.option("--ablate", options.ablate, "Switch one thing off: " + namesOf(ablationNames()))
      .oneOf(ablationNames())
      .typeName("NAME");
  setRun(verb, [&arguments, &options] { arguments.good = runCombinations(options); });
}

void addTextures(Command& app, Arguments& arguments) {
  Command verb = addVerb(
      app,
      {"textures", "Texture families, friction and force shading, measured, with a contact sheet", "--out results"},
      arguments.textures.out);
  addSeed(verb, arguments.textures.seed);
  setRun(verb, [&arguments] { arguments.good = runTextures(arguments.textures); });
}

void addChart(Command& app, Arguments& arguments) {
  Command verb = addVerb(
      app,
      {"chart", "Speed against accuracy of every method, as a picture and a table",
       "--kept tests/eval/worst/kept.json --out results",
       "A disc passes every failure scene; a diamond does so too, but rings on a mesh (limit_cycle_um of accuracy); a\n"
       "cross fails a scene."},
      arguments.chart.out);
  ChartOptions& options = arguments.chart;
  addSeed(verb, options.seed);
  addFinest(verb, options.finest);
  const Option kept = addFile(verb, "--kept", options.kept,
                              "Mark ours' worst tick: that of these scenes, worst.json of haptic_eval worst");
  addFile(verb, "--from", options.from, "Draw this chart.csv of an earlier run again, and measure nothing")
      .excludes(kept);
  addFile(verb, "--tools", arguments.toolBench,
          "Draw in its place what a tool's points cost: tool_tick and field_tick of haptic_bench --benchmark_out");
  setRun(verb, [&arguments, &options] {
    if (arguments.toolBench.empty()) {
      runChart(options);
    } else {
      drawFigure("tool_points", {{"bench", arguments.toolBench.string()}}, options.out / "tool_points");
      std::printf("written to %s: tool_points.png, tool_points.svg, tool_points.csv\n", options.out.c_str());
    }
  });
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

void addWalk(Command& app, Arguments& arguments) {
  Command verb = addVerb(app,
                         {"walk", "A random walk over generated and real shapes against a reference",
                          "--models /var/tmp/models --out results"},
                         arguments.out);
  WalkOptions& options = arguments.walk;
  addSeed(verb, options.seed);
  addCount(verb, "--ticks", options.ticks, "Of all scenes together");
  verb.option(
          "--models", options.models,
          "Folder that deploy/models/fetch_and_report filled; without it only the generated shapes are walked over, "
          "and models that are installed")
      .typeName("DIR")
      .existingFolder();
  verb.option("--scene", options.scene, "Only this one, as the table names it").typeName("NAME");
  verb.option("--method", options.method, "Ours, a baseline, as failures names them, or one from outside")
      .typeName("NAME")
      .showDefault()
      .excludes(verb.flag("--tool", arguments.walkTool, "Tools of 1,000 points in place of the HIP"));
  addSweep(verb, arguments);
  setRun(verb, [&arguments, &options] {
    mustRunHere(arguments, options.method);
    arguments.sweep =
        arguments.walkTool ? makeToolWalkSweep(options, arguments.out) : makeWalkSweep(options, arguments.out);
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

void addFuzzScenes(Command& verb, Arguments& arguments) {
  addSeed(verb, arguments.fuzz.seed);
  addCount(verb, "--scenes", arguments.fuzz.scenes, "How many, each drawn from its own seed, from --seed on");
}

void addMoving(Command& verb, Arguments& arguments) {
  verb.option(
          "--moving",
          [&arguments](const std::string& which) -> Result<void> {
            if (which != "both") arguments.fuzz.moving = which == "yes";
            return {};
          },
          "Bodies that move through each other, bodies at rest, or both by turns")
      .oneOf({"yes", "no", "both"})
      .typeName("WHICH");
}

void addFuzzContact(Command& fuzz, Arguments& arguments) {
  Command verb = addVerb(
      fuzz,
      {"contact", "The contact core among random bodies: is the IHIP ever inside one, or through a sheet?",
       "--scenes 40000 --out results",
       "A scene has 2,000 ticks. Bodies at rest and moving, at up to 1 and 4 m/s, in five kinds of worlds, come by\n"
       "turns: 40,000 scenes are 2,000 of each of the twenty, 80 million ticks. Ctrl-C ends it early: what was found "
       "is written."},
      arguments.out, "fuzz contact");
  addFuzzScenes(verb, arguments);
  addMoving(verb, arguments);
  verb.option("--speed", arguments.fuzz.speed_m_per_s, "Top speed of the HIP in m/s; 1 and 4 by turns when left out")
      .typeName("V")
      .check(moreThanZero());
  verb.option(
          "--world",
          [&arguments](const std::string& name) -> Result<void> {
            const auto* const world = std::ranges::find(kContactWorlds, name);
            arguments.fuzz.world = static_cast<ContactWorld>(world - kContactWorlds.begin());
            return {};
          },
          "Bodies of any kind, floors of flush boxes or cracked meshes, mirrored bodies, or thin plates; all by turns "
          "when "
          "left out")
      .oneOf({kContactWorlds.begin(), kContactWorlds.end()})
      .typeName("WORLD");
  addMethod(verb, arguments.fuzzMethod, "In place of the contact core: a baseline, ./FILE.so or 'python3 FILE.py'");
  setRun(verb, [&arguments] {
    arguments.good = arguments.fuzzMethod.empty()
                         ? runFuzzContact(arguments.fuzz, arguments.out)
                         : runFuzzContactOf(findMethod(arguments.fuzzMethod, methods()), arguments.fuzz, arguments.out);
  });
}

void addFuzzEdits(Command& fuzz, Arguments& arguments) {
  Command verb = addVerb(
      fuzz,
      {"edits", "Edits under a hand at rest: does the force step, is the IHIP inside of something, is the edit felt?",
       "--scenes 5000 --out results",
       "A scene has 12 edits. Rates, devices, the stabiliser, softness, textures, friction, shading and bodies that "
       "the\n"
       "step moves come at random. Ctrl-C ends it early: what was found is written."},
      arguments.out, "fuzz edits");
  addFuzzScenes(verb, arguments);
  setRun(verb, [&arguments] { arguments.good = runFuzzEdits(arguments.fuzz, arguments.out); });
}

void addFuzzReplay(Command& fuzz, Arguments& arguments) {
  Command verb = addVerb(fuzz,
                         {"replay", "A finding again: does it still fail?", "results/fuzz-inside-1095",
                          "fuzz contact and fuzz edits write such folders for what they find."},
                         arguments.out, "fuzz replay");
  verb.option("FOLDER", arguments.fuzzRecording, "A finding's folder").required().existingFolder();
  setRun(verb, [&arguments] { arguments.good = runFuzzReplay(arguments.fuzzRecording, arguments.out); });
}

void addFuzzReplayLive(Command& fuzz, Arguments& arguments) {
  Command verb =
      addVerb(fuzz,
              {"replay-live",
               "Recordings of a servo under random edits: does each replay bit for bit, and from every state in it?",
               "--scenes 2000 --out results",
               "A world has 20 s of virtual time at a random rate, with one hand or two, devices that fail, ticks that "
               "are missed,\n"
               "and edits of every property. Ctrl-C ends it early: what was found is written."},
              arguments.out, "fuzz replay-live");
  addFuzzScenes(verb, arguments);
  setRun(verb, [&arguments] { arguments.good = runFuzzReplayLive(arguments.fuzz, arguments.out); });
}

void addFuzzStream(Command& fuzz, Arguments& arguments) {
  Command verb = addVerb(
      fuzz,
      {"stream", "Bodies that are driven under a hand: does any pass it, and is the force what it should be?",
       "--scenes 500 --out results",
       "A world has 4,000 ticks; a third are of thin plates. Poses come in every tick, or every 8, 16 or 33 ticks,\n"
       "a little early or late. Ctrl-C ends it early: what was found is written."},
      arguments.out, "fuzz stream");
  addFuzzScenes(verb, arguments);
  verb.option("--speed", arguments.fuzz.speed_m_per_s, "Top speed of the HIP in m/s; 1 when left out")
      .typeName("V")
      .check(moreThanZero());
  setRun(verb, [&arguments] { arguments.good = runFuzzStream(arguments.fuzz, arguments.out); });
}

void addFuzzBodies(Command& fuzz, Arguments& arguments) {
  Command verb = addVerb(
      fuzz,
      {"bodies", "Bodies that meet: does what stands stand, and is any deep in another?", "--scenes 2000 --out results",
       "A world has 3 s: a stack that stands by statics, one put into or above itself, a heap, or bodies "
       "that float.\nCtrl-C ends it early: what was found is written."},
      arguments.out, "fuzz bodies");
  addFuzzScenes(verb, arguments);
  setRun(verb, [&arguments] { arguments.good = runFuzzBodies(arguments.fuzz, arguments.out); });
}

void addFuzzDeformedEdits(Command& fuzz, Arguments& arguments) {
  Command verb = addVerb(
      fuzz,
      {"deformed-edits", "Edits with degenerate numbers, and what deforms after them: is every force finite?",
       "--scenes 20000 --out results",
       "A world has ten edits, each felt for 30 ms. Made for builds with sanitizers.\nCtrl-C ends it early: what was "
       "found is written."},
      arguments.out, "fuzz deformed-edits");
  addFuzzScenes(verb, arguments);
  setRun(verb, [&arguments] { arguments.good = runFuzzDeformedEdits(arguments.fuzz, arguments.out); });
}

void addFuzzPrices(Command& fuzz, Arguments& arguments) {
  Command verb = addVerb(
      fuzz,
      {"prices", "Edits of any size: does each keep to the price that it has before it begins?",
       "--scenes 500 --out results",
       "A world has ten edits. Times are of the processor; a world that fails is run twice more.\nCtrl-C ends it "
       "early: what was found is written."},
      arguments.out, "fuzz prices");
  addFuzzScenes(verb, arguments);
  setRun(verb, [&arguments] { arguments.good = runFuzzPrices(arguments.fuzz, arguments.out); });
}

void addFuzzTools(Command& fuzz, Arguments& arguments) {
  Command verb =
      addVerb(fuzz,
              {"tools", "Random tools in the hand: is a vertex of one deeper than 10 um in a body?",
               "--scenes 1000 --out results",
               "A scene has 1,500 ticks after the way there. Ctrl-C ends it early: what was found is written."},
              arguments.out, "fuzz tools");
  addFuzzScenes(verb, arguments);
  addMoving(verb, arguments);
  verb.option("--speed", arguments.fuzz.speed_m_per_s, "Top speed of the tool in m/s; 1 when left out")
      .typeName("V")
      .check(moreThanZero());
  setRun(verb, [&arguments] { arguments.good = runFuzzTools(arguments.fuzz, arguments.out); });
}

void addFuzz(Command& app, Arguments& arguments) {
  Command verb = app.verb("fuzz", "Random scenes and motions against an independent judge");
  verb.needVerb();
  verb.footer(
      "Examples:\n  haptic_eval fuzz contact --scenes 40000 --out results\n"
      "  haptic_eval fuzz edits --scenes 5000 --out results\n"
      "  haptic_eval fuzz replay-live --scenes 2000 --out results\n"
      "  haptic_eval fuzz stream --scenes 500 --out results\n"
      "  haptic_eval fuzz bodies --scenes 2000 --out results\n"
      "  haptic_eval fuzz tools --scenes 1000 --out results\n"
      "  haptic_eval fuzz replay results/fuzz-inside-1095\n"
      "Exit status 1: something was found.");
  for (const auto add : {addFuzzContact, addFuzzEdits, addFuzzReplayLive, addFuzzStream, addFuzzBodies, addFuzzTools,
                         addFuzzDeformedEdits, addFuzzPrices, addFuzzReplay})
    add(verb, arguments);
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
                         addAdvise, addStability, addReplay, addFuzz, addWorst, addMerge, addWorker})
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
  try {
    return haptics::eval::run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "haptic_eval: %s\n", haptics::printable(error.what()).c_str());
    return haptics::eval::kExitFailed;
  }
}
