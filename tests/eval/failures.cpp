#include "tests/eval/failures.h"

#include <algorithm>
#include <cstdio>
#include <stdexcept>

#include "tests/eval/expected_failures.h"
#include "tests/eval/methods.h"
#include "tests/eval/report.h"
#include "tests/eval/scenes/scenes.h"

namespace haptics::eval {
namespace {

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

}  // namespace

bool runFailures(std::uint64_t seed, const std::filesystem::path& out) {
  std::vector<Record> records;
  int surprises = 0;
  for (const Method& method : methods()) {
    std::printf("%s: %s\n", method.name.data(), method.about.data());
    std::uint64_t number = 0;
    for (const FailureScene& scene : kFailureScenes) {
      Random random(seed * kFailureScenes.size() + number++);  // every method meets the same scene
      const SceneResult result = scene.run(*method.make(), random);
      const std::string_view expected = expectedOutcome(method.name, scene.name);
      const bool asExpected = expected == "either" || result.pass == (expected == "pass");
      surprises += asExpected ? 0 : 1;
      std::printf("  %-4s %s%s  %s\n", scene.name.data(), result.pass ? "pass" : "FAIL", asExpected ? " " : "!",
                  measuresText(result.measures).c_str());
      Record record{{"method", method.name}, {"scene", scene.name}, {"seed", seed}};
      record.update(result.measures);
      record.update({{"pass", result.pass}, {"expected", expected}, {"as_expected", asExpected}});
      records.push_back(std::move(record));
    }
  }
  writeRecords(out, "failures", records);
  std::printf("%zu runs, %d not as expected\n", records.size(), surprises);
  return surprises == 0;
}

}  // namespace haptics::eval
