#pragma once

#include <atomic>
#include <memory>
#include <thread>
#include <utility>

#include "haptic_server/net/server.h"
#include "haptic_server/scene/scene_service.h"
#include "haptic_server/servo/servo_loop.h"
#include "tests/eval/table1/recorded_hand.h"

namespace haptics::eval {

/// The rooms of the real server around one object: scene room, network thread, and the servo loop, flat out.
class FlatOutServer final : private ServerHost {
 public:
  /// Starts with the mesh. Throws std::runtime_error when something refuses.
  explicit FlatOutServer(const TriMesh& mesh);
  ~FlatOutServer() override { stop(); }

  /// Gives the object another mesh, as a client would; returns the revision when the servo feels it. The hand is away meanwhile.
  std::uint64_t show(const TriMesh& mesh);
  void stop();  ///< Of the servo loop; the viewer stays connected.

  [[nodiscard]] std::uint16_t port() const noexcept { return server_->port(); }
  [[nodiscard]] std::uint64_t revision() const { return sceneService_->history()->version.revision(); }
  [[nodiscard]] const ServoStatistics& statistics() const noexcept { return servo_->statistics(); }
  [[nodiscard]] const HandStatistics& handStatistics() const noexcept {
    return std::as_const(*servo_).hand().statistics();
  }
  /// Of the servo thread while it runs: what others take of the machine does not count.
  [[nodiscard]] double processorTime_s();
  [[nodiscard]] const RecordedHand& hand() const noexcept { return hand_; }

 private:
  [[nodiscard]] bool popTelemetry(TelemetrySample& sample) override { return servo_->hand().pop(sample); }
  void apply(Operation operation);
  std::shared_ptr<const Asset> upload(const TriMesh& mesh);

  RecordedHand hand_;
  SceneMailbox mailbox_;
  std::unique_ptr<SceneService> sceneService_;
  std::unique_ptr<ServoLoop> servo_;
  std::unique_ptr<Server> server_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
  std::uint64_t edits_ = 0;
};

}  // namespace haptics::eval
