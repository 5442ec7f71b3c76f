#include "haptic_server/doctor/doctor.h"

#include <algorithm>
#include <cstdio>
#include <iostream>
#include <iterator>
#include <optional>

#include "common/command_line/command_line.h"
#include "common/json/json.h"
#include "haptic_server/doctor/device_facts.h"
#include "haptic_server/doctor/findings.h"

namespace haptics {
namespace {

struct DoctorOptions {
  double seconds = 10;
  double rate_Hz = 1000;
  std::optional<int> cpu;
  bool json = false;
};

[[nodiscard]] const char* mark(Verdict verdict) {
  return verdict == Verdict::kGood ? "good" : verdict == Verdict::kWorse ? "could be better" : "missing";
}

void print(const Finding& finding) {
  constexpr const char* kMarks[] = {"  ok", "   -", "  !!"};
  std::printf("%s  %-20s %s\n", kMarks[static_cast<int>(finding.verdict)], finding.what.c_str(), finding.found.c_str());
  if (!finding.advice.empty()) std::printf("      %-20s %s\n", "", finding.advice.c_str());
}

/// "10 to 20 us", with a bar that grows by the powers of ten.
void print(const WakeUps& wakeUps) {
  std::uint64_t from_ns = 0;
  const auto last = std::ranges::find_if(wakeUps.bins.rbegin(), wakeUps.bins.rend(), [](const WakeUps::Bin& bin) {
                      return bin.count > 0;
                    }).base();
  for (auto bin = wakeUps.bins.begin(); bin != last; ++bin) {
    const auto us = [](std::uint64_t ns) { return static_cast<unsigned long long>(ns / 1000); };
    int bar = 0;
    for (std::uint64_t left = bin->count; left > 0; left /= 2) ++bar;
    if (bin + 1 == wakeUps.bins.end()) {
      std::printf("      %6llu us and more   ", us(from_ns));
    } else {
      std::printf("      %6llu to %6llu us  ", us(from_ns), us(bin->below_ns));
    }
    std::printf("%8llu  %s\n", static_cast<unsigned long long>(bin->count),
                std::string(static_cast<std::size_t>(bar), '#').c_str());
    from_ns = bin->below_ns;
  }
  std::printf(
      "      the latest: %.0f us; a further # is twice as many; measured with%s real-time priority and%s locked "
      "memory\n",
      static_cast<double>(wakeUps.max_ns) * 1e-3, wakeUps.realtime.fifo ? "" : " no",
      wakeUps.realtime.memoryLocked ? "" : " no");
}

[[nodiscard]] Json toJson(const std::vector<Finding>& findings, const WakeUps& wakeUps, const DoctorOptions& options) {
  Json list = Json::array();
  for (const Finding& finding : findings) {
    list.push({{"what", finding.what},
               {"found", finding.found},
               {"verdict", mark(finding.verdict)},
               {"advice", finding.advice}});
  }
  Json bins = Json::array();
  for (const WakeUps::Bin& bin : wakeUps.bins) bins.push({{"below_ns", bin.below_ns}, {"count", bin.count}});
  return {{"findings", list},
          {"wake_latency_ns",
           {{"p50", wakeUps.p50_ns}, {"p99", wakeUps.p99_ns}, {"p999", wakeUps.p999_ns}, {"max", wakeUps.max_ns}}},
          {"wake_latency_histogram", bins},
          {"rate_Hz", options.rate_Hz},
          {"wake_ups", wakeUps.count},
          {"late_wake_ups", wakeUps.late},
          {"realtime",
           {{"fifo", wakeUps.realtime.fifo},
            {"memory_locked", wakeUps.realtime.memoryLocked},
            {"pinned", wakeUps.realtime.pinned}}}};
}

[[nodiscard]] std::optional<int> parse(int argc, char** argv, DoctorOptions& options) {
  CommandLine app{
      "What this machine permits a real-time servo, how punctually it wakes one up, what devices that are here lack, "
      "and what to "
      "change.",
      "haptic_server doctor"};
  app.option("--seconds", options.seconds, "Measure for this long").range(0.1, 86'400.0).showDefault();
  app.option("--rate", options.rate_Hz, "Servo rate in Hz").range(100.0, 20'000.0).showDefault();
  app.option("--pin", options.cpu, "CPU to bind the measuring thread to").zeroOrMore();
  app.flag("--json", options.json, "For scripts");
  app.footer("Run it as the user who runs the server, and while the machine does what it will then do.");
  if (const auto code = app.parse(argc, argv)) return *code == 0 ? 0 : 2;
  return std::nullopt;
}

}  // namespace

int runDoctor(int argc, char** argv) {
  DoctorOptions options;
  if (const auto code = parse(argc, argv, options)) return *code;
  std::vector<Finding> findings = judge(readMachineFacts());
  std::ranges::move(judge(readDeviceFacts(deviceEnvironment())), std::back_inserter(findings));
  if (!options.json) {
    for (const Finding& finding : findings) print(finding);
    std::printf("measuring wake-ups for %g s ...\n", options.seconds);
    std::fflush(stdout);
  }
  const WakeUps wakeUps = measureWakeUps(options.seconds, options.rate_Hz, options.cpu);
  findings.push_back(judge(wakeUps, options.rate_Hz));
  if (options.json) {
    std::cout << toJson(findings, wakeUps, options).indented() << '\n';
  } else {
    print(findings.back());
    print(wakeUps);
  }
  const bool can =
      std::ranges::none_of(findings, [](const Finding& finding) { return finding.verdict == Verdict::kMissing; });
  return can ? 0 : 1;
}

}  // namespace haptics
