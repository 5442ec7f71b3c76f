#include "tests/eval/table1/flat_out_server.h"

#include <pthread.h>

#include <chrono>
#include <ctime>
#include <future>
#include <stdexcept>

#include "common/mesh/mesh_asset.h"
#include "tests/eval/or_throw.h"

namespace haptics::eval {
namespace {

constexpr const char* kObject = "object";
constexpr SessionId kSession = 1;
constexpr double kStiffness_N_per_m = 1000;
constexpr double kNominalRate_Hz = 1000;  // of the recording; the loop does not wait for it

}  // namespace

FlatOutServer::FlatOutServer(const TriMesh& mesh)
    : sceneService_(std::make_unique<SceneService>(SceneService::Options{}, mailbox_)),
      servo_(std::make_unique<ServoLoop>(hand_, mailbox_, kNominalRate_Hz, false)) {
  sceneService_->start();
  const auto asset = upload(mesh);
  apply(AddObject{kObject, {AssetSource{asset->name.hash}}, {}, {kStiffness_N_per_m, {}, {}}});
  Server::Options options;
  options.identity = {"haptic_eval", hand_.info().name, kNominalRate_Hz, hand_.info().maxForce_N};
  server_ = orThrow(Server::listen(std::move(options), *sceneService_, *this));
  server_->start();
  thread_ = std::thread([this] { servo_->runFlatOut(stop_); });
}

double FlatOutServer::processorTime_s() {
  clockid_t clock;
  timespec time;
  if (pthread_getcpuclockid(thread_.native_handle(), &clock) != 0 || clock_gettime(clock, &time) != 0) return 0;
  return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec) * 1e-9;
}

std::uint64_t FlatOutServer::show(const TriMesh& mesh) {
  using namespace std::chrono_literals;
  const auto asset = upload(mesh);
  hand_.setAway(true);
  constexpr int kTicksAway = 100;  // to lift off and be free
  const std::uint64_t before = statistics().ticks;
  while (statistics().ticks < before + kTicksAway) std::this_thread::sleep_for(1ms);
  apply(RemeshObject{{kObject}, {AssetSource{asset->name.hash}}});
  while (statistics().adoptedRevision != revision()) std::this_thread::sleep_for(1ms);
  hand_.setAway(false);
  return revision();
}

void FlatOutServer::stop() {
  stop_ = true;
  if (thread_.joinable()) thread_.join();
}

std::shared_ptr<const Asset> FlatOutServer::upload(const TriMesh& mesh) {
  std::promise<Result<std::shared_ptr<const Asset>>> built;
  const AssetName name{AssetKind::kMesh, hashOf(mesh)};
  if (!sceneService_->submitAsset(kSession, name, encodeMesh(mesh),
                                  [&](auto asset) { built.set_value(std::move(asset)); })) {
    throw std::runtime_error("the builder is busy");
  }
  return orThrow(built.get_future().get());
}

void FlatOutServer::apply(Operation operation) {
  std::promise<EditOutcome> outcome;
  if (!sceneService_->submitEdit(kSession, ++edits_, Transaction{{}, {std::move(operation)}},
                                 [&](const EditOutcome& answer) { outcome.set_value(answer); })) {
    throw std::runtime_error("the builder is busy");
  }
  const EditOutcome answer = outcome.get_future().get();
  if (const auto* error = std::get_if<Error>(&answer)) throw std::runtime_error(error->text());
}

}  // namespace haptics::eval
