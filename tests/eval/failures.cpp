#include "tests/eval/failures.h"

#include <algorithm>
#include <cstdio>
#include <map>
#include <stdexcept>

#include "tests/eval/expected_failures.h"
#include "tests/eval/methods.h"
#include "tests/eval/report.h"
#include "tests/eval/scenes/scenes.h"

namespace haptics::eval {
namespace {

constexpr bool isScene(std::string_view name) {
  return std::ranges::any_of(kFailureScenes, [&](const FailureScene& scene) { return scene.name == name; });
}
/// Each name is that of a scene, and is followed by a space.
constexpr bool areScenes(std::string_view names) {
  while (!names.empty()) {
    const std::size_t end = names.find(' ');
    if (end == std::string_view::npos || !isScene(names.substr(0, end))) return false;
    names.remove_prefix(end + 1);
  }
  return true;
}
static_assert(std::ranges::all_of(kExpectedFailures,
                                  [](const Expectation& e) { return areScenes(e.fails) && areScenes(e.either); }));

/// "pass", "fail" or "either".
std::string_view expectedOutcome(std::string_view method, std::string_view scene) {
  const auto entry = std::find_if(kExpectedFailures.begin(), kExpectedFailures.end(),
                                  [&](const Expectation& e) { return e.method == method; });
  if (entry == kExpectedFailures.end()) throw std::logic_error("nothing is expected of " + std::string(method));
  const auto names = [&](std::string_view list) {
    return (' ' + std::string(list)).find(' ' + std::string(scene) + ' ') != std::string::npos;
  };
  return names(entry->fails) ? "fail" : names(entry->either) ? "either" : "pass";
}

/// All when no name is given.
std::vector<Method> chosenMethods(std::string_view name) {
  std::vector<Method> all(methods().begin(), methods().end());
  for (const auto& more : {ablatedMethods(), singleConcernMethods()}) all.insert(all.end(), more.begin(), more.end());
  if (name.empty()) return all;
  return {findMethod(name, all)};
}

/// All runs, and how they came out.
class Runs {
 public:
  explicit Runs(bool printMeasures) : printMeasures_(printMeasures) {}

  void run(const Method& method, const FailureScene& scene, std::uint64_t seed) {
    Random random = scene.random(seed);
    const SceneResult result = scene.run(*method.make(), random);
    const std::string_view expected = expectedOutcome(method.name, scene.name);
    const bool asExpected = expected == "either" || result.pass == (expected == "pass");
    surprises_ += asExpected ? 0 : 1;
    if (!result.pass) ++failures_[{method.name, scene.name}];
    if (printMeasures_ || !asExpected) {
      std::printf("  %-4s %s%s  %s\n", scene.name.data(), result.pass ? "pass" : "FAIL", asExpected ? " " : "!",
                  measuresText(result.measures).c_str());
    }
    Record record{{"method", method.name}, {"scene", scene.name}, {"seed", seed}};
    record.update(result.measures);
    record.update({{"pass", result.pass}, {"expected", expected}, {"as_expected", asExpected}});
    records_.push_back(std::move(record));
  }

  /// Failures of each method in each scene.
  void printTable(std::span<const Method> chosen) const {
    std::printf("%-35s", "failed runs");
    for (const FailureScene& scene : kFailureScenes) std::printf("%5s", scene.name.data());
    for (const Method& method : chosen) {
      std::printf("\n%-35s", method.name.data());
      for (const FailureScene& scene : kFailureScenes) {
        const auto failed = failures_.find({method.name, scene.name});
        const bool notRun = !method.isFor(scene.concern);
        std::printf("%5s", notRun ? "" : failed == failures_.end() ? "." : std::to_string(failed->second).c_str());
      }
    }
    std::printf("\n");
  }
  [[nodiscard]] const std::vector<Record>& records() const { return records_; }
  [[nodiscard]] int surprises() const { return surprises_; }

 private:
  bool printMeasures_;
  std::vector<Record> records_;
  std::map<std::pair<std::string_view, std::string_view>, int> failures_;
  int surprises_ = 0;
};

}  // namespace

bool runFailures(const FailuresOptions& options) {
  const std::vector<Method> chosen = chosenMethods(options.method);
  Runs runs(options.seeds == 1);
  for (int i = 0; i < options.seeds; ++i) {
    const std::uint64_t seed = options.seed + static_cast<std::uint64_t>(i);
    if (options.seeds > 1) std::printf("seed %llu\n", static_cast<unsigned long long>(seed));
    for (const Method& method : chosen) {
      if (options.seeds == 1) std::printf("%s: %s\n", method.name.data(), method.about.data());
      for (const FailureScene& scene : kFailureScenes) {
        if (method.isFor(scene.concern)) runs.run(method, scene, seed);
      }
      std::fflush(stdout);
    }
  }
  runs.printTable(chosen);
  writeRecords(options.out, "failures", runs.records());
  std::printf("%zu runs, %d not as expected\n", runs.records().size(), runs.surprises());
  return runs.surprises() == 0;
}

}  // namespace haptics::eval
