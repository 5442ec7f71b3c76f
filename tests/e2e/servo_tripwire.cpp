// Preloaded into haptic_server: ends it, saying why, when its servo thread takes a lock or makes a system call other than
// the sleep between two ticks. Armed by the servo's first sleep. HAPTICS_TRIPWIRE_TRY=lock or =call makes the thread do
// that, to show that the wire trips.

#include <dlfcn.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <pthread.h>
#include <semaphore.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <thread>

namespace {

constexpr int kTripped = 99;  // exit code
constexpr int kNothing = -1;

constinit thread_local bool armed = false;
std::atomic<const char*> lockTaken{nullptr};
std::atomic<int> callMade{kNothing};

void tripOnCall(int, siginfo_t* info, void*) { callMade = info->si_syscall; }

/// The servo thread looks into nothing itself: printing is a system call.
void watch() {
  for (;;) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    if (const char* name = lockTaken) std::fprintf(stderr, "tripwire: the servo thread called %s\n", name);
    if (callMade != kNothing) std::fprintf(stderr, "tripwire: the servo thread made system call %d\n", callMade.load());
    if (lockTaken != nullptr || callMade != kNothing) _exit(kTripped);
  }
}

/// Every other system call of this thread, and of none else, raises SIGSYS instead.
void allowOnlySleep() {
  constexpr auto kNumber = static_cast<__u32>(offsetof(seccomp_data, nr));
  sock_filter filter[] = {
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, kNumber),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_clock_nanosleep, 4, 0),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_clock_gettime, 3, 0),  // where the clock cannot be read without one
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_restart_syscall, 2, 0),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_rt_sigreturn, 1, 0),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_TRAP),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
  };
  sock_fprog program{static_cast<unsigned short>(std::size(filter)), filter};
  if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0 || prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) != 0) {
    std::perror("tripwire: no seccomp filter");
    _exit(kTripped);
  }
}

void arm() {
  struct sigaction action {};
  action.sa_sigaction = tripOnCall;
  action.sa_flags = SA_SIGINFO;
  sigaction(SIGSYS, &action, nullptr);
  std::thread(watch).detach();
  std::fprintf(stderr, "tripwire: armed\n");
  allowOnlySleep();
  armed = true;
}

void tryWhatIsForbidden() {
  static const char* const wanted = std::getenv("HAPTICS_TRIPWIRE_TRY");
  if (wanted == nullptr) return;
  static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
  if (std::strcmp(wanted, "lock") == 0 && pthread_mutex_lock(&mutex) == 0) pthread_mutex_unlock(&mutex);
  if (std::strcmp(wanted, "call") == 0) static_cast<void>(syscall(SYS_getppid));
}

template <class Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

}  // namespace

// NOLINTBEGIN: the names are libc's
#define TRIP_ON(name, parameters, arguments)               \
  extern "C" int name parameters {                         \
    static auto* const real = next<int parameters>(#name); \
    if (armed) lockTaken = #name;                          \
    return real arguments;                                 \
  }
TRIP_ON(pthread_mutex_lock, (pthread_mutex_t * m), (m))
TRIP_ON(pthread_mutex_trylock, (pthread_mutex_t * m), (m))
TRIP_ON(pthread_rwlock_rdlock, (pthread_rwlock_t * l), (l))
TRIP_ON(pthread_rwlock_wrlock, (pthread_rwlock_t * l), (l))
TRIP_ON(pthread_cond_signal, (pthread_cond_t * c), (c))
TRIP_ON(pthread_cond_broadcast, (pthread_cond_t * c), (c))
TRIP_ON(pthread_cond_wait, (pthread_cond_t * c, pthread_mutex_t* m), (c, m))
TRIP_ON(sem_post, (sem_t * s), (s))
TRIP_ON(sem_wait, (sem_t * s), (s))

extern "C" int clock_nanosleep(clockid_t clock, int flags, const timespec* until, timespec* left) {
  static auto* const real = next<int(clockid_t, int, const timespec*, timespec*)>("clock_nanosleep");
  if (!armed) {
    char name[16] = {};
    pthread_getname_np(pthread_self(), name, sizeof name);
    if (std::strcmp(name, "servo") == 0) arm();
  } else {
    tryWhatIsForbidden();
  }
  return real(clock, flags, until, left);
}
// NOLINTEND
