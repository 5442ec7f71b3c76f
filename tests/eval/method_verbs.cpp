// Verbs that a method can be given to: any renderer, ours or from outside.

#include <cstdio>
#include <stdexcept>

#include "tests/eval/adapters/outside_method.h"
#include "tests/eval/figure/figure.h"
#include "tests/eval/verb_options.h"
#include "tests/eval/verbs.h"
#include "tests/eval/walk/tool_walk.h"

namespace haptics::eval {
namespace {

void mustNotBeDivided(const Arguments& arguments, const std::string& because) {
  if (arguments.fromElsewhere || arguments.shard || !arguments.nats.url.empty())
    throw std::invalid_argument(because + ": runs whole and here; leave out --shard and --nats");
}
/// A method from outside is a program, which only who types its name may start.
void mustRunHere(const Arguments& arguments, const std::string& method) {
  if (!isOutside(method)) return;
  mustNotBeDivided(arguments, "--method " + method);
}

}  // namespace

void addMethod(Command& verb, std::string& method, const char* about) {
  verb.option("--method", method, about).typeName("NAME");
}

void addFailures(Command& app, Arguments& arguments) {
  Command verb = addVerb(
      app,
      {"failures", "Scripted motion that breaks methods of rendering: who holds where", "--seeds 20 --out results",
       "The scenes are S1 to S40, and P1 to P9, which users of other programs reported; S13 to S15 are for\n"
       "methods that have surface properties, S16 for those whose bodies yield, S18 to S20, S23 to S30, S40\n"
       "and P7 to P9 for ours, of these S26 to S28, S30, S40 and P7 to P9 for springs_between_bodies too.\n"
       "Ten seeds wander a million ticks in S20."},
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
  const Option method =
      verb.option("--method", options.method,
                  "In place of ours: what it is not handed is not applicable, and its friction is the same everywhere")
          .typeName("NAME");
  verb.option("--ablate", options.ablate, "Switch one thing off: " + namesOf(ablationNames()))
      .oneOf(ablationNames())
      .typeName("NAME")
      .excludes(method);
  setRun(verb, [&arguments, &options] { arguments.good = runCombinations(options); });
}

void addChart(Command& app, Arguments& arguments) {
  Command verb = addVerb(
      app,
      {"chart", "Speed against accuracy of every method, as a picture and a table",
       "--kept tests/eval/worst/kept.json --out results",
       "A disc passes every failure scene; a diamond does so too, but rings on a mesh (limit_cycle_um of accuracy); a\n"
       "cross fails a scene. Of a method from outside the time is its own, without the way to its process and\n"
       "back, caches hot; its instructions are not counted.\n"
       "  haptic_eval chart --from results/chart.csv --method ./penalty.so --finest 3072 --out results"},
      arguments.chart.out);
  ChartOptions& options = arguments.chart;
  addSeed(verb, options.seed);
  addFinest(verb, options.finest);
  addMethod(verb, options.method,
            "Only this one, such as ours, ./FILE.so or 'python3 FILE.py'; with --from beside what is drawn again");
  const Option kept = addFile(verb, "--kept", options.kept,
                              "Mark ours' worst tick: that of these scenes, worst.json of haptic_eval worst");
  addFile(verb, "--from", options.from, "Draw this chart.csv of an earlier run again, and measure --method alone")
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

}  // namespace haptics::eval
