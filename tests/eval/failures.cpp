#include "tests/eval/failures.h"

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "tests/eval/adapters/outside_method.h"
#include "tests/eval/exchange/recorder.h"
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

/// "pass", "fail" or "either"; of a method from outside nothing is known.
std::string_view expectedOutcome(const Method& of, std::string_view scene) {
  if (of.outside) return "either";
  const std::string_view method = of.name;
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

/// All when no name is given.
std::vector<FailureScene> chosenScenes(std::string_view name) {
  std::vector<FailureScene> scenes;
  std::ranges::copy_if(kFailureScenes, std::back_inserter(scenes),
                       [&](const FailureScene& scene) { return name.empty() || scene.name == name; });
  if (scenes.empty())
    throw std::invalid_argument("--scene: there is no scene " + std::string(name) + ", but S1 to S40 and P1 to P9");
  return scenes;
}

/// Beside the measures, in a run's record.
constexpr std::string_view kAboutTheRun[] = {"method", "scene", "seed", "pass", "expected", "as_expected"};

Record runOf(const Method& method, const FailureScene& scene, std::uint64_t seed,
             const std::filesystem::path& exportTo) {
  const std::string_view expected = expectedOutcome(method, scene.name);
  const Record about{{"method", method.name}, {"scene", scene.name}, {"seed", seed}};
  const std::filesystem::path folder =
      exportTo / (std::string(method.name) + '-' + std::string(scene.name) + '-' + std::to_string(seed));
  Record record = about;
  std::optional<Recorder> recorder;
  runOrExplain(record, [&] {
    if (!method.isFor(scene.concern)) throw NotApplicable("about what the method has no part in");
    std::unique_ptr<Renderer> renderer = method.make();
    if (!exportTo.empty() && isExchanged(scene.concern)) recorder.emplace(std::move(renderer), folder);
    Random random = scene.random(seed);
    const SceneResult result = scene.run(recorder ? *recorder : *renderer, random);
    record.update(result.measures);
    record["pass"] = result.pass;
  });
  const bool asExpected = expected == "either" || record["pass"] == Record(expected == "pass");
  record.update({{"expected", expected}, {"as_expected", asExpected}});
  if (recorder && record["pass"].is_null()) {
    std::filesystem::remove_all(folder);
  } else if (recorder) {
    recorder->finish(about, record);
  }
  return record;
}

/// A part is a method with a seed, in all scenes that were chosen.
class FailuresSweep : public Sweep {
 public:
  explicit FailuresSweep(const FailuresOptions& options)
      : options_(options), chosen_(chosenMethods(options.method)), scenes_(chosenScenes(options.scene)) {}

  [[nodiscard]] std::size_t size() const override { return static_cast<std::size_t>(options_.seeds) * chosen_.size(); }

  [[nodiscard]] Record run(std::size_t part) override {
    Record runs = Record::array();
    const Method& method = methodOf(part);
    for (const FailureScene& scene : scenes_) {
      if (method.isFor(scene.concern) || method.outside)
        runs.push_back(runOf(method, scene, seedOf(part), options_.exportTo));
    }
    return runs;
  }

  void print(std::size_t part, const Record& runs) override {
    const Method& method = methodOf(part);
    if (options_.seeds == 1) {
      std::printf("%s: %s\n", method.name.data(), method.about.data());
    } else if (part % chosen_.size() == 0) {
      std::printf("seed %llu\n", static_cast<unsigned long long>(seedOf(part)));
    }
    for (const Record& run : runs) {
      const bool asExpected = run.at("as_expected");
      if (options_.seeds > 1 && asExpected) continue;
      Record measures = run;
      for (const std::string_view key : kAboutTheRun) measures.erase(std::string(key));
      const char* const verdict = run.at("pass").is_null() ? "n/a " : run.at("pass") ? "pass" : "FAIL";
      std::printf("  %-4s %s%s  %s\n", run.at("scene").get<std::string>().c_str(), verdict, asExpected ? " " : "!",
                  measuresText(measures).c_str());
    }
    std::fflush(stdout);
  }

  [[nodiscard]] bool finish(const std::vector<Record>& results) override {
    std::vector<Record> runs;
    for (const Record& part : results) runs.insert(runs.end(), part.begin(), part.end());
    printTable(runs);
    writeRecords(options_.out, "failures", runs);
    const auto surprises = std::ranges::count_if(runs, [](const Record& run) { return !run.at("as_expected"); });
    const auto count = [&](const Record& pass) {
      return std::ranges::count(runs, pass, [](const Record& r) { return r.at("pass"); });
    };
    std::printf("%zu runs, %td not as expected", runs.size(), surprises);
    if (const auto none = count(nullptr); none > 0) {
      const auto faults = std::ranges::count_if(runs, [](const Record& run) { return run.contains("fault"); });
      std::printf("; %td pass, %td fail, %td of them by a fault of their own; %td not applicable", count(true),
                  count(false), faults, none);
    }
    std::printf("\n");
    return surprises == 0;
  }

 private:
  [[nodiscard]] const Method& methodOf(std::size_t part) const { return chosen_[part % chosen_.size()]; }
  [[nodiscard]] std::uint64_t seedOf(std::size_t part) const { return options_.seed + part / chosen_.size(); }

  /// Failures of each method in each scene.
  void printTable(const std::vector<Record>& runs) const {
    std::map<std::pair<std::string, std::string>, int> failures;
    std::set<std::pair<std::string, std::string>> notApplicable;
    for (const Record& run : runs) {
      const std::pair<std::string, std::string> key{run.at("method"), run.at("scene")};
      if (run.at("pass").is_null()) {
        notApplicable.insert(key);
      } else if (!run.at("pass")) {
        ++failures[key];
      }
    }
    std::printf("%-35s", "failed runs");
    for (const FailureScene& scene : scenes_) std::printf("%5s", scene.name.data());
    for (const Method& method : chosen_) {
      std::printf("\n%-35s", method.name.data());
      for (const FailureScene& scene : scenes_) {
        const std::pair key{std::string(method.name), std::string(scene.name)};
        const auto failed = failures.find(key);
        const bool notRun = !method.isFor(scene.concern) || notApplicable.contains(key);
        std::printf("%5s", notRun ? "" : failed == failures.end() ? "." : std::to_string(failed->second).c_str());
      }
    }
    std::printf("\n");
  }

  FailuresOptions options_;
  std::vector<Method> chosen_;
  std::vector<FailureScene> scenes_;
};

}  // namespace

std::unique_ptr<Sweep> makeFailuresSweep(const FailuresOptions& options) {
  return std::make_unique<FailuresSweep>(options);
}

}  // namespace haptics::eval
