#include "tests/eval/sweep/sweep.h"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <span>
#include <stdexcept>

#include "common/hash/content_hash.h"
#include "tests/eval/sweep/sweep_progress.h"

namespace haptics::eval {
namespace {

constexpr std::size_t kMaxShards = 100'000;

[[nodiscard]] std::string textOf(const SweepArguments& arguments) {
  std::string text;
  for (const std::string& argument : arguments) text += (text.empty() ? "" : " ") + argument;
  return text;
}

/// What a shard's file holds.
struct ShardResults {
  SweepArguments arguments;
  std::string build;
  Shard shard;
  std::vector<Record> results;
};

[[nodiscard]] ShardResults readShard(const std::filesystem::path& file) {
  std::ifstream text(file);
  if (!text) throw std::runtime_error(file.string() + ": cannot be read");
  try {
    const Record read = Record::parse(text);
    const auto number = read.at("shard").get<std::size_t>(), count = read.at("shards").get<std::size_t>();
    if (number < 1 || number > count || count > kMaxShards)
      throw std::runtime_error(file.string() + ": says that it is shard " + std::to_string(number) + " of " +
                               std::to_string(count));
    return {read.at("arguments"), read.at("build"), {number - 1, count}, read.at("results").get<std::vector<Record>>()};
  } catch (const Record::exception& error) {
    throw std::runtime_error(file.string() + ": is no shard of a sweep, as --shard writes them: " + error.what());
  }
}

[[nodiscard]] std::string runningProgram() {
  std::ifstream program("/proc/self/exe", std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(program), {}};
  if (bytes.empty()) throw std::runtime_error("/proc/self/exe: cannot be read, to tell which build this is");
  return bytes;
}

[[nodiscard]] std::size_t partsOf(const Shard& shard, std::size_t size) {
  return size <= shard.index ? 0 : (size - shard.index - 1) / shard.count + 1;
}

}  // namespace

std::optional<Shard> Shard::fromText(const std::string& text) {
  std::size_t index = 0, count = 0;
  const char* end = text.data() + text.size();
  const auto [slash, bad] = std::from_chars(text.data(), end, index);
  if (bad != std::errc() || slash == end || *slash != '/') return std::nullopt;
  const auto [last, worse] = std::from_chars(slash + 1, end, count);
  if (worse != std::errc() || last != end || index < 1 || index > count || count > kMaxShards) return std::nullopt;
  return Shard{index - 1, count};
}

SweepArguments sweepArguments(int argc, const char* const* argv) {
  constexpr std::string_view kLeftOut[] = {"--out", "--shard", "--nats", "--nats-credentials"};
  SweepArguments kept;
  const auto given = std::span(argv, static_cast<std::size_t>(argc));
  for (std::size_t i = 1; i < given.size(); ++i) {
    const std::string_view argument = given[i];
    const std::string_view name = argument.substr(0, argument.find('='));
    if (std::ranges::find(kLeftOut, name) == std::end(kLeftOut)) {
      kept.emplace_back(argument);
    } else if (name == argument) {
      ++i;  // its value
    }
  }
  return kept;
}

std::string buildHash() {
  const std::string bytes = runningProgram();
  return Hasher().add(std::as_bytes(std::span(bytes))).finish().hex();
}

// Not a hash that leaves the process.
ProgramSeal::ProgramSeal() : key_(Hasher().add("seal").add(runningProgram()).finish()) {}

std::string ProgramSeal::of(std::string_view place, std::string_view text) const {
  return Hasher().add(key_).add(place).add(text).finish().hex();
}

bool runSweep(Sweep& sweep) {
  std::vector<Record> results;
  SweepProgress progress(sweep.size());
  for (std::size_t part = 0; part < sweep.size(); ++part) {
    results.push_back(sweep.run(part));
    progress.clear();
    sweep.print(part, results.back());
    progress.show(results.size());
  }
  return sweep.finish(results);
}

void runShard(Sweep& sweep, const Shard& shard, const SweepArguments& arguments, const std::filesystem::path& out) {
  Record results = Record::array();
  SweepProgress progress(partsOf(shard, sweep.size()));
  for (std::size_t part = shard.index; part < sweep.size(); part += shard.count) {
    results.push_back(sweep.run(part));
    progress.show(results.size());
  }
  const std::string name =
      arguments.front() + ".shard-" + std::to_string(shard.index + 1) + "-of-" + std::to_string(shard.count);
  writeRecord(out, name,
              {{"arguments", arguments},
               {"build", buildHash()},
               {"shard", shard.index + 1},
               {"shards", shard.count},
               {"results", std::move(results)}});
  std::printf("%zu of %zu parts, written to %s\n", partsOf(shard, sweep.size()), sweep.size(),
              (out / (name + ".json")).c_str());
}

bool mergeShards(const std::vector<std::filesystem::path>& files, const SweepMaker& makeSweep) {
  const ShardResults first = readShard(files.front());
  if (first.build != buildHash()) {
    throw std::runtime_error(files.front().string() + ": is of build " + first.build + ", this program is build " +
                             buildHash() + "; merge with the program that ran the shards");
  }
  const std::unique_ptr<Sweep> sweep = makeSweep(first.arguments);
  std::vector<Record> results(sweep->size());
  std::vector<bool> isThere(first.shard.count, false);
  for (const std::filesystem::path& file : files) {
    const ShardResults read = readShard(file);
    const auto refuse = [&](const std::string& why) { throw std::runtime_error(file.string() + ": " + why); };
    if (read.build != first.build) refuse("is of another build than " + files.front().string());
    if (read.arguments != first.arguments)
      refuse("is of the sweep \"" + textOf(read.arguments) + "\", " + files.front().string() + " of \"" +
             textOf(first.arguments) + '"');
    if (read.shard.count != first.shard.count)
      refuse("is one of " + std::to_string(read.shard.count) + " shards, " + files.front().string() + " one of " +
             std::to_string(first.shard.count));
    if (isThere[read.shard.index]) refuse("shard " + std::to_string(read.shard.index + 1) + " is there twice");
    if (read.results.size() != partsOf(read.shard, sweep->size())) refuse("holds not all parts of its shard");
    isThere[read.shard.index] = true;
    for (std::size_t i = 0; i < read.results.size(); ++i)
      results[read.shard.index + i * read.shard.count] = read.results[i];
  }
  std::string missing;
  for (std::size_t i = 0; i < isThere.size(); ++i)
    if (!isThere[i]) missing += (missing.empty() ? "" : ", ") + std::to_string(i + 1);
  if (!missing.empty())
    throw std::runtime_error("of " + std::to_string(isThere.size()) + " shards these are missing: " + missing);
  for (std::size_t part = 0; part < results.size(); ++part) sweep->print(part, results[part]);
  return sweep->finish(results);
}

}  // namespace haptics::eval
