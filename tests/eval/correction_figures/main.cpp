#include <cstdint>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>

#include "common/command_line/command_line.h"
#include "common/text/printable.h"
#include "tests/eval/correction_figures/correction_figures.h"

int main(int argc, char** argv) {
  haptics::CommandLine app{"Draws what each correction of the contact core is for, from the motion of a failure scene.",
                           "contact_figures"};
  std::uint64_t seed = 1;
  std::string method;
  std::filesystem::path folder;
  app.option("DIR", folder, "Where to put the pictures").required();
  app.option("--method", method, "Only this one, such as ours_without_guard").typeName("NAME");
  app.option("--seed", seed, "Of the scenes").showDefault();
  if (const auto code = app.parse(argc, argv)) return *code;
  try {
    haptics::eval::drawCorrections(seed, method, folder);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "contact_figures: %s\n", haptics::printable(error.what()).c_str());
    return 1;
  }
  return 0;
}
