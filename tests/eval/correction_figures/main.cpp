#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>

#include "tests/eval/correction_figures/correction_figures.h"

int main(int argc, char** argv) {
  CLI::App app{"Draws what each correction of the contact core is for, from the motion of a failure scene.",
               "contact_figures"};
  std::uint64_t seed = 1;
  std::string method;
  std::filesystem::path folder;
  app.add_option("DIR", folder, "Where to put the pictures")->required();
  app.add_option("--method", method, "Only this one, such as ours_without_guard")->type_name("NAME");
  app.add_option("--seed", seed, "Of the scenes")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  try {
    haptics::eval::drawCorrections(seed, method, folder);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "contact_figures: %s\n", error.what());
    return 1;
  }
  return 0;
}
