#include <google/protobuf/stubs/logging.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <atomic>
#include <csignal>
#include <iostream>
#include <thread>

#include "common/clock/monotonic.h"
#include "common/wire/convert.h"
#include "haptic_server/device/exploration_planner.h"
#include "haptic_server/device/exploring_hand.h"
#include "haptic_server/device/simulated_device.h"
#include "haptic_server/options.h"
#include "haptic_server/recorder.h"
#include "haptic_server/run_summary.h"
#include "haptic_server/scene/scene_room.h"
#include "haptic_server/servo/realtime.h"
#include "haptic_server/servo/servo_loop.h"
#include "haptic_server/state/state_folder.h"

namespace haptics {
namespace {

constexpr int kExitFailed = 1;

[[nodiscard]] int fail(const Error& error) {
  spdlog::error("{}", error.text());
  return kExitFailed;
}

/// What a person would explore in one scene after another.
[[nodiscard]] ServoSceneMaker::MakePlan explorationPlans() {
  return [planner = ExplorationPlanner()](const ServoScene& scene) mutable {
    std::vector<ExploredObject> objects;
    for (const ServoObject& object : scene.objects) {
      if (!object.leaving) objects.push_back({object.id, object.surface, object.pose});
    }
    return std::make_shared<const ExplorationPlan>(planner.plan(objects));
  };
}

[[nodiscard]] Result<void> loadScene(SceneRoom& room, const std::string& file) {
  if (file.empty()) return {};
  auto message = readSceneFile(file);
  if (!message) return tl::unexpected(message.error());
  auto transaction = fromWire(*message);
  if (!transaction) return tl::unexpected(std::move(transaction.error()).within(file + ": "));
  auto reports = room.loadStartScene(*transaction);
  if (!reports) return tl::unexpected(std::move(reports.error()).within(file + ": "));
  return {};
}

/// Goes on from the folder's state where there is one, else from the scene file, and keeps all edits there.
[[nodiscard]] Result<std::unique_ptr<StateFolder>> resumeState(SceneRoom& room, const ServerOptions& options) {
  auto opened = StateFolder::open(options.state, newEpoch(),
                                  {.info = [](const std::string& line) { spdlog::info("{}", line); },
                                   .warning = [](const std::string& line) { spdlog::warn("{}", line); }});
  if (!opened) return tl::unexpected(std::move(opened.error()).within("--state "));
  auto& folder = *opened->folder;
  const auto readMesh = [&folder](const ContentHash& hash) { return folder.readMesh(hash); };
  if (auto resumed = room.resume(std::move(opened->state), readMesh, folder); !resumed)
    return tl::unexpected(std::move(resumed.error()).within("--state " + options.state + ": "));
  if (const auto revision = room.history()->version.revision(); revision > 0) {
    spdlog::info("going on at revision {} of {}{}", revision, options.state,
                 options.scene.empty() ? "" : "; " + options.scene + " is not loaded");
  }
  return std::move(opened->folder);
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
  const std::uint64_t began_ns = monotonicNow_ns();
  const StopSignals stopSignals;
  RealtimeStatus realtime;

  const auto preset = findDevicePreset(options.devicePreset);
  const auto hand = findHandPreset(options.hand);
  if (!preset || !hand) return fail(!preset ? preset.error() : hand.error());
  if (hand->stiffness_N_per_m <= 0) spdlog::warn("--hand {}: a hand without a spring moves nothing", options.hand);
  ExploringHand exploringHand(*hand, preset->maxForce_N);
  SimulatedDevice device({*preset, *hand, 1 / options.rate_Hz}, exploringHand);

  std::optional<Recorder> recorder;
  if (!options.record.empty()) {
    auto opened = Recorder::open(options.record);
    if (!opened) return fail(opened.error());
    recorder = std::move(*opened);
  }

  const auto log = [](const std::string& line) { spdlog::info("{}", line); };
  for (const auto& folder : options.assets) spdlog::info("mesh files are looked for in {}", folder.string());
  SceneCrossing crossing;
  std::unique_ptr<StateFolder> state;  // outlives the room
  SceneRoom room({.assetFolders = options.assets, .makePlan = explorationPlans(), .log = log}, crossing);
  if (!options.state.empty()) {
    auto resumed = resumeState(room, options);
    if (!resumed) return fail(resumed.error());
    state = *std::move(resumed);
  }
  if (room.history()->version.revision() == 0) {
    if (auto loaded = loadScene(room, options.scene); !loaded) return fail(loaded.error());
  }
  room.start();

  const auto servo = std::make_unique<ServoLoop>(device, crossing, options.rate_Hz);
  const auto fillStatus = [&](v1::Status& status) {
    fillServoStatus(servo->statistics(), realtime, status);
    status.set_uptime_s(static_cast<double>(monotonicNow_ns() - began_ns) * 1e-9);
    status.set_device(device.info().name);
    status.set_durable(state != nullptr);
  };
  Server::Options serving{.listen = options.listen,
                          .credentials = {},
                          .allowInsecureLan = options.allowInsecureLan,
                          .identity = {"haptic_server", device.info().name, options.rate_Hz, device.info().maxForce_N},
                          .popTelemetry = [&](TelemetrySample& sample) { return servo->pop(sample); },
                          .recordSample = {},
                          .fillStatus = fillStatus,
                          .log = log};
  if (!options.credentials.empty()) {
    auto credentials = readServerCredentials(options.credentials);
    if (!credentials) return fail(std::move(credentials.error()).within("--credentials "));
    serving.credentials = *std::move(credentials);
  }
  if (recorder) serving.recordSample = [&](const TelemetrySample& sample) { recorder->write(sample); };
  auto server = Server::listen(std::move(serving), room);
  if (!server) return fail(server.error());

  std::atomic<bool> stop{false};
  std::atomic<bool> servoReady{false};
  lockMemory(realtime);
  const WakefulProcessors wakeful(realtime);
  std::thread servoThread([&] {
    becomeServoThread(options.cpu, realtime);
    servoReady.store(true);
    servoReady.notify_one();
    servo->run(stop);
  });
  servoReady.wait(false);
  for (const std::string& warning : realtime.warnings) spdlog::warn("{}", warning);
  (*server)->start();
  std::cout << "listening on " << options.listen.substr(0, options.listen.rfind(':')) << ':' << (*server)->port()
            << std::endl;

  stopSignals.wait(options.seconds > 0 ? monotonicNow_ns() + static_cast<std::uint64_t>(options.seconds * 1e9) : 0);
  spdlog::info("stopping");
  stop = true;
  servoThread.join();
  (*server)->stop();
  room.stop();

  if (recorder && !recorder->close()) return fail({options.record, "the recording is incomplete: is the disk full?"});
  if (!options.summary.empty()) {
    v1::Status status;
    fillStatus(status);
    const auto history = room.history();
    status.set_revision(history->version.revision());
    status.set_root(history->version.root().asBytes());
    status.set_refused_connections((*server)->counters().refusedConnections);
    if (auto written = writeSummary(options.summary, status, device.info().maxForce_N); !written)
      return fail(written.error());
  }
  return 0;
}

}  // namespace
}  // namespace haptics

int main(int argc, char** argv) {
  spdlog::set_default_logger(spdlog::stderr_color_mt("haptic_server"));
  google::protobuf::SetLogHandler(nullptr);  // it would write a line for each bad string that a client sends
  spdlog::set_pattern("%H:%M:%S.%e %^%l%$ %v");
  const auto options = haptics::parseServerOptions(argc, argv);
  if (const int* code = std::get_if<int>(&options)) return *code;
  try {
    return haptics::run(std::get<haptics::ServerOptions>(options));
  } catch (const std::exception& e) {
    spdlog::critical("{}", e.what());
    return haptics::kExitFailed;
  }
}
