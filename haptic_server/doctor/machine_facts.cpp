#include "haptic_server/doctor/machine_facts.h"

#include <sys/resource.h>
#include <unistd.h>

#include <charconv>
#include <fstream>
#include <iterator>
#include <set>

namespace haptics {
namespace fs = std::filesystem;
namespace {

constexpr int kCapabilityIpcLock = 14;
constexpr int kCapabilitySysNice = 23;

/// Without the white space at its end; empty where it cannot be read.
[[nodiscard]] std::string contents(const fs::path& file) {
  std::ifstream in(file);
  std::string text{std::istreambuf_iterator<char>(in), {}};
  text.erase(text.find_last_not_of(" \n\t") + 1);
  return text;
}

[[nodiscard]] std::optional<std::int64_t> numberIn(const fs::path& file) {
  const std::string text = contents(file);
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() ? std::optional(value) : std::nullopt;
}

/// The value behind `key` in lines of "key: value".
[[nodiscard]] std::string lineIn(const std::string& text, const std::string& key) {
  const std::size_t at = text.find(key + ":");
  if (at == std::string::npos) return "";
  const std::size_t begin = text.find_first_not_of(" \t", at + key.size() + 1);
  return begin == std::string::npos ? "" : text.substr(begin, text.find('\n', begin) - begin);
}

/// The choice in brackets: "always [madvise] never".
[[nodiscard]] std::string chosen(const std::string& text) {
  const std::size_t begin = text.find('['), end = text.find(']');
  return begin == std::string::npos || end == std::string::npos ? "" : text.substr(begin + 1, end - begin - 1);
}

[[nodiscard]] std::string preemptionOf(const fs::path& root) {
  if (numberIn(root / "sys/kernel/realtime") == 1) return "PREEMPT_RT";
  const std::string version = contents(root / "proc/sys/kernel/version");
  for (const char* kind : {"PREEMPT_RT", "PREEMPT_DYNAMIC", "PREEMPT"}) {
    if (version.find(kind) != std::string::npos) return kind;
  }
  return version.empty() ? "" : "none";
}

[[nodiscard]] std::vector<std::string> governorsBelow(const fs::path& folder) {
  std::set<std::string> governors;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    governors.insert(contents(entry.path() / "cpufreq/scaling_governor"));
  }
  governors.erase("");
  return {governors.begin(), governors.end()};
}

[[nodiscard]] std::uint64_t limitOf(__rlimit_resource resource) {
  rlimit limit{};
  return getrlimit(resource, &limit) == 0 ? limit.rlim_cur : 0;
}

}  // namespace

MachineFacts readMachineFacts(const fs::path& root) {
  MachineFacts facts;
  facts.maxPriority = limitOf(RLIMIT_RTPRIO);
  facts.lockableMemory_bytes = limitOf(RLIMIT_MEMLOCK);
  const std::string capabilities = lineIn(contents(root / "proc/self/status"), "CapEff");
  std::uint64_t bits = 0;
  std::from_chars(capabilities.data(), capabilities.data() + capabilities.size(), bits, 16);
  facts.mayRaisePriority = (bits >> kCapabilitySysNice & 1) != 0;
  facts.mayLockMemory = (bits >> kCapabilityIpcLock & 1) != 0;
  facts.mayRequestLatency = access((root / "dev/cpu_dma_latency").c_str(), W_OK) == 0;

  facts.kernel = contents(root / "proc/sys/kernel/osrelease");
  facts.preemption = preemptionOf(root);
  facts.virtualMachine = lineIn(contents(root / "proc/cpuinfo"), "flags\t\t").find("hypervisor") != std::string::npos;
  facts.processors = static_cast<int>(sysconf(_SC_NPROCESSORS_ONLN));
  facts.isolated = contents(root / "sys/devices/system/cpu/isolated");
  facts.governors = governorsBelow(root / "sys/devices/system/cpu");
  facts.clockSource = contents(root / "sys/devices/system/clocksource/clocksource0/current_clocksource");
  facts.largePages = chosen(contents(root / "sys/kernel/mm/transparent_hugepage/enabled"));
  if (const auto share_us = numberIn(root / "proc/sys/kernel/sched_rt_runtime_us")) {
    const auto period_us = numberIn(root / "proc/sys/kernel/sched_rt_period_us").value_or(1'000'000);
    facts.realTimeShare_us = *share_us < 0 || period_us <= 0 ? -1 : *share_us * 1'000'000 / period_us;
  }
  facts.usbAutosuspend_s = numberIn(root / "sys/module/usbcore/parameters/autosuspend");
  return facts;
}

}  // namespace haptics
