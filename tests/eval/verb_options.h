#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace haptics::eval {

[[nodiscard]] CLI::Validator wholeNumber(double least);
[[nodiscard]] CLI::Validator moreThanZero();

/// With commas between them.
[[nodiscard]] std::string namesOf(const std::vector<std::string>& names);

struct Verb {
  const char* name;
  const char* about;    ///< One line.
  const char* example;  ///< Its arguments.
  const char* notes = "";
};

/// With --out. @param calledAs  With the verb that it is below, where it is below one.
CLI::App* addVerb(CLI::App& app, const Verb& of, std::filesystem::path& out, const std::string& calledAs = "");

void addSeed(CLI::App* verb, std::uint64_t& seed);
void addFinest(CLI::App* verb, int& finest,
               const char* about = "Leave out meshes of more triangles; there are some up to 10 million");
CLI::Option* addFile(CLI::App* verb, const char* name, std::filesystem::path& file, const char* about);

template <class Number>
void addCount(CLI::App* verb, const char* name, Number& count, const char* about) {
  verb->add_option(name, count, about)->type_name("N")->check(wholeNumber(1))->capture_default_str();
}

inline void addSeeds(CLI::App* verb, int& seeds) { addCount(verb, "--seeds", seeds, "How many seeds, from --seed on"); }

}  // namespace haptics::eval
