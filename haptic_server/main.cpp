#include <google/protobuf/stubs/logging.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <csignal>
#include <iostream>
#include <string_view>

#include "common/clock/monotonic.h"
#include "common/text/printable_log.h"
#include "haptic_server/doctor/doctor.h"
#include "haptic_server/options.h"
#include "haptic_server/server_app.h"

namespace haptics {
namespace {

constexpr int kExitFailed = 1;

[[nodiscard]] int fail(const Error& error) {
  spdlog::error("{}", error.text());
  return kExitFailed;
}

/// SIGINT, SIGTERM and SIGHUP, taken by the main thread alone. Blocked before any thread starts.
class StopSignals {
 public:
  StopSignals() {
    sigemptyset(&set_);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&set_, signal);
    pthread_sigmask(SIG_BLOCK, &set_, nullptr);
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is an error of its write
  }
  /// Waits for one of them, or until `deadline_ns` on the monotonic clock (0: for ever).
  void wait(std::uint64_t deadline_ns) const {
    for (;;) {
      const std::uint64_t now_ns = monotonicNow_ns();
      if (deadline_ns != 0 && now_ns >= deadline_ns) return;
      const std::uint64_t left_ns = deadline_ns == 0 ? 3600'000'000'000 : deadline_ns - now_ns;
      const timespec left{static_cast<time_t>(left_ns / 1'000'000'000), static_cast<long>(left_ns % 1'000'000'000)};
      if (sigtimedwait(&set_, nullptr, &left) > 0) return;
    }
  }

 private:
  sigset_t set_;
};

int run(const ServerOptions& options) {
  const StopSignals stopSignals;
  const auto app = ServerApp::start(options, [] { kill(getpid(), SIGTERM); });
  if (!app) return fail(app.error());
  std::cout << "listening on " << (*app)->address() << std::endl;
  stopSignals.wait(options.seconds > 0 ? monotonicNow_ns() + static_cast<std::uint64_t>(options.seconds * 1e9) : 0);
  spdlog::info("stopping");
  const auto stopped = (*app)->stop();
  return stopped ? 0 : fail(stopped.error());
}

}  // namespace
}  // namespace haptics

int main(int argc, char** argv) {
  spdlog::set_default_logger(spdlog::stderr_color_mt("haptic_server"));
  google::protobuf::SetLogHandler(nullptr);  // it would write a line for each bad string that a client sends
  spdlog::set_formatter(haptics::printableLog("%H:%M:%S.%e %^%l%$ %v"));
  if (argc > 1 && std::string_view(argv[1]) == "doctor") return haptics::runDoctor(argc - 1, argv + 1);
  const auto options = haptics::parseServerOptions(argc, argv);
  if (const int* code = std::get_if<int>(&options)) return *code;
  try {
    return haptics::run(std::get<haptics::ServerOptions>(options));
  } catch (const std::exception& e) {
    spdlog::critical("{}", e.what());
    return haptics::kExitFailed;
  }
}
