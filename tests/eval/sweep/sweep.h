#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/hash/content_hash.h"
#include "tests/eval/report.h"

namespace haptics::eval {

/// The work of a verb, in parts that know nothing of one another: each comes to the same on every machine of one build.
class Sweep {
 public:
  Sweep() = default;
  virtual ~Sweep() = default;
  Sweep(const Sweep&) = delete;
  Sweep& operator=(const Sweep&) = delete;

  [[nodiscard]] virtual std::size_t size() const = 0;
  /// What one part comes to, from its number alone. Throws what keeps it from being run.
  [[nodiscard]] virtual Record run(std::size_t part) = 0;
  /// Prints it; parts come in their order.
  virtual void print(std::size_t part, const Record& result) = 0;
  /// Prints and writes what all came to.
  /// @return Whether everything is as it should be.
  [[nodiscard]] virtual bool finish(const std::vector<Record>& results) = 0;
};

/// Every count-th part from `index` on; counted from 0.
struct Shard {
  std::size_t index = 0;
  std::size_t count = 1;

  /// Of text such as 2/8, counted from 1; nothing where it is none.
  [[nodiscard]] static std::optional<Shard> fromText(const std::string& text);
};

/// What makes a sweep again elsewhere: the verb and its options, without where its results go and who runs it.
using SweepArguments = std::vector<std::string>;
/// Throws std::invalid_argument where they are those of no sweep.
using SweepMaker = std::function<std::unique_ptr<Sweep>(const SweepArguments&)>;

/// Of a command line, without the program's name: leaves out --out, --shard, --nats and --nats-credentials.
[[nodiscard]] SweepArguments sweepArguments(int argc, const char* const* argv);

/// SHA-256 of the running program, as 64 digits: only one build's parts may stand in one result.
[[nodiscard]] std::string buildHash();
/// What only who has the running program can compute of a text: shows that one build's program has written it.
class ProgramSeal {
 public:
  ProgramSeal();
  /// 64 digits. `place` says what the text is for, so that it is taken for nothing else.
  [[nodiscard]] std::string of(std::string_view place, std::string_view text) const;

 private:
  ContentHash key_;
};

/// All parts, here.
[[nodiscard]] bool runSweep(Sweep& sweep);
/// Runs a shard, and writes DIR/<verb>.shard-I-of-N.json for mergeShards().
void runShard(Sweep& sweep, const Shard& shard, const SweepArguments& arguments, const std::filesystem::path& out);
/// Goes on with all shards of a sweep as if its parts had been run here.
/// @return As Sweep::finish(). Throws std::runtime_error naming the file that is unreadable, of another sweep or build, or
/// there twice, and the shards that are missing.
[[nodiscard]] bool mergeShards(const std::vector<std::filesystem::path>& files, const SweepMaker& makeSweep);

}  // namespace haptics::eval
