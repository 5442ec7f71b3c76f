#include "haptic_server/servo/realtime.h"

#include <fcntl.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>

namespace haptics {
namespace {

/// Above every ordinary thread and most kernel work, below the kernel's own watchdogs (99).
constexpr int kServoPriority = 80;
/// Bytes of stack that a tick may use; moveTogether() of kMaxColliders bodies, the largest user, has half of them.
constexpr std::size_t kServoStack_bytes = 1U << 20;

void touchStack() noexcept {
  volatile char stack[kServoStack_bytes];
  for (std::size_t i = 0; i < sizeof stack; i += 4096) stack[i] = 0;
}

std::string why(int error) { return std::string(" (") + std::strerror(error) + ")"; }

}  // namespace

void keepStacksSmall() {
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, 2 * kServoStack_bytes);
  pthread_setattr_default_np(&attributes);
  pthread_attr_destroy(&attributes);
}

void lockMemory(RealtimeStatus& status) {
  if (mlockall(MCL_CURRENT | MCL_FUTURE) == 0) {
    status.memoryLocked = true;
    return;
  }
  status.warnings.push_back("memory is not locked" + why(errno) +
                            ": a page fault may delay a tick; run as root or raise the memlock limit (ulimit -l)");
}

void lockMemoryAsItIsWritten() { (void)mlockall(MCL_FUTURE | MCL_ONFAULT); }

CpuIdleInhibitor::CpuIdleInhibitor(RealtimeStatus& status)
    : request_(open("/dev/cpu_dma_latency", O_WRONLY | O_CLOEXEC)) {
  const std::int32_t latency_us = 0;
  if (request_ >= 0 && write(request_, &latency_us, sizeof latency_us) == sizeof latency_us) return;
  status.warnings.push_back("idle processors may sleep deeply" + why(errno) +
                            ": the servo wakes later; run as root or allow writing /dev/cpu_dma_latency");
}

CpuIdleInhibitor::~CpuIdleInhibitor() {
  if (request_ >= 0) close(request_);
}

void configureDriverThread(RealtimeStatus& status) {
  pthread_setname_np(pthread_self(), "device");
  prctl(PR_SET_TIMERSLACK, 1UL);
  const sched_param priority{.sched_priority = kServoPriority - 1};
  if (const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &priority); error != 0) {
    status.warnings.push_back("the device's thread is not real-time" + why(error) + ": see the servo's");
  }
}

void configureServoThread(std::optional<int> cpu, RealtimeStatus& status) {
  pthread_setname_np(pthread_self(), "servo");
  prctl(PR_SET_TIMERSLACK, 1UL);
  const sched_param priority{.sched_priority = kServoPriority};
  if (const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &priority); error == 0) {
    status.fifo = true;
  } else {
    status.warnings.push_back("the servo thread is not real-time" + why(error) +
                              ": other programs may delay a tick; run as root or raise the rtprio limit (ulimit -r)");
  }
  if (cpu) {
    cpu_set_t set;
    CPU_ZERO(&set);
    if (*cpu >= 0 && *cpu < CPU_SETSIZE) CPU_SET(static_cast<std::size_t>(*cpu), &set);
    if (const int error = pthread_setaffinity_np(pthread_self(), sizeof set, &set); error == 0) {
      status.pinned = true;
    } else {
      status.warnings.push_back("the servo thread is not bound to CPU " + std::to_string(*cpu) + why(error));
    }
  }
  touchStack();
}

}  // namespace haptics
