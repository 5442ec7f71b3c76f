#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <numeric>

#include "haptic_server/doctor/device_facts.h"
#include "haptic_server/doctor/findings.h"
#include "tests/common/temporary_folder.h"

namespace haptics::doctor_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// A machine with nothing to find fault with, as its files say.
class Machine {
 public:
  Machine() {
    write("proc/self/status", "Name:\tserver\nCapEff:\t0000000000804000\n");
    write("proc/sys/kernel/osrelease", "6.1.0-rt\n");
    write("proc/sys/kernel/version", "#1 SMP PREEMPT_RT Debian 6.1\n");
    write("proc/cpuinfo", "model name\t: some\nflags\t\t: fpu sse4_2\n\n");
    write("proc/sys/kernel/sched_rt_runtime_us", "950000\n");
    write("proc/sys/kernel/sched_rt_period_us", "1000000\n");
    write("sys/devices/system/cpu/isolated", "3\n");
    write("sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "performance\n");
    write("sys/devices/system/cpu/cpu1/cpufreq/scaling_governor", "performance\n");
    write("sys/devices/system/clocksource/clocksource0/current_clocksource", "tsc\n");
    write("sys/kernel/mm/transparent_hugepage/enabled", "always [madvise] never\n");
    write("sys/module/usbcore/parameters/autosuspend", "-1\n");
    write("dev/cpu_dma_latency", "");
  }
  void write(const std::string& file, const std::string& text) {
    const auto path = folder_ / file;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path) << text;
  }
  void remove(const std::string& file) { std::filesystem::remove_all(folder_ / file); }
  /// In its place; to nothing, as root may open every file.
  void link(const std::string& file, const std::string& to) {
    remove(file);
    std::filesystem::create_symlink(to, folder_ / file);
  }
  [[nodiscard]] const std::filesystem::path& path() const { return folder_.path(); }
  [[nodiscard]] MachineFacts facts() const { return readMachineFacts(folder_.path()); }
  [[nodiscard]] Finding finding(const std::string& what) const {
    for (const Finding& finding : judge(facts())) {
      if (finding.what == what) return finding;
    }
    ADD_FAILURE() << "nothing is said of " << what;
    return {};
  }

 private:
  test::TemporaryFolder folder_;
};

TEST(MachineFacts, AreReadFromTheFilesOfTheSystem) {
  const MachineFacts facts = Machine().facts();
  EXPECT_TRUE(facts.mayRaisePriority);
  EXPECT_TRUE(facts.mayLockMemory);
  EXPECT_TRUE(facts.mayRequestLatency);
  EXPECT_EQ(facts.kernel, "6.1.0-rt");
  EXPECT_EQ(facts.preemption, "PREEMPT_RT");
  EXPECT_FALSE(facts.virtualMachine);
  EXPECT_GT(facts.processors, 0);
  EXPECT_EQ(facts.isolated, "3");
  EXPECT_THAT(facts.governors, ElementsAre("performance"));
  EXPECT_EQ(facts.clockSource, "tsc");
  EXPECT_EQ(facts.largePages, "madvise");
  EXPECT_EQ(facts.realTimeShare_us, 950'000);
  EXPECT_EQ(facts.usbAutosuspend_s, -1);
}

TEST(MachineFacts, AreEmptyWhereTheSystemSaysNothing) {
  const test::TemporaryFolder nothing;
  const MachineFacts facts = readMachineFacts(nothing.path());
  EXPECT_FALSE(facts.mayRaisePriority);
  EXPECT_FALSE(facts.mayRequestLatency);
  EXPECT_EQ(facts.preemption, "");
  EXPECT_EQ(facts.usbAutosuspend_s, std::nullopt);
  for (const Finding& finding : judge(facts)) EXPECT_FALSE(finding.found.empty()) << finding.what;
}

TEST(Doctor, FindsNothingToChangeOnAMachineThatIsSetUp) {
  for (const Finding& finding : judge(Machine().facts())) {
    if (finding.what == "processors") continue;  // of the machine that runs the test
    EXPECT_EQ(finding.verdict, Verdict::kGood) << finding.what;
  }
}

TEST(Doctor, NamesEachThingThatIsAmissAndWhatToDo) {
  const struct {
    const char *file, *text, *what, *found, *advice;
    Verdict verdict;
  } kCases[] = {
      {"proc/sys/kernel/version", "#1 SMP PREEMPT_DYNAMIC", "kernel", "PREEMPT_DYNAMIC", "linux-image-rt",
       Verdict::kWorse},
      {"proc/cpuinfo", "flags\t\t: fpu hypervisor\n", "processors", "virtual machine", "real machine", Verdict::kWorse},
      {"sys/devices/system/cpu/cpu1/cpufreq/scaling_governor", "powersave", "processor frequency",
       "performance, powersave", "performance", Verdict::kWorse},
      {"sys/devices/system/clocksource/clocksource0/current_clocksource", "hpet", "clock", "hpet", "tsc",
       Verdict::kWorse},
      {"sys/kernel/mm/transparent_hugepage/enabled", "always madvise [never]", "large pages", "never", "madvise",
       Verdict::kWorse},
      {"proc/sys/kernel/sched_rt_runtime_us", "400000", "share of real time", "400 ms", "sysctl", Verdict::kWorse},
      {"sys/module/usbcore/parameters/autosuspend", "2", "USB autosuspend", "after 2 s", "udev", Verdict::kWorse},
  };
  for (const auto& c : kCases) {
    Machine machine;
    machine.write(c.file, c.text);
    const Finding finding = machine.finding(c.what);
    EXPECT_EQ(finding.verdict, c.verdict) << c.what;
    EXPECT_THAT(finding.found, HasSubstr(c.found));
    EXPECT_THAT(finding.advice, HasSubstr(c.advice));
  }
}

TEST(Doctor, MissesThePriorityAndTheMemoryThatTheServoNeeds) {
  MachineFacts facts = Machine().facts();
  facts.mayRaisePriority = facts.mayLockMemory = false;
  facts.maxPriority = 0;
  facts.lockableMemory_bytes = 8U << 20;
  const auto findings = judge(facts);
  EXPECT_EQ(findings[0].verdict, Verdict::kMissing);
  EXPECT_THAT(findings[0].advice, HasSubstr("rtprio"));
  EXPECT_EQ(findings[1].verdict, Verdict::kMissing);
  EXPECT_THAT(findings[1].found, HasSubstr("8 MB"));
  EXPECT_THAT(findings[1].advice, HasSubstr("memlock"));
  facts.maxPriority = 90;
  facts.lockableMemory_bytes = ~std::uint64_t{0};
  EXPECT_EQ(judge(facts)[0].verdict, Verdict::kGood);
  EXPECT_EQ(judge(facts)[1].verdict, Verdict::kGood);
}

/// All that the three makers' devices need.
class MachineOfDevices : public Machine {
 public:
  MachineOfDevices() {
    plugIn("1-1", "1451", "0402", "7");
    plugIn("1-2", "2988", "0302", "8");
    write("dev/ttyACM0", "");
    write("usr/lib/libHD.so.3.4", "");
    write("usr/share/3DSystems/config/Default Device.config", "");
    write("sdk/lib/release/lin-x86_64-gcc/libdrd.so.3.17.6", "");
    write("proc/net/tcp", "  0: 0100007F:2711 00000000:0000 0A 00000000:00000000\n");
  }
  void plugIn(const std::string& port, const std::string& vendor, const std::string& product,
              const std::string& number) {
    const std::string folder = "sys/bus/usb/devices/" + port + "/";
    write(folder + "idVendor", vendor + "\n");
    write(folder + "idProduct", product + "\n");
    write(folder + "busnum", "1\n");
    write(folder + "devnum", number + "\n");
    write(folder + "power/control", "on\n");
    write("dev/bus/usb/001/00" + number, "");
  }
  [[nodiscard]] std::vector<Finding> findings() const { return judge(readDeviceFacts(environment, path())); }

  Environment environment{{"GTDD_HOME", "/usr/share/3DSystems"}, {"FDSDK", "/sdk"}};
};

TEST(DeviceFacts, SayNothingWhereNoDeviceIs) {
  EXPECT_THAT(judge(readDeviceFacts({}, Machine().path())), ElementsAre());
}

TEST(DeviceFacts, FindNothingToChangeWhereAllIsSetUp) {
  const auto findings = MachineOfDevices().findings();
  EXPECT_EQ(findings.size(), 6U);
  for (const Finding& finding : findings) EXPECT_EQ(finding.verdict, Verdict::kGood) << finding.what;
}

TEST(DeviceFacts, NameEachThingThatIsAmissAndWhatToDo) {
  using Harm = void (*)(MachineOfDevices&);
  const struct {
    Harm harm;
    const char *what, *found, *advice;
  } kCases[] = {
      {[](auto& machine) { machine.remove("dev/bus/usb/001/007"); }, "Force Dimension", "may not be opened", "udev"},
      {[](auto& machine) { machine.write("sys/bus/usb/devices/1-1/power/control", "auto"); }, "Force Dimension",
       "sleep", "power/control"},
      {[](auto& machine) { machine.write("sys/bus/usb/devices/1-2/power/control", "auto"); }, "3D Systems Touch",
       "sleep", "power/control"},
      {[](auto& machine) { machine.remove("usr/lib/libHD.so.3.4"); }, "OpenHaptics", "no libHD.so", "LD_LIBRARY_PATH"},
      {[](auto& machine) { machine.environment.erase("GTDD_HOME"); }, "GTDD_HOME", "is not set", "export GTDD_HOME"},
      {[](auto& machine) { machine.remove("usr/share/3DSystems/config"); }, "GTDD_HOME", "is no folder with files",
       "pair the device"},
      {[](auto& machine) { machine.environment["GTDD_HOME"] = "/gone"; }, "GTDD_HOME", "/gone is no folder", "pair"},
      {[](auto& machine) { machine.link("dev/ttyACM0", "gone"); }, "Touch on USB", "/dev/ttyACM0 may not be opened",
       "dialout"},
      {[](auto& machine) { machine.remove("sdk/lib"); }, "Force Dimension SDK", "below FDSDK, /sdk", "FDSDK"},
      {[](auto& machine) {
         machine.write("proc/net/tcp", "  0: 0100007F:2711 0100007F:9999 01 00000000:00000000\n");
         machine.write("opt/Haply/hub", "");
       },
       "Haply's service", "nothing listens", "systemctl start"},
  };
  for (const auto& c : kCases) {
    MachineOfDevices machine;
    c.harm(machine);
    bool found = false;
    for (const Finding& finding : machine.findings()) {
      if (finding.verdict == Verdict::kGood) continue;
      EXPECT_FALSE(found) << c.what << " and " << finding.what;
      found = true;
      EXPECT_EQ(finding.what, c.what);
      EXPECT_EQ(finding.verdict, Verdict::kWorse);
      EXPECT_THAT(finding.found, HasSubstr(c.found));
      EXPECT_THAT(finding.advice, HasSubstr(c.advice));
    }
    EXPECT_TRUE(found) << c.what << ", " << c.found;
  }
}

TEST(WakeUps, AreMeasuredAtTheRateAndEveryOneIsInTheHistogram) {
  const WakeUps wakeUps = measureWakeUps(0.3, 1000, std::nullopt);
  EXPECT_GT(wakeUps.count, 30U) << "a loaded machine sleeps through some";
  EXPECT_LE(wakeUps.count, 300U);
  const auto binned = std::accumulate(wakeUps.bins.begin(), wakeUps.bins.end(), std::uint64_t{0},
                                      [](std::uint64_t sum, const WakeUps::Bin& bin) { return sum + bin.count; });
  EXPECT_EQ(binned, wakeUps.count);
  EXPECT_LE(wakeUps.p50_ns, wakeUps.p99_ns);
  EXPECT_LE(wakeUps.p999_ns, wakeUps.max_ns);
}

TEST(WakeUps, ThatComeLateAreFoundFaultWith) {
  WakeUps wakeUps;
  wakeUps.count = 10'000;
  EXPECT_EQ(judge(wakeUps, 1000).verdict, Verdict::kGood);
  wakeUps.late = 3;
  EXPECT_EQ(judge(wakeUps, 1000).verdict, Verdict::kWorse);
  EXPECT_THAT(judge(wakeUps, 1000).found, HasSubstr("3 of 10000"));
  wakeUps.late = 100;
  EXPECT_EQ(judge(wakeUps, 1000).verdict, Verdict::kMissing);
}

}  // namespace
}  // namespace haptics::doctor_test
