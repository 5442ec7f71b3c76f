#include "haptic_server/server_app.h"

#include <spdlog/spdlog.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <optional>
#include <thread>
#include <utility>

#include "common/clock/monotonic.h"
#include "common/telemetry/fault_words.h"
#include "common/wire/convert.h"
#include "haptic_server/attached_device.h"
#include "haptic_server/device/exploration_planner.h"
#include "haptic_server/net/server.h"
#include "haptic_server/recording/flight_recorder.h"
#include "haptic_server/run_summary.h"
#include "haptic_server/scene/scene_room.h"
#include "haptic_server/servo/realtime.h"
#include "haptic_server/servo/servo_loop.h"
#include "haptic_server/state/state_folder.h"
#include "haptic_server/state/state_scrubber.h"
#include "haptic_server/surface_limits_cache.h"
#include "haptic_server/watchdog/watchdog.h"

namespace haptics {
namespace {

/// What takes longer than the time between two looks whether it is to end is not waited for.
constexpr std::chrono::milliseconds kBuilderEndsWithin{500};

void logInfo(const std::string& line) { spdlog::info("{}", line); }
void logWarning(const std::string& line) { spdlog::warn("{}", line); }

/// What a person would explore in one scene after another.
[[nodiscard]] ServoSceneMaker::MakePlan explorationPlans() {
  return [planner = ExplorationPlanner()](const ServoScene& scene) mutable {
    std::vector<ExploredObject> objects;
    for (const ServoObject& object : scene.objects) {
      if (!object.leaving) {
        objects.push_back({object.id, object.surface, object.pose, object.motion != nullptr});
      }
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
  auto opened = StateFolder::open(options.state, newEpoch(), {.info = logInfo, .warning = logWarning});
  if (!opened) return tl::unexpected(std::move(opened.error()).within("--state "));
  auto& folder = *opened->folder;
  const auto readAsset = [&folder](const ContentHash& hash) { return folder.readAsset(hash); };
  for (const std::string& remark : room.resume(std::move(opened->state), readAsset, folder)) {
    spdlog::warn("--state {}: {}", options.state, remark);
  }
  if (const auto revision = room.history()->version.revision(); revision > 0) {
    spdlog::info("going on at revision {} of {}{}", revision, options.state,
                 options.scene.empty() ? "" : "; " + options.scene + " is not loaded");
  }
  return std::move(opened->folder);
}

/// The delay as the command line has it where that says more than the driver.
[[nodiscard]] DeviceInfo deviceInfoOf(const ServerOptions& options, DeviceInfo device) {
  constexpr double kMillisecond_s = 1e-3;
  if (options.deviceDelay_ms) device.delay_s = *options.deviceDelay_ms * kMillisecond_s;
  return device;
}

[[nodiscard]] StepConfig stepConfigOf(const ServerOptions& options, const DeviceInfo& device, double rate_Hz) {
  StepConfig config = serverStepConfig(deviceInfoOf(options, device), rate_Hz);
  if (!options.stabiliser) config.lead.reset();
  return config;
}

/// What those who watch a played recording see.
[[nodiscard]] Sequencer::Assets assetsOf(const RemadeScene& scene) {
  Sequencer::Assets assets;
  for (const ServoObjectParts& object : scene.objects) {
    if (!object.leaving) assets[object.record->id] = object.assets;
  }
  return assets;
}

[[nodiscard]] SurfaceLimits surfaceLimitsOf(const ServerOptions& options, const DeviceInfo& device, double rate_Hz) {
  const std::uint64_t began_ns = monotonicNow_ns();
  const auto [limits, searched] =
      SurfaceLimitsCache(SurfaceLimitsCache::userFolder()).find(device, rate_Hz, options.stabiliser);
  spdlog::info("surfaces are felt with at most {:.5g} N/m and {:.3g} Ns/m: {} in {:.0f} ms", limits.stiffness_N_per_m,
               limits.damping_Ns_per_m, searched ? "found" : "read",
               static_cast<double>(monotonicNow_ns() - began_ns) * 1e-6);
  if (limits.stiffness_N_per_m == 0) {
    spdlog::warn(
        "no surface is felt: by simulation this device comes to rest on no wall at this rate and delay; less delay, a "
        "higher rate or the stabiliser may help");
  }
  return limits;
}

[[nodiscard]] DeviceLimits limitsOf(const ServerOptions& options, const DeviceInfo& info, const StepConfig& step,
                                    double rate_Hz) {
  const SurfaceLimits limits = surfaceLimitsOf(options, deviceInfoOf(options, info), rate_Hz);
  return {step.positionStep_m, step.stableLateral_N_per_m, step.period_s, limits.stiffness_N_per_m,
          limits.damping_Ns_per_m};
}

}  // namespace

class ServerApp::Impl {
 public:
  Impl(const ServerOptions& options, std::unique_ptr<AttachedDevice> device, std::function<void()> onEnd)
      : options_(options),
        onEnd_(std::move(onEnd)),
        attached_(std::move(device)),
        device_(attached_->device()),
        player_(attached_->player()),
        rate_Hz_(player_ != nullptr ? player_->facts().rate_Hz : options.rate_Hz.value_or(kDefaultRate_Hz)),
        step_(player_ != nullptr ? player_->facts().config : stepConfigOf(options, device_.info(), rate_Hz_)),
        room_(roomOptions(), crossing_) {}
  ~Impl() { halt(); }  // the room waits for its builder

  [[nodiscard]] Result<void> start() {
    servo_ = std::make_unique<ServoLoop>(device_, crossing_, step_);
    if (auto prepared = player_ != nullptr ? preparePlayer() : prepareScene(); !prepared) return prepared;
    room_.start();
    if (auto listening = listen(); !listening) return listening;
    startServo();
    if (recorder_) recorder_->start();
    server_->start();
    startScrubber();
    return {};
  }

  [[nodiscard]] std::string address() const {
    if (options_.listen.empty()) return "";
    return options_.listen.substr(0, options_.listen.rfind(':')) + ':' + std::to_string(server_->port());
  }
  [[nodiscard]] std::unique_ptr<Transport> connect(EventLoop& clientLoop) { return server_->connect(clientLoop); }
  [[nodiscard]] std::optional<AssetContent> findAsset(const AssetName& name) const {
    const auto asset = room_.findAsset(name.hash);
    if (!asset || asset->name != name) return std::nullopt;
    return asset->content();
  }
  void refreshTokens() { server_->refreshTokens(); }

  [[nodiscard]] bool isStillBuilding() const noexcept { return isStillBuilding_; }
  [[nodiscard]] Result<void> stop() {
    halt();
    auto finished = finish();
    if (watchdog_) watchdog_->dismiss();  // also of a process that then ends without destructors
    return finished;
  }

 private:
  [[nodiscard]] Result<void> finish() {
    if (recorder_) {
      if (auto recorded = recorder_->stop(); !recorded) return recorded;
    }
    if (auto summed = writeSummary(); !summed) return summed;
    if (player_ == nullptr) return {};
    const auto verdict = player_->verdict();
    if (!verdict) return tl::unexpected(verdict.error());
    spdlog::info("{}", *verdict);
    return {};
  }

  [[nodiscard]] SceneRoom::Options roomOptions() {
    if (player_ != nullptr)
      return {.assetFolders = {},
              .makePlan = {},
              .whyFixed = "the scene is that of a recording that is played",
              .log = logInfo};
    return {.assetFolders = options_.assets,
            .makePlan = explorationPlans(),
            .takeMotion = [this] { return servo_->takeMotionForBuilder(); },
            .device = limitsOf(options_, device_.info(), step_, rate_Hz_),
            .log = logInfo,
            .onServoScene = [this](const ServoScene& scene,
                                   const std::vector<ServoObjectParts>& objects) { recorder_->given(scene, objects); }};
  }

  /// Of a device that is felt: flight recorder and watchdog, and the scene from the state's folder or a file.
  [[nodiscard]] Result<void> prepareScene() {
    flight_.emplace(rate_Hz_, step_);
    servo_->recordInto(*flight_);
    watchdog_.emplace(
        Watchdog::Options{
            .recordings = options_.recordings, .period_s = step_.period_s, .info = logInfo, .warning = logWarning},
        *flight_);
    attached_->setWatchdog(*watchdog_);
    auto recorder = FlightRecorder::open(recorderOptions(), *flight_);
    if (!recorder) return tl::unexpected(std::move(recorder.error()).within("--record "));
    recorder_ = *std::move(recorder);
    for (const auto& folder : options_.assets)
      spdlog::info("mesh and image files are looked for in {}", folder.string());
    if (!options_.state.empty()) {
      auto resumed = resumeState(room_, options_);
      if (!resumed) return tl::unexpected(resumed.error());
      state_ = *std::move(resumed);
    }
    if (room_.history()->version.revision() == 0) return loadScene(room_, options_.scene);
    return {};
  }

  [[nodiscard]] Result<void> preparePlayer() {
    const auto show = [this](const RemadeScene& scene) { return room_.show(scene.version, assetsOf(scene)); };
    if (auto prepared = player_->prepare(room_.assetStore(), show); !prepared) return prepared;
    if (!player_->sameStep()) spdlog::warn("it was recorded by another version of the step: its forces may differ");
    const RecordedBeginning& begun = player_->beginning();
    if (begun.state) servo_->goOnFrom(*begun.state, begun.scene, begun.pending);
    return {};
  }

  [[nodiscard]] Result<void> writeSummary() {
    if (options_.summary.empty()) return {};
    v1::Status status;
    fillStatus(status);
    const auto history = room_.history();
    status.set_revision(history->version.revision());
    status.set_root(history->version.root().asBytes());
    status.set_refused_connections(server_->counters().refusedConnections);
    const MotionState& motion = servo_->lastMotion();
    return haptics::writeSummary(options_.summary, status, device_.info().maxForce_N, motion,
                                 room_.deformedHash(history->version, motion.dents()).value_or(ContentHash{}));
  }

  [[nodiscard]] Result<void> listen() {
    Server::Options serving{.listen = options_.listen,
                            .credentials = {},
                            .allowInsecureLan = options_.allowInsecureLan,
                            .identity = {"haptic_server", device_.info().name, rate_Hz_, device_.info().maxForce_N},
                            .popTelemetry =
                                [this](TelemetrySample& sample) {
                                  if (!servo_->pop(sample)) return false;
                                  logFault(sample);
                                  return true;
                                },
                            .takeMotion = [this] { return servo_->takeMotion(); },
                            .takeEnergy = [this] { return servo_->takeEnergy(); },
                            .dump = [this](auto answer) { dump(std::move(answer)); },
                            .fillStatus = [this](v1::Status& status) { fillStatus(status); },
                            .log = logInfo};
    if (!options_.credentials.empty()) {
      auto credentials = readServerCredentials(options_.credentials);
      if (!credentials) return tl::unexpected(std::move(credentials.error()).within("--credentials "));
      serving.credentials = *std::move(credentials);
    }
    auto server = Server::listen(std::move(serving), room_);
    if (!server) return tl::unexpected(server.error());
    server_ = *std::move(server);
    return {};
  }

  [[nodiscard]] FlightRecorder::Options recorderOptions() {
    return {.facts = {.server = "haptic_server " HAPTICS_VERSION,
                      .stepSources = std::string(ownStepSources()),
                      .device = device_.info().name,
                      .rate_Hz = rate_Hz_,
                      .why = {},
                      .config = step_},
            .record = options_.record,
            .folder = options_.recordings,
            .quota = {.most_bytes = options_.recordingsMost_MB * 1'000'000},
            .keepScenes = [this](int descriptor) { watchdog_->keepScenes(descriptor); },
            .info = logInfo,
            .warning = logWarning};
  }

  void dump(std::function<void(const Result<std::string>&)> answer) {
    if (!recorder_) return answer(refused("", "a recording is being played: it holds all that there is"));
    recorder_->request("on request", [answer = std::move(answer)](const Result<std::filesystem::path>& file) {
      answer(file.map([](const std::filesystem::path& path) { return std::filesystem::absolute(path).string(); }));
    });
  }

  void startServo() {
    if (player_ == nullptr) lockMemory(realtime_);  // a long recording would be read whole
    wakeful_.emplace(realtime_);
    attached_->start();
    servoThread_ = std::thread([this] {
      becomeServoThread(options_.cpu, realtime_);
      servoReady_.store(true);
      servoReady_.notify_one();
      if (player_ == nullptr) return servo_->run(stop_);
      servo_->run(*player_, stop_);
      if (!stop_ && onEnd_) onEnd_();
    });
    servoReady_.wait(false);
    if (realtime_.memoryLocked) lockMemoryAsItIsWritten();
    for (const std::string& warning : realtime_.warnings) spdlog::warn("{}", warning);
  }

  void halt() {
    if (watchdog_) watchdog_->ending();
    stop_ = true;
    if (servoThread_.joinable()) servoThread_.join();
    if (player_ != nullptr) player_->finish();
    if (server_) server_->stop();
    scrubber_.reset();
    isStillBuilding_ = !room_.stopWithin(kBuilderEndsWithin);
  }

  /// Of a scene that is kept: its files are re-read now and then, and written anew from memory where they are damaged.
  void startScrubber() {
    if (!state_) return;
    const auto named = [this] {
      std::vector<ContentHash> assets;
      const auto history = room_.history();
      for (const auto& object : history->version.objects()) {
        for (const AssetName& asset : object->assets()) assets.push_back(asset.hash);
      }
      return assets;
    };
    const auto repair = [this](const std::filesystem::path& file, const std::optional<ContentHash>& asset) {
      spdlog::warn("{} is damaged or missing; it is written anew from memory", file.string());
      return room_.checkpoint([this, asset] {
        if (asset) state_->distrust(*asset);
      });
    };
    scrubber_ = std::make_unique<StateScrubber>(StateScrubber::Options{options_.state, named, repair});
  }

  /// Network thread.
  void logFault(const TelemetrySample& sample) {
    if (sample.fault == loggedFault_) return;
    loggedFault_ = sample.fault;
    if (sample.fault == Fault::kNone) {
      spdlog::info("tick {}: forces again", sample.tick);
    } else {
      spdlog::error("tick {}: the force is taken away: {}{}", sample.tick,
                    faultInWords(sample.fault, sample.device.fault), waitInWords(sample.wait_s));
    }
  }

  void fillStatus(v1::Status& status) const {
    fillServoStatus(servo_->statistics(), realtime_, status);
    status.set_uptime_s(static_cast<double>(monotonicNow_ns() - began_ns_) * 1e-9);
    status.set_device(device_.info().name);
    attached_->fillStatus(status);
    status.set_durable(state_ != nullptr);
    for (const std::string& object : room_.lostParts()) status.add_lost(object);
    if (watchdog_) watchdog_->fillStatus(status);
  }

  const ServerOptions options_;
  const std::function<void()> onEnd_;
  const std::uint64_t began_ns_ = monotonicNow_ns();
  RealtimeStatus realtime_;
  std::optional<WakefulProcessors> wakeful_;
  std::optional<Watchdog> watchdog_;  // outlives the device, whose force it takes away
  std::unique_ptr<AttachedDevice> attached_;
  Device& device_;
  RecordingPlayer* const player_;  // null unless the device is one
  const double rate_Hz_;
  StepConfig step_;
  SceneCrossing crossing_;
  std::unique_ptr<StateFolder> state_;  // outlives the room
  std::unique_ptr<ServoLoop> servo_;
  std::optional<FlightRing> flight_;
  std::unique_ptr<FlightRecorder> recorder_;  // outlives the room, which tells it of its scenes
  SceneRoom room_;
  std::unique_ptr<Server> server_;
  std::unique_ptr<StateScrubber> scrubber_;
  Fault loggedFault_ = Fault::kNone;
  std::atomic<bool> servoReady_{false};
  std::atomic<bool> stop_{false};
  bool isStillBuilding_ = false;
  std::thread servoThread_;
};

ServerApp::ServerApp(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ServerApp::~ServerApp() = default;

Result<std::unique_ptr<ServerApp>> ServerApp::start(const ServerOptions& options, std::function<void()> onEnd) {
  auto device = AttachedDevice::attach(options);
  if (!device) return tl::unexpected(device.error());
  auto impl = std::make_unique<Impl>(options, *std::move(device), std::move(onEnd));
  if (auto started = impl->start(); !started) return tl::unexpected(started.error());
  return std::unique_ptr<ServerApp>(new ServerApp(std::move(impl)));
}

void ServerApp::refreshTokens() { impl_->refreshTokens(); }
std::string ServerApp::address() const { return impl_->address(); }
std::unique_ptr<Transport> ServerApp::connect(EventLoop& clientLoop) { return impl_->connect(clientLoop); }
std::optional<AssetContent> ServerApp::findAsset(const AssetName& name) const { return impl_->findAsset(name); }
Result<void> ServerApp::stop() { return impl_->stop(); }
bool ServerApp::isStillBuilding() const { return impl_->isStillBuilding(); }

}  // namespace haptics
