#include <google/protobuf/stubs/logging.h>
#include <sys/time.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <iostream>
#include <semaphore>
#include <stop_token>
#include <string_view>
#include <thread>

#include "common/clock/monotonic.h"
#include "common/interruption/interruption.h"
#include "common/log/log.h"
#include "haptic_server/check_device.h"
#include "haptic_server/doctor/doctor.h"
#include "haptic_server/options.h"
#include "haptic_server/server_app.h"
#include "haptic_server/servo/realtime.h"

namespace haptics {
namespace {

constexpr int kExitFailed = 1;
/// From the signal on, whatever a plug-in, an importer or a disk does; what is promised is 2 s, on a busy machine too.
constexpr std::chrono::milliseconds kEndsWithin{1500};

[[nodiscard]] int fail(const Error& error) {
  logError(error.text());
  return kExitFailed;
}

/// SIGINT, SIGTERM and SIGHUP, taken where they are waited for. Blocked before any thread starts.
class StopSignals {
 public:
  StopSignals() {
    sigemptyset(&set_);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&set_, signal);
    pthread_sigmask(SIG_BLOCK, &set_, nullptr);
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is an error of its write
  }
  /// Waits for one of them, which it returns, or until `deadline_ns` on the monotonic clock (0: for ever): 0.
  [[nodiscard]] int wait(std::uint64_t deadline_ns) const {
    for (;;) {
      const std::uint64_t now_ns = monotonicNow_ns();
      if (deadline_ns != 0 && now_ns >= deadline_ns) return 0;
      const std::uint64_t left_ns = deadline_ns == 0 ? 3600'000'000'000 : deadline_ns - now_ns;
      const timespec left{static_cast<time_t>(left_ns / 1'000'000'000), static_cast<long>(left_ns % 1'000'000'000)};
      if (const int signal = sigtimedwait(&set_, nullptr, &left); signal > 0) return signal;
    }
  }

 private:
  sigset_t set_;
};

std::atomic<int> codeIfLate{kExitFailed};

std::binary_semaphore endsSoon{0};

/// Ends the process kEndsWithin from endSoon() on as it is; the watchdog then takes the force away. Begun before all else:
/// no thread begins while a plug-in that is being loaded does not return.
void startLastResort() {
  std::thread([] {
    endsSoon.acquire();
    std::this_thread::sleep_for(kEndsWithin);
    std::signal(SIGALRM, [](int) { std::_Exit(codeIfLate); });
    constexpr itimerval kForTheLog{.it_interval = {}, .it_value = {.tv_sec = 0, .tv_usec = 75'000}};
    setitimer(ITIMER_REAL, &kForTheLog, nullptr);  // which may be what does not end
    logError("something does not end: the server goes without waiting for it");
    std::_Exit(codeIfLate);
  }).detach();
}

void endSoon() { endsSoon.release(); }

bool rereadsTokens(int signal, const ServerOptions& options) {
  return signal == SIGHUP && !options.credentials.empty();
}

/// Ends early by the signals, for files may take long to import. `early` says whether one came.
Result<std::unique_ptr<ServerApp>> startServer(const ServerOptions& options, const StopSignals& signals,
                                               std::stop_source& early) {
  constexpr std::uint64_t kLookEvery_ns = 10'000'000;
  const std::jthread watch([&](const std::stop_token& started) {
    while (!started.stop_requested() && !early.stop_requested()) {
      const int signal = signals.wait(monotonicNow_ns() + kLookEvery_ns);
      if (signal == 0 || rereadsTokens(signal, options)) continue;
      endSoon();
      early.request_stop();
    }
  });
  const Interruptible work(early.get_token());
  return ServerApp::start(options, [] { kill(getpid(), SIGTERM); });
}

int run(const ServerOptions& options) {
  const StopSignals stopSignals;
  startLastResort();
  std::stop_source early;
  const auto app = startServer(options, stopSignals, early);
  if (!app) return early.stop_requested() ? 0 : fail(app.error());
  std::cout << "listening on " << (*app)->address() << std::endl;
  if (!early.stop_requested()) {
    const std::uint64_t end_ns =
        options.seconds > 0 ? monotonicNow_ns() + static_cast<std::uint64_t>(options.seconds * 1e9) : 0;
    int signal = 0;
    while (rereadsTokens(signal = stopSignals.wait(end_ns), options)) (*app)->refreshTokens();
    if (signal != 0) endSoon();
  }
  logInfo("stopping");
  const auto stopped = (*app)->stop();
  const int code = stopped ? 0 : fail(stopped.error());
  codeIfLate = code;
  if ((*app)->isStillBuilding()) std::_Exit(code);
  return code;
}

}  // namespace
}  // namespace haptics

int main(int argc, char** argv) {
  haptics::logTo(stderr);
  haptics::keepStacksSmall();
  google::protobuf::SetLogHandler(nullptr);  // it would write a line for each bad string that a client sends
  if (argc > 1 && std::string_view(argv[1]) == "doctor") return haptics::runDoctor(argc - 1, argv + 1);
  if (argc > 1 && std::string_view(argv[1]) == "check-device") return haptics::runCheckDevice(argc - 1, argv + 1);
  const auto options = haptics::parseServerOptions(argc, argv);
  if (const int* code = std::get_if<int>(&options)) return *code;
  try {
    return haptics::run(std::get<haptics::ServerOptions>(options));
  } catch (const std::exception& e) {
    haptics::logError(e.what());
    return haptics::kExitFailed;
  }
}
