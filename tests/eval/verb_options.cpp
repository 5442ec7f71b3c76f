#include "tests/eval/verb_options.h"

#include <cmath>

#include "tests/eval/report.h"

namespace haptics::eval {

CLI::Validator wholeNumber(double least) {
  const auto check = [least](const std::string& text) {
    const bool digits = !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
    if (digits && std::stod(text) >= least) return std::string();
    return text + ": give a whole number, at least " + std::to_string(std::lround(least));
  };
  return CLI::Validator(check, "");
}

CLI::Validator moreThanZero() {
  const auto check = [](const std::string& text) {
    double value = 0;
    if (CLI::detail::lexical_cast(text, value) && value > 0 && std::isfinite(value)) return std::string();
    return text + ": give a number more than 0";
  };
  return CLI::Validator(check, "");
}

std::string namesOf(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list;
}

CLI::App* addVerb(CLI::App& app, const Verb& of, std::filesystem::path& out, const std::string& calledAs) {
  const std::string name = calledAs.empty() ? of.name : calledAs;
  CLI::App* verb = app.add_subcommand(of.name, of.about);
  verb->parse_complete_callback([&out] { makeFolder(out); });
  verb->add_option("--out", out,
                   "Folder for " + name.substr(0, name.find(' ')) + ".json and what else it writes; made when missing")
      ->type_name("DIR")
      ->capture_default_str();
  verb->footer("Example:\n  haptic_eval " + name + ' ' + of.example + '\n' + of.notes);
  return verb;
}

void addSeed(CLI::App* verb, std::uint64_t& seed) {
  verb->add_option("--seed", seed, "Decides places, orientations, directions and speeds")
      ->type_name("S")
      ->check(wholeNumber(0))
      ->capture_default_str();
}

void addFinest(CLI::App* verb, int& finest, const char* about) {
  constexpr int kCoarsestMesh = 12;  // triangles
  verb->add_option("--finest", finest, about)
      ->type_name("TRIANGLES")
      ->check(wholeNumber(kCoarsestMesh))
      ->capture_default_str();
}

CLI::Option* addFile(CLI::App* verb, const char* name, std::filesystem::path& file, const char* about) {
  return verb->add_option(name, file, about)->type_name("FILE")->check(CLI::ExistingFile);
}

}  // namespace haptics::eval
