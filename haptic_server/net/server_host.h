#pragma once

#include <functional>
#include <string>

#include "common/error/error.h"
#include "common/telemetry/added_wrench.h"
#include "common/telemetry/energy_state.h"
#include "common/telemetry/hand_command.h"
#include "common/telemetry/motion_state.h"
#include "common/telemetry/telemetry_sample.h"
#include "haptic_server/engine/step/kinematic_motion.h"
#include "haptics/v1/envelope.pb.h"

namespace haptics {

/// One hand of the servo, as a server needs it. Called on the network thread only, or by Server::stop() once that has
/// ended.
class HandHost {
 public:
  virtual ~HandHost() = default;
  /// Takes the oldest sample of the servo's queue. False: it is empty.
  [[nodiscard]] virtual bool popTelemetry(TelemetrySample& sample) = 0;
  /// Where the objects that move are; null when nothing has changed since the last call. By default nothing moves.
  [[nodiscard]] virtual const MotionState* takeMotion() { return nullptr; }
  /// Where shapes that are driven are, likewise. By default none are.
  [[nodiscard]] virtual const ShapePlaces* takeShapes() { return nullptr; }
  /// Energy that the objects gave the hand; null when nothing has changed since the last call. By default null.
  [[nodiscard]] virtual const EnergyState* takeEnergy() { return nullptr; }

  /// Of the client that leads the simulated hand, or that none leads it. False, as by default: no hand can be led.
  [[nodiscard]] virtual bool commandHand([[maybe_unused]] const HandCommand& command) { return false; }

  /// Of the hand's device. Refused, as by default: its workspace cannot be moved.
  [[nodiscard]] virtual Result<void> moveWorkspace([[maybe_unused]] const WorkspaceCommand& command) {
    return refused("set_workspace.hand", "its device is a recording");
  }
  /// Refused, as by default: nothing can be added to its force.
  [[nodiscard]] virtual Result<void> addWrench([[maybe_unused]] const Wrench& wrench) {
    return refused("add_wrench.hand", "its device is a recording");
  }
};

/// Interface of a server to its program: the servo's mailboxes, a recorder, a log. It is the first hand itself.
/// Called as a HandHost is.
class ServerHost : public HandHost {
 public:
  /// Null, as by default: there is one hand. A sample of the first hand finds that of the same tick in its queue.
  [[nodiscard]] virtual HandHost* secondHand() { return nullptr; }

  /// With the file, or why there is none. Called once, on any thread.
  using DumpAnswer = std::function<void(const Result<std::string>& file)>;
  /// Records the last seconds. False, as by default: this program keeps none, and no answer follows.
  [[nodiscard]] virtual bool requestDump([[maybe_unused]] const DumpAnswer& answer) { return false; }

  /// Adds servo, device and uptime to a Status.
  virtual void fillStatus([[maybe_unused]] v1::Status& status) {}
  virtual void log([[maybe_unused]] const std::string& line) {}
};

}  // namespace haptics
