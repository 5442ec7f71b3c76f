#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <string>

#include "tests/eval/failures.h"

namespace {

constexpr int kExitFailed = 1;

struct Options {
  std::uint64_t seed = 1;
  std::string out = ".";
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
  app.footer(
      "Exit status 1: ours failed somewhere, or a baseline passed or failed where it is not expected to.\n\n"
      "Examples:\n"
      "  haptic_eval failures\n"
      "  haptic_eval failures --seed 7 --out results");
  CLI11_PARSE(app, argc, argv);
  const bool good = !failures->parsed() || haptics::eval::runFailures(options.seed, options.out);
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
