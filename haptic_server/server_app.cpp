#include "haptic_server/server_app.h"

#include <atomic>
#include <chrono>
#include <utility>
#include <vector>

#include "common/clock/monotonic.h"
#include "common/log/log.h"
#include "common/telemetry/fault_words.h"
#include "haptic_server/attached_device.h"
#include "haptic_server/device/exploration_planner.h"
#include "haptic_server/device/movable_workspace.h"
#include "haptic_server/device_settings.h"
#include "haptic_server/net/server.h"
#include "haptic_server/recording/flight_recorder.h"
#include "haptic_server/run_summary.h"
#include "haptic_server/scene/scene_service.h"
#include "haptic_server/servo/servo_loop.h"
#include "haptic_server/servo_thread.h"
#include "haptic_server/start_scene.h"
#include "haptic_server/watchdog/death_notice.h"
#include "haptic_server/watchdog/watchdog.h"

namespace haptics {
namespace {

/// What takes longer than the time between two looks whether it is to end is not waited for.
constexpr std::chrono::milliseconds kBuilderEndsWithin{500};

[[nodiscard]] ServoSceneBuilder::MakePlan explorationPlans() {
  return [planner = ExplorationPlanner()](const ServoScene& scene) mutable {
    std::vector<ExploredObject> objects;
    for (const ServoObject& object : scene.objects) {
      if (!object.pendingRemoval) {
        objects.push_back({object.id, object.surface, object.pose, object.motion != nullptr});
      }
    }
    return std::make_shared<const ExplorationPlan>(planner.plan(objects));
  };
}

/// What those who watch a played recording see.
[[nodiscard]] Sequencer::Assets assetsOf(const RemadeScene& scene) {
  Sequencer::Assets assets;
  for (const ServoObjectSource& object : scene.objects) {
    if (!object.pendingRemoval) assets[object.record->id] = object.assets;
  }
  return assets;
}

static_assert(kMaxHands == kMaxLedHands);

/// Says in the log when a hand's force is taken away and comes back.
class FaultLog {
 public:
  explicit FaultLog(std::string whose) : whose_(std::move(whose)) {}

  void take(const TelemetrySample& sample) {
    if (sample.fault == std::exchange(logged_, sample.fault)) return;
    const std::string tick = "tick " + std::to_string(sample.tick) + ": " + whose_;
    if (sample.fault == Fault::kNone) {
      logInfo(tick + "forces again");
    } else {
      logError(tick + "the force is taken away: " + faultInWords(sample.fault, sample.device.fault) +
               waitInWords(sample.wait_s));
    }
  }

 private:
  const std::string whose_;
  Fault logged_ = Fault::kNone;
};

/// The second hand, where there is one.
class SecondHand final : public HandHost {
 public:
  /// @param attached, workspace  Null: its device is that of a recording.
  SecondHand(ServoHand& servo, AttachedDevice* attached, MovableWorkspace* workspace)
      : servo_(servo), attached_(attached), workspace_(workspace) {}

  [[nodiscard]] bool popTelemetry(TelemetrySample& sample) override {
    if (!servo_.pop(sample)) return false;
    faults_.take(sample);
    return true;
  }
  [[nodiscard]] const MotionState* takeMotion() override { return servo_.takeMotion(); }
  [[nodiscard]] const EnergyState* takeEnergy() override { return servo_.takeEnergy(); }
  [[nodiscard]] bool commandHand(const HandCommand& command) override {
    return attached_ != nullptr && attached_->commandHand(command);
  }
  [[nodiscard]] Result<void> moveWorkspace(const WorkspaceCommand& command) override {
    return workspace_ != nullptr ? workspace_->move(command) : HandHost::moveWorkspace(command);
  }
  [[nodiscard]] Result<void> addWrench(const Wrench& wrench) override {
    if (workspace_ == nullptr) return HandHost::addWrench(wrench);
    workspace_->add(wrench);
    return {};
  }
  void fillStatus(v1::HandStatus& status) const {
    fillHandStatus(servo_.statistics(), status);
    status.set_device(servo_.device().info().name);
    v1::Status exchange;
    if (attached_ != nullptr) attached_->fillStatus(exchange);
    if (exchange.has_device_exchange()) *status.mutable_device_exchange() = exchange.device_exchange();
  }

 private:
  ServoHand& servo_;
  AttachedDevice* const attached_;
  MovableWorkspace* const workspace_;
  FaultLog faults_{"second hand: "};
};

/// Null: there is no such device, or it is a recording.
[[nodiscard]] std::unique_ptr<MovableWorkspace> workspaceOf(AttachedDevice* attached, double rate_Hz) {
  if (attached == nullptr || attached->player() != nullptr) return nullptr;
  return std::make_unique<MovableWorkspace>(attached->device(), 1 / rate_Hz);
}

/// Device, servo, scene, network: made in the order in which they stand below, so that each outlives what uses it.
class ServerAppImpl final : public ServerApp, private ServerHost {
 public:
  ServerAppImpl(const ServerOptions& options, std::unique_ptr<AttachedDevice> device,
                std::unique_ptr<AttachedDevice> secondAttached, std::function<void()> onEnd)
      : options_(options),
        onEnd_(std::move(onEnd)),
        attached_(std::move(device)),
        secondAttached_(std::move(secondAttached)),
        player_(attached_->player()),
        rate_Hz_(player_ != nullptr ? player_->facts().rate_Hz : options.rate_Hz.value_or(kDefaultRate_Hz)),
        workspace_(workspaceOf(attached_.get(), rate_Hz_)),
        secondWorkspace_(workspaceOf(secondAttached_.get(), rate_Hz_)),
        device_(workspace_ ? *workspace_ : attached_->device()),
        step_(player_ != nullptr ? player_->facts().config : ofHands(stepConfigOf(options, device_.info(), rate_Hz_))),
        servo_(device_, mailbox_, step_) {
    if (Device* second = secondDevice()) {
      secondStep_ = player_ != nullptr ? player_->facts().secondHand->config
                                       : perHandConfig(stepConfigOf(options.ofSecondHand(), second->info(), rate_Hz_));
      servo_.addHand(*second, *secondStep_);
      secondHand_.emplace(*servo_.secondHand(), secondAttached_.get(), secondWorkspace_.get());
    }
  }
  ~ServerAppImpl() override {
    halt();  // the scene service waits for its builder
    setCrashFlag(nullptr);
  }

  [[nodiscard]] Result<void> start() {
    if (player_ == nullptr) {
      limits_ = deviceLimits();
      if (auto recording = startRecording(); !recording) return recording;
    }
    sceneService_.emplace(player_ != nullptr ? replaySceneOptions() : liveSceneOptions(), mailbox_);
    if (auto prepared = player_ != nullptr ? preparePlayer() : prepareScene(); !prepared) return prepared;
    sceneService_->start();
    if (auto listening = listen(); !listening) return listening;
    startServo();
    if (recorder_) recorder_->start();
    server_->start();
    if (state_) scrubber_ = scrubState(*sceneService_, *state_, options_.state);
    return {};
  }

  [[nodiscard]] std::string address() const override {
    if (options_.listen.empty()) return "";
    return options_.listen.substr(0, options_.listen.rfind(':')) + ':' + std::to_string(server_->port());
  }
  [[nodiscard]] std::unique_ptr<Transport> connect(EventLoop& clientLoop) override {
    return server_->connect(clientLoop);
  }
  [[nodiscard]] std::optional<AssetContent> findAsset(const AssetName& name) const override {
    const auto asset = sceneService_->findAsset(name.hash);
    if (!asset || asset->name != name) return std::nullopt;
    return asset->content();
  }
  void refreshTokens() override { server_->refreshTokens(); }

  [[nodiscard]] bool isStillBuilding() const override { return isStillBuilding_; }
  [[nodiscard]] Result<void> stop() override {
    halt();
    auto finished = finish();
    if (watchdog_) watchdog_->dismiss();  // also of a process that then ends without destructors
    return finished;
  }

 private:
  /// Null: there is one hand.
  [[nodiscard]] Device* secondDevice() {
    if (player_ != nullptr) return player_->facts().secondHand ? &player_->device(1) : nullptr;
    return secondWorkspace_.get();
  }
  [[nodiscard]] StepConfig ofHands(const StepConfig& config) const {
    return secondAttached_ ? perHandConfig(config) : config;
  }

  [[nodiscard]] Result<void> finish() {
    if (recorder_) {
      if (auto recorded = recorder_->stop(); !recorded) return recorded;
    }
    if (auto summed = writeSummary(); !summed) return summed;
    if (player_ == nullptr) return {};
    return player_->verdict().map(logInfo);
  }

  [[nodiscard]] static SceneService::Options replaySceneOptions() {
    SceneService::Options options;
    options.readOnlyReason = "the scene is that of a recording that is played";
    options.log = logInfo;
    return options;
  }
  [[nodiscard]] SceneService::Options liveSceneOptions() {
    return {.assetFolders = options_.assets,
            .makePlan = explorationPlans(),
            .takeMotion = [this] { return servo_.hand().takeMotionForBuilder(); },
            .device = limits_,
            .log = logInfo,
            .onServoScene =
                [this](const ServoScene& scene, const std::vector<ServoObjectSource>& objects) {
                  recorder_->onSceneBuilt(scene, objects);
                }};
  }

  [[nodiscard]] DeviceLimits deviceLimits() {
    const DeviceLimits first = limitsOf(options_, device_.info(), step_, rate_Hz_);
    Device* second = secondDevice();
    return second == nullptr ? first
                             : ofBoth(first, limitsOf(options_.ofSecondHand(), second->info(), *secondStep_, rate_Hz_));
  }

  [[nodiscard]] std::size_t maxRecordings_bytes() const { return options_.maxRecordings_MB * 1'000'000; }
  [[nodiscard]] Result<void> startRecording() {
    flight_.emplace(rate_Hz_, secondStep_ ? 2 : 1);
    servo_.recordInto(*flight_);
    watchdog_.emplace(Watchdog::Options{.recordings = options_.recordings,
                                        .maxRecordings_bytes = maxRecordings_bytes(),
                                        .period_s = step_.period_s,
                                        .info = logInfo,
                                        .warning = logWarning},
                      *flight_);
    attached_->setWatchdog(watchdog_->ofDevice(0));
    if (secondAttached_) secondAttached_->setWatchdog(watchdog_->ofDevice(1));
    auto recorder = FlightRecorder::open(recorderOptions(), *flight_);
    if (!recorder) return tl::unexpected(std::move(recorder.error()).within("--record "));
    recorder_ = *std::move(recorder);
    return {};
  }

  [[nodiscard]] Result<void> prepareScene() {
    for (const auto& folder : options_.assets) logInfo("mesh and image files are looked for in " + folder.string());
    if (!options_.state.empty()) {
      auto resumed = resumeState(*sceneService_, options_);
      if (!resumed) return tl::unexpected(resumed.error());
      state_ = *std::move(resumed);
    }
    if (sceneService_->history()->version.revision() == 0) return loadScene(*sceneService_, options_.scene);
    return {};
  }

  [[nodiscard]] Result<void> preparePlayer() {
    const auto show = [this](const RemadeScene& scene) { return sceneService_->show(scene.version, assetsOf(scene)); };
    if (auto prepared = player_->prepare(sceneService_->assetStore(), show); !prepared) return prepared;
    sceneService_->executeAll();  // who connects finds the scene
    if (!player_->sameStep()) logWarning("it was recorded by another version of the step: its forces may differ");
    const auto resume = [](ServoHand& hand, const RecordedBeginning& begun) {
      if (begun.state) hand.resumeFrom(*begun.state, begun.scene, begun.pending);
    };
    resume(servo_.hand(), player_->beginning());
    if (ServoHand* second = servo_.secondHand()) resume(*second, player_->beginning(1));
    return {};
  }

  [[nodiscard]] Result<void> writeSummary() {
    if (options_.summary.empty()) return {};
    v1::Status status;
    fillStatus(status);
    const auto history = sceneService_->history();
    status.set_revision(history->version.revision());
    status.set_root(history->version.root().asBytes());
    status.set_refused_connections(server_->counters().refusedConnections);
    const MotionState motion = servo_.secondHand() == nullptr
                                   ? servo_.hand().lastMotion()
                                   : ofBothHands(servo_.hand().lastMotion(), servo_.secondHand()->lastMotion());
    return haptics::writeSummary(options_.summary, status, device_.info().maxForce_N, motion,
                                 sceneService_->deformedHash(history->version, motion.dents()).value_or(ContentHash{}));
  }

  [[nodiscard]] Result<void> listen() {
    Server::Options serving{.listen = options_.listen,
                            .credentials = {},
                            .allowInsecureLan = options_.allowInsecureLan,
                            .identity = {"haptic_server", device_.info().name, rate_Hz_, device_.info().maxForce_N}};
    if (const Device* second = secondDevice()) {
      serving.identity.secondDevice = second->info().name;
      serving.identity.secondMaxForce_N = second->info().maxForce_N;
    }
    if (!options_.credentials.empty()) {
      auto credentials = readServerCredentials(options_.credentials);
      if (!credentials) return tl::unexpected(std::move(credentials.error()).within("--credentials "));
      serving.credentials = *std::move(credentials);
    }
    auto server = Server::listen(std::move(serving), *sceneService_, *this);
    if (!server) return tl::unexpected(server.error());
    server_ = *std::move(server);
    return {};
  }

  [[nodiscard]] FlightRecorder::Options recorderOptions() {
    std::optional<HandFacts> second;
    if (secondStep_) second = HandFacts{secondDevice()->info().name, *secondStep_};
    return {.facts = {.server = "haptic_server " HAPTICS_VERSION,
                      .stepSources = std::string(ownStepSources()),
                      .device = device_.info().name,
                      .rate_Hz = rate_Hz_,
                      .why = {},
                      .config = step_,
                      .secondHand = std::move(second),
                      .limits = limits_},
            .record = options_.record,
            .folder = options_.recordings,
            .quota = {.most_bytes = maxRecordings_bytes()},
            .keepScenes = [this](int descriptor) { watchdog_->keepScenes(descriptor); },
            .info = logInfo,
            .warning = logWarning,
            .checkReplay = options_.checkReplay};
  }

  void startServo() {
    servoThread_.prepare(player_ == nullptr);  // a long recording would be read whole
    attached_->start();
    if (secondAttached_) secondAttached_->start();
    servoThread_.start(options_.cpu, [this](const std::atomic<bool>& stop) {
      if (player_ == nullptr) return servo_.run(stop);
      servo_.run(*player_, stop);
      if (!stop && onEnd_) onEnd_();
    });
  }

  void halt() {
    if (sceneService_) sceneService_->endsInOrder();
    if (watchdog_) watchdog_->ending();
    servoThread_.stop();
    if (player_ != nullptr) player_->finish();
    if (server_) server_->stop();
    scrubber_.reset();
    isStillBuilding_ = sceneService_ && !sceneService_->stopWithin(kBuilderEndsWithin);
  }

  // For the server, on the network thread.
  [[nodiscard]] bool popTelemetry(TelemetrySample& sample) override {
    if (!servo_.hand().pop(sample)) return false;
    faults_.take(sample);
    return true;
  }
  [[nodiscard]] const MotionState* takeMotion() override { return servo_.hand().takeMotion(); }
  [[nodiscard]] const ShapePlaces* takeShapes() override { return servo_.hand().takeShapes(); }
  [[nodiscard]] const EnergyState* takeEnergy() override { return servo_.hand().takeEnergy(); }
  [[nodiscard]] HandHost* secondHand() override { return secondHand_ ? &*secondHand_ : nullptr; }
  [[nodiscard]] bool commandHand(const HandCommand& command) override { return attached_->commandHand(command); }
  [[nodiscard]] Result<void> moveWorkspace(const WorkspaceCommand& command) override {
    return workspace_ ? workspace_->move(command) : ServerHost::moveWorkspace(command);
  }
  [[nodiscard]] Result<void> addWrench(const Wrench& wrench) override {
    if (!workspace_) return ServerHost::addWrench(wrench);
    workspace_->add(wrench);
    return {};
  }
  [[nodiscard]] bool requestDump(const DumpAnswer& answer) override {
    if (!recorder_) {
      answer(refused("", "a recording is being played: it holds all that there is"));
      return true;
    }
    recorder_->request("on request", [answer](const Result<std::filesystem::path>& file) {
      answer(file.map([](const std::filesystem::path& path) { return std::filesystem::absolute(path).string(); }));
    });
    return true;
  }
  void fillStatus(v1::Status& status) override {
    fillServoStatus(servo_.statistics(), servo_.hand().statistics(), servoThread_.realtime(), status);
    if (secondHand_) secondHand_->fillStatus(*status.mutable_second_hand());
    status.set_uptime_s(static_cast<double>(monotonicNow_ns() - began_ns_) * 1e-9);
    status.set_device(device_.info().name);
    attached_->fillStatus(status);
    status.set_durable(state_ != nullptr);
    for (const std::string& object : sceneService_->lostParts()) status.add_lost(object);
    if (watchdog_) watchdog_->fillStatus(status);
    if (const ReplayCheck* check = recorder_ ? recorder_->check() : nullptr)
      fillReplayCheck(check->count(), *status.mutable_replay_check());
  }
  void log(const std::string& line) override { logInfo(line); }

  const ServerOptions options_;
  const std::function<void()> onEnd_;
  const std::uint64_t began_ns_ = monotonicNow_ns();
  FaultLog faults_{""};
  bool isStillBuilding_ = false;

  std::optional<FlightRing> flight_;  // none while a recording is played, like the watchdog and the recorder
  std::optional<Watchdog> watchdog_;  // takes the force of the device away
  std::unique_ptr<AttachedDevice> attached_, secondAttached_;  // none for the second hand of a recording
  RecordingPlayer* const player_;                              // null unless the device is one
  const double rate_Hz_;
  const std::unique_ptr<MovableWorkspace> workspace_, secondWorkspace_;  // none while a recording is played
  Device& device_;
  const StepConfig step_;
  std::optional<StepConfig> secondStep_;  // where there is a second hand
  DeviceLimits limits_;                   // of the devices
  SceneMailbox mailbox_;
  ServoLoop servo_;
  std::optional<SecondHand> secondHand_;
  std::unique_ptr<FlightRecorder> recorder_;  // takes the scenes that the service builds
  std::unique_ptr<StateFolder> state_;        // keeps the edits that the service accepts
  std::optional<SceneService> sceneService_;
  ServoThread servoThread_;
  std::unique_ptr<Server> server_;
  std::unique_ptr<StateScrubber> scrubber_;
};

}  // namespace

Result<std::unique_ptr<ServerApp>> ServerApp::start(const ServerOptions& options, std::function<void()> onEnd) {
  auto device = AttachedDevice::attach(options);
  if (!device) return tl::unexpected(device.error());
  std::unique_ptr<AttachedDevice> second;
  if (options.secondHand) {
    auto attached = AttachedDevice::attach(options.ofSecondHand());
    if (!attached) return tl::unexpected(std::move(attached.error()).within("second hand: "));
    second = *std::move(attached);
  }
  auto app = std::make_unique<ServerAppImpl>(options, *std::move(device), std::move(second), std::move(onEnd));
  if (auto started = app->start(); !started) return tl::unexpected(started.error());
  return app;
}

}  // namespace haptics
