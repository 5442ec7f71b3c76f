#include <sched.h>
#include <sys/prctl.h>
#include <sys/socket.h>

#include <cstdio>
#include <cstdlib>

#include "common/log/log.h"
#include "haptic_server/watchdog/watch.h"

namespace {

constexpr int kPriority = 81;  // above the servo's: a servo that computes without end must not keep it from looking

}  // namespace

int main(int argc, char** argv) {
  int type = 0;
  socklen_t size = sizeof type;
  if (argc != 3 || getsockopt(haptics::kWatchSocket, SOL_SOCKET, SO_TYPE, &type, &size) != 0) {
    std::fputs(
        "haptic_watchdog is started by haptic_server, whose devices' force it takes away when that hangs or ends\n",
        stderr);
    return 2;
  }
  prctl(PR_SET_TIMERSLACK, 1UL);
  const sched_param priority{.sched_priority = kPriority};
  sched_setscheduler(0, SCHED_FIFO, &priority);  // where the servo may be a real-time one
  haptics::logTo(stderr);
  haptics::Watch({haptics::kWatchSocket,
                  {.recordings = {argv[1], {.most_bytes = std::strtoull(argv[2], nullptr, 10)}},
                   .info = haptics::logInfo,
                   .warning = haptics::logWarning}})
      .run();
}
