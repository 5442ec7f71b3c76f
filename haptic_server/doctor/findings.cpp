#include "haptic_server/doctor/findings.h"

#include <cmath>
#include <cstdio>

namespace haptics {
namespace {

constexpr std::uint64_t kPriority = 80;  // haptic_server's own (realtime.cpp), and above it room for nothing
constexpr std::uint64_t kMemory_bytes = std::uint64_t{4} << 30;  // a server with a large scene

[[nodiscard]] std::string inMegabytes(std::uint64_t bytes) { return std::to_string(bytes >> 20) + " MB"; }

[[nodiscard]] Finding priority(const MachineFacts& facts) {
  if (facts.mayRaisePriority) return {"real-time priority", "allowed (CAP_SYS_NICE)"};
  if (facts.maxPriority >= kPriority)
    return {"real-time priority", "allowed up to " + std::to_string(facts.maxPriority)};
  return {
      "real-time priority", "limit " + std::to_string(facts.maxPriority) + ", the servo wants 80", Verdict::kMissing,
      "any busy program delays the servo. Add \"USER - rtprio 90\" to /etc/security/limits.conf and log in again, or "
      "run it as the systemd unit in deploy/systemd"};
}

[[nodiscard]] Finding memory(const MachineFacts& facts) {
  if (facts.mayLockMemory) return {"locked memory", "allowed (CAP_IPC_LOCK)"};
  if (facts.lockableMemory_bytes >= kMemory_bytes)
    return {"locked memory", "allowed, " + inMegabytes(facts.lockableMemory_bytes)};
  return {"locked memory", "limit " + inMegabytes(facts.lockableMemory_bytes), Verdict::kMissing,
          "a page fault may delay a tick by milliseconds. Add \"USER - memlock unlimited\" to "
          "/etc/security/limits.conf and log in again, or run it as the systemd unit in deploy/systemd"};
}

[[nodiscard]] Finding idleStates(const MachineFacts& facts) {
  if (facts.mayRequestLatency) return {"idle processors", "can be kept from sleeping deeply"};
  return {
      "idle processors", "/dev/cpu_dma_latency cannot be written", Verdict::kWorse,
      "the servo wakes some 10 to 100 us later from deep sleep. Allow it: sudo chmod o+w /dev/cpu_dma_latency (until "
      "the next boot), or run the server as the systemd unit in deploy/systemd"};
}

[[nodiscard]] Finding kernel(const MachineFacts& facts) {
  const std::string found = facts.kernel + ", preemption " + (facts.preemption.empty() ? "unknown" : facts.preemption);
  if (facts.preemption == "PREEMPT_RT") return {"kernel", found};
  return {"kernel", found, Verdict::kWorse,
          "the kernel itself may hold the servo up, seldom for more than a millisecond. Where that matters: sudo apt "
          "install linux-image-rt-amd64, and boot it"};
}

[[nodiscard]] Finding machine(const MachineFacts& facts) {
  const std::string found = std::to_string(facts.processors) + (facts.processors == 1 ? " processor" : " processors") +
                            (facts.virtualMachine ? " of a virtual machine" : "");
  if (facts.virtualMachine)
    return {
        "processors", found, Verdict::kWorse,
        "the host may take a processor away for tens of milliseconds, and nothing in here can prevent it. For a real "
        "device use a real machine"};
  if (facts.processors < 2)
    return {"processors", found, Verdict::kWorse, "the servo shares its processor with all others; have two"};
  return {"processors", found};
}

[[nodiscard]] Finding isolation(const MachineFacts& facts) {
  if (!facts.isolated.empty())
    return {"isolated processors", facts.isolated, Verdict::kGood,
            "give one to the servo: --pin " + facts.isolated.substr(0, facts.isolated.find_first_of(",-"))};
  return {
      "isolated processors", "none", Verdict::kGood,
      "not needed at 1 kHz; for 10 kHz and more, boot with isolcpus=N nohz_full=N and start the server with --pin N"};
}

[[nodiscard]] Finding governor(const MachineFacts& facts) {
  if (facts.governors.empty()) return {"processor frequency", "not controlled here"};
  std::string found;
  for (const std::string& name : facts.governors) found += (found.empty() ? "" : ", ") + name;
  if (facts.governors == std::vector<std::string>{"performance"}) return {"processor frequency", found};
  return {"processor frequency", found, Verdict::kWorse,
          "a processor that has slowed down takes longer for a tick. sudo cpupower frequency-set -g performance"};
}

[[nodiscard]] Finding clock(const MachineFacts& facts) {
  const bool slow = facts.clockSource == "hpet" || facts.clockSource == "acpi_pm" || facts.clockSource == "jiffies";
  if (!slow) return {"clock", facts.clockSource.empty() ? "unknown" : facts.clockSource};
  return {"clock", facts.clockSource, Verdict::kWorse,
          "each look at it is a system call of about a microsecond; see why the kernel has given the tsc up: dmesg | "
          "grep -i tsc"};
}

[[nodiscard]] Finding largePages(const MachineFacts& facts) {
  if (facts.largePages != "never") return {"large pages", facts.largePages.empty() ? "unknown" : facts.largePages};
  return {"large pages", facts.largePages, Verdict::kWorse,
          "ticks on meshes of a million triangles take longer. echo madvise | sudo tee "
          "/sys/kernel/mm/transparent_hugepage/enabled"};
}

[[nodiscard]] Finding share(const MachineFacts& facts) {
  if (!facts.realTimeShare_us) return {"share of real time", "unknown"};
  if (*facts.realTimeShare_us < 0) return {"share of real time", "all of the time"};
  const std::string found = std::to_string(*facts.realTimeShare_us / 1000) + " ms of each second";
  if (*facts.realTimeShare_us >= 900'000) return {"share of real time", found};
  return {"share of real time", found, Verdict::kWorse,
          "the servo is stopped when it has used that. sudo sysctl kernel.sched_rt_runtime_us=950000"};
}

[[nodiscard]] Finding usb(const MachineFacts& facts) {
  if (!facts.usbAutosuspend_s) return {"USB autosuspend", "no USB here"};
  if (*facts.usbAutosuspend_s < 0) return {"USB autosuspend", "off"};
  return {"USB autosuspend", "after " + std::to_string(*facts.usbAutosuspend_s) + " s", Verdict::kWorse,
          "a device that rests may be put to sleep. Start the kernel with usbcore.autosuspend=-1; the udev rules in "
          "deploy/udev keep the known devices awake"};
}

}  // namespace

std::vector<Finding> judge(const MachineFacts& facts) {
  return {priority(facts), memory(facts), idleStates(facts), kernel(facts), machine(facts), isolation(facts),
          governor(facts), clock(facts),  largePages(facts), share(facts),  usb(facts)};
}

Finding judge(const WakeUps& wakeUps, double rate_Hz) {
  const double part = wakeUps.count > 0 ? static_cast<double>(wakeUps.late) / static_cast<double>(wakeUps.count) : 0;
  char found[160];
  std::snprintf(found, sizeof found,
                "%llu of %llu came a period or more late; half within %.0f us, 99.9 %% within %.0f us",
                static_cast<unsigned long long>(wakeUps.late), static_cast<unsigned long long>(wakeUps.count),
                static_cast<double>(wakeUps.p50_ns) * 1e-3, static_cast<double>(wakeUps.p999_ns) * 1e-3);
  const std::string what = "wake-ups at " + std::to_string(std::lround(rate_Hz)) + " Hz";
  if (wakeUps.late == 0) return {what, found};
  constexpr double kOften = 1e-3;
  return {
      what, found, part > kOften ? Verdict::kMissing : Verdict::kWorse,
      "each of them is a tick that is not felt. Mend what is marked above, stop other work, or choose a lower --rate"};
}

}  // namespace haptics
