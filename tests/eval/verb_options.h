#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "common/command_line/command_line.h"

namespace haptics::eval {

[[nodiscard]] TextTaker wholeNumber(double least);
[[nodiscard]] TextTaker moreThanZero();

/// With commas between them.
[[nodiscard]] std::string namesOf(const std::vector<std::string>& names);

struct Verb {
  const char* name;
  const char* about;    ///< One line.
  const char* example;  ///< Its arguments.
  const char* notes = "";
};

/// With --out. @param calledAs  With the verb that it is below, where it is below one.
Command addVerb(Command& app, const Verb& of, std::filesystem::path& out, const std::string& calledAs = "");

/// Runs where the verb is given and nothing was wrong.
void setRun(Command& verb, const std::function<void()>& run);

void addSeed(Command& verb, std::uint64_t& seed);
void addFinest(Command& verb, int& finest,
               const char* about = "Leave out meshes of more triangles; there are some up to 10 million");
Option addFile(Command& verb, const char* name, std::filesystem::path& file, const char* about);

template <class Number>
Option addCount(Command& verb, const char* name, Number& count, const char* about) {
  return verb.option(name, count, about).typeName("N").check(wholeNumber(1)).showDefault();
}

inline void addSeeds(Command& verb, int& seeds) { addCount(verb, "--seeds", seeds, "How many seeds, from --seed on"); }

}  // namespace haptics::eval
