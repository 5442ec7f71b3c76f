#include "tests/eval/verb_options.h"

#include <cmath>
#include <cstdlib>

#include "tests/eval/report.h"

namespace haptics::eval {

TextTaker wholeNumber(double least) {
  return [least](const std::string& text) -> Result<void> {
    const bool digits = !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
    if (digits && std::stod(text) >= least) return {};
    return refused("", text + ": give a whole number, at least " + std::to_string(std::lround(least)));
  };
}

TextTaker moreThanZero() {
  return [](const std::string& text) -> Result<void> {
    char* end = nullptr;
    const auto value = static_cast<double>(std::strtold(text.c_str(), &end));
    if (end == text.c_str() + text.size() && value > 0 && std::isfinite(value)) return {};
    return refused("", text + ": give a number more than 0");
  };
}

std::string namesOf(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list;
}

Command addVerb(Command& app, const Verb& of, std::filesystem::path& out, const std::string& calledAs) {
  const std::string name = calledAs.empty() ? of.name : calledAs;
  Command verb = app.verb(of.name, of.about);
  verb.whenRead([&out] { makeFolder(out); });
  verb.option("--out", out,
              "Folder for " + name.substr(0, name.find(' ')) + ".json and what else it writes; made when missing")
      .typeName("DIR")
      .showDefault();
  verb.footer("Example:\n  haptic_eval " + name + ' ' + of.example + '\n' + of.notes);
  return verb;
}

void setRun(Command& verb, const std::function<void()>& run) {
  verb.then([run]() -> Result<void> {
    run();
    return {};
  });
}

void addSeed(Command& verb, std::uint64_t& seed) {
  verb.option("--seed", seed, "Decides places, orientations, directions and speeds")
      .typeName("S")
      .check(wholeNumber(0))
      .showDefault();
}

void addFinest(Command& verb, int& finest, const char* about) {
  constexpr int kCoarsestMesh = 12;  // triangles
  verb.option("--finest", finest, about).typeName("TRIANGLES").check(wholeNumber(kCoarsestMesh)).showDefault();
}

Option addFile(Command& verb, const char* name, std::filesystem::path& file, const char* about) {
  return verb.option(name, file, about).typeName("FILE").existingFile();
}

}  // namespace haptics::eval
