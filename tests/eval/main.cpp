#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <string>

#include "tests/eval/accuracy.h"
#include "tests/eval/chart.h"
#include "tests/eval/failures.h"
#include "tests/eval/table1/table1.h"
#include "tests/eval/walk/walk.h"

namespace {

constexpr int kExitFailed = 1;

struct Options {
  std::uint64_t seed = 1;
  std::string out = ".";
  int finest = haptics::eval::kFinestMesh;
  int chartFinest = haptics::eval::kChartFinestMesh;
  haptics::eval::WalkOptions walk;
};

CLI::App* addVerb(CLI::App& app, const std::string& name, const std::string& about, Options& options) {
  CLI::App* verb = app.add_subcommand(name, about);
  verb->add_option("--seed", options.seed, "Decides places, orientations, directions and speeds")
      ->type_name("S")
      ->capture_default_str();
  verb->add_option("--out", options.out, "Folder for " + name + ".json; made when missing")
      ->type_name("DIR")
      ->capture_default_str();
  return verb;
}

int run(int argc, char** argv) {
  CLI::App app{"Evaluates the haptic step and baselines in virtual time.", "haptic_eval"};
  app.require_subcommand(1);
  Options options;
  const CLI::App* failures =
      addVerb(app, "failures", "Scripted motion that breaks methods of rendering: who holds where", options);
  CLI::App* accuracy =
      addVerb(app, "accuracy", "Error against exact shapes, by method, mesh resolution and depth", options);
  accuracy->add_option("--finest", options.finest, "Leave out finer meshes; there are some up to 10 million")
      ->type_name("TRIANGLES")
      ->capture_default_str();
  CLI::App* chart = addVerb(app, "chart", "Speed against accuracy of every method, as a picture and a table", options);
  chart->add_option("--finest", options.chartFinest, "Leave out finer meshes; there are some up to 10 million")
      ->type_name("TRIANGLES")
      ->capture_default_str();
  haptics::eval::Table1Options table;
  bool asInPaper = false;
  CLI::App* table1 =
      app.add_subcommand("table1", "The paper's Table I: rates of the servo loop with the viewer connected");
  table1->add_flag("--paper", asInPaper, "Three times three minutes for each object");
  table1->add_option("--seconds", table.seconds, "For each object")
      ->check(CLI::PositiveNumber)
      ->excludes("--paper")
      ->capture_default_str();
  table1->add_option("--finest", table.finest, "Leave out objects of more triangles")
      ->type_name("TRIANGLES")
      ->capture_default_str();
  table1->add_option("--out", table.out, "Folder for table1.json; made when missing")->type_name("DIR");
  CLI::App* walk = addVerb(app, "walk", "A random walk over generated and real shapes against a reference", options);
  walk->add_option("--ticks", options.walk.ticks, "Of all scenes together")->type_name("N")->capture_default_str();
  walk->add_option("--models", options.walk.models, "Folder that deploy/models/fetch_and_report filled")
      ->type_name("DIR");
  walk->add_option("--method", options.walk.method, "Ours or a baseline, as failures names them")
      ->type_name("NAME")
      ->capture_default_str();
  app.footer(
      "Exit status 1: ours failed somewhere, or a baseline passed or failed where it is not expected to.\n\n"
      "Examples:\n"
      "  haptic_eval failures\n"
      "  haptic_eval failures --seed 7 --out results\n"
      "  haptic_eval accuracy --out results\n"
      "  haptic_eval chart --finest 12288\n"
      "  haptic_eval walk --models /var/tmp/models --out results");
  CLI11_PARSE(app, argc, argv);
  bool good = true;
  if (failures->parsed()) good = haptics::eval::runFailures(options.seed, options.out);
  if (accuracy->parsed()) good = haptics::eval::runAccuracy(options.seed, options.finest, options.out);
  if (chart->parsed()) haptics::eval::runChart(options.seed, options.chartFinest, options.out);
  if (asInPaper) {
    table.seconds = 180;
    table.runs = 3;
  }
  if (table1->parsed()) good = haptics::eval::runTable1(table);
  if (walk->parsed()) {
    options.walk.seed = options.seed;
    good = haptics::eval::runWalk(options.walk, options.out);
  }
  return good ? 0 : kExitFailed;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "haptic_eval: %s\n", error.what());
    return kExitFailed;
  }
}
