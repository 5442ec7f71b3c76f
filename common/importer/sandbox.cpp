#include "common/importer/sandbox.h"

#include <fcntl.h>
#include <linux/capability.h>
#include <sched.h>
#include <seccomp.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <initializer_list>
#include <memory>
#include <string>

namespace haptics {
namespace {

constexpr int kNice = 10;
constexpr rlim_t kMaxFiles = 32;

#ifdef HAPTICS_SANITIZED
constexpr bool kSanitized = true;  // which reserves terabytes, and calls what it likes
#else
constexpr bool kSanitized = false;
#endif

/// A scene's assets take 512 MiB, which is a mesh of 28 million triangles; importing takes up to 400 bytes a triangle.
constexpr rlim_t kMaxMemory_bytes = rlim_t{12} << 30;

rlim_t maxMemory_bytes() {
  const auto half = static_cast<rlim_t>(sysconf(_SC_PHYS_PAGES)) / 2 * static_cast<rlim_t>(sysconf(_SC_PAGESIZE));
  return std::min(kMaxMemory_bytes, half);
}

void limit(__rlimit_resource_t resource, rlim_t most) {
  const rlimit limits{most, most};
  setrlimit(resource, &limits);
}

void dropCapabilities() {
  prctl(PR_CAP_AMBIENT, PR_CAP_AMBIENT_CLEAR_ALL, 0, 0, 0);
  for (int capability = 0; prctl(PR_CAPBSET_READ, capability) >= 0; ++capability) {
    prctl(PR_CAPBSET_DROP, capability);  // not without CAP_SETPCAP, but then there is nothing to gain from it either
  }
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  const std::array<__user_cap_data_struct, _LINUX_CAPABILITY_U32S_3> none{};
  syscall(SYS_capset, &header, none.data());
}

/// The rules, in the order in which they are added; the first that cannot be ends it.
class Filter {
 public:
  Filter() : filter_(seccomp_init(SCMP_ACT_KILL_PROCESS), &seccomp_release), error_(filter_ ? 0 : -ENOMEM) {}

  void add(std::uint32_t action, std::initializer_list<int> calls) {
    for (const int call : calls) add(action, call, {});
  }
  void add(std::uint32_t action, int call, std::initializer_list<scmp_arg_cmp> when) {
    if (error_ != 0) return;
    error_ = seccomp_rule_add_array(filter_.get(), action, call, static_cast<unsigned>(when.size()), when.begin());
  }
  /// 0, or the error's number.
  [[nodiscard]] int load() { return error_ != 0 ? -error_ : -seccomp_load(filter_.get()); }

 private:
  std::unique_ptr<void, decltype(&seccomp_release)> filter_;
  int error_;
};

}  // namespace

void lowerPriorityAndLimit(unsigned processorTime_s) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  std::ofstream("/proc/self/oom_score_adj") << "1000";
  const sched_param none{};
  sched_setscheduler(0, SCHED_OTHER, &none);
  setpriority(PRIO_PROCESS, 0, kNice);
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_FSIZE, 0);
  limit(RLIMIT_NOFILE, kMaxFiles);
  limit(RLIMIT_CPU, processorTime_s);
  if (!kSanitized) limit(RLIMIT_AS, maxMemory_bytes());
  dropCapabilities();
  prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
  prctl(PR_SET_DUMPABLE, 0);
}

void limitMore(std::uintmax_t memory_bytes, unsigned processorTime_s, void (*onTime)(int)) {
  if (!kSanitized) limit(RLIMIT_AS, std::min<rlim_t>(maxMemory_bytes(), memory_bytes));
  signal(SIGXCPU, onTime);
  rlimit time{};
  getrlimit(RLIMIT_CPU, &time);
  time.rlim_cur = std::min<rlim_t>(time.rlim_max, processorTime_s);
  setrlimit(RLIMIT_CPU, &time);
}

Result<void> enterSandbox() {
  if (kSanitized) return {};
  Filter filter;
  filter.add(
      SCMP_ACT_ALLOW,
      {SCMP_SYS(read),    SCMP_SYS(pread64),       SCMP_SYS(readv),          SCMP_SYS(write),        SCMP_SYS(writev),
       SCMP_SYS(sendmsg), SCMP_SYS(recvmsg),       SCMP_SYS(lseek),          SCMP_SYS(fstat),        SCMP_SYS(close),
       SCMP_SYS(dup),     SCMP_SYS(munmap),        SCMP_SYS(mremap),         SCMP_SYS(madvise),      SCMP_SYS(brk),
       SCMP_SYS(futex),   SCMP_SYS(clock_gettime), SCMP_SYS(gettimeofday),   SCMP_SYS(getrandom),    SCMP_SYS(getpid),
       SCMP_SYS(gettid),  SCMP_SYS(rt_sigaction),  SCMP_SYS(rt_sigprocmask), SCMP_SYS(rt_sigreturn), SCMP_SYS(sysinfo),
       SCMP_SYS(exit),    SCMP_SYS(exit_group)});
  filter.add(SCMP_ACT_ALLOW, SCMP_SYS(mmap), {SCMP_A2(SCMP_CMP_MASKED_EQ, PROT_EXEC, 0)});
  filter.add(SCMP_ACT_ALLOW, SCMP_SYS(mprotect), {SCMP_A2(SCMP_CMP_MASKED_EQ, PROT_EXEC, 0)});
  // fstat() of glibc.
  filter.add(SCMP_ACT_ALLOW, SCMP_SYS(newfstatat), {SCMP_A3(SCMP_CMP_MASKED_EQ, AT_EMPTY_PATH, AT_EMPTY_PATH)});
  filter.add(SCMP_ACT_ALLOW, SCMP_SYS(fcntl), {SCMP_A1(SCMP_CMP_EQ, F_GETFL)});
  // By abort(), so that what killed it has its own name.
  filter.add(SCMP_ACT_ALLOW, SCMP_SYS(tgkill), {SCMP_A0(SCMP_CMP_EQ, static_cast<scmp_datum_t>(getpid()))});
  // Libraries look for what they can do without: fonts, their settings, a terminal.
  filter.add(SCMP_ACT_ERRNO(EACCES), {SCMP_SYS(open), SCMP_SYS(openat), SCMP_SYS(stat), SCMP_SYS(lstat),
                                      SCMP_SYS(access), SCMP_SYS(readlink), SCMP_SYS(getcwd), SCMP_SYS(ioctl)});
  filter.add(SCMP_ACT_ERRNO(EACCES), SCMP_SYS(newfstatat), {SCMP_A3(SCMP_CMP_MASKED_EQ, AT_EMPTY_PATH, 0)});
  if (const int error = filter.load(); error != 0) {
    return refused("", std::string("cannot be read safely: system calls cannot be filtered: ") + std::strerror(error));
  }
  return {};
}

}  // namespace haptics
