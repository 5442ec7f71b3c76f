#include <algorithm>
#include <chrono>
#include <cstdio>
#include <optional>
#include <string>
#include <thread>

#include "common/telemetry/fault_words.h"
#include "graphics_client/script/interrupt.h"
#include "graphics_client/script/verbs.h"

namespace haptics {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kEach{20};     // the server lets go 0.1 s after the last one
constexpr std::chrono::seconds kLongestFading{5};  // a force as large as may be is gone in 3.4 s
constexpr double kRate_Hz = 100;

/// What the hand had of it.
struct Pushed {
  Vec3 added_N{0};      ///< The largest.
  double force_N = 0;   ///< Largest of all that was written to the device.
  double moved_mm = 0;  ///< Farthest from where it was.
  Fault fault = Fault::kNone;
  DeviceFault deviceFault{};
};

class Push {
 public:
  Push(ServerLink& link, const PushOptions& options) : link_(link), options_(options), hand_(options.hand - 1U) {}

  /// As long as was asked for, or until a fault, Ctrl-C, or the connection's end.
  void run() {
    const Interrupt interrupt;
    const auto end =
        Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(options_.duration_s));
    while (Clock::now() < end && !Interrupt::interrupted() && look() && pushed_.fault == Fault::kNone) {
      link_.addWrench(hand_, options_.wrench);
      std::this_thread::sleep_for(std::min<Clock::duration>(kEach, end - Clock::now()));
    }
    const auto patience = Clock::now() + kLongestFading;
    do {
      link_.addWrench(hand_, {});
      std::this_thread::sleep_for(kEach);
    } while (look() && now_N_ != Vec3(0) && Clock::now() < patience);
    wasInterrupted_ = Interrupt::interrupted();
  }
  [[nodiscard]] const Pushed& pushed() const { return pushed_; }
  [[nodiscard]] bool wasInterrupted() const { return wasInterrupted_; }

 private:
  ServerLink& link_;
  const PushOptions& options_;
  std::size_t hand_;
  Pushed pushed_;
  Vec3 now_N_{0};
  std::optional<Vec3> began_m_;
  bool wasInterrupted_ = false;

  /// False: there is no connection.
  bool look() {
    const auto view = link_.latest();
    if (view->link != LinkState::kLive) return false;
    const TelemetrySample* felt = view->felt(hand_);
    if (felt == nullptr) return true;
    if (!began_m_) began_m_ = felt->hip;
    now_N_ = felt->added_N;
    if (squaredLength(now_N_) > squaredLength(pushed_.added_N)) pushed_.added_N = now_N_;
    pushed_.force_N = std::max(pushed_.force_N, glm::length(felt->force.written));
    pushed_.moved_mm = std::max(pushed_.moved_mm, 1e3 * glm::length(felt->hip - *began_m_));
    if (felt->fault != Fault::kNone) {
      pushed_.fault = felt->fault;
      pushed_.deviceFault = felt->device.fault;
    }
    return true;
  }
};

void print(const Pushed& pushed, bool json) {
  const Vec3& added_N = pushed.added_N;
  if (json) {
    std::printf("{\"added_N\": [%.6g, %.6g, %.6g], \"force_N\": %.6g, \"moved_mm\": %.6g}\n", added_N.x, added_N.y,
                added_N.z, pushed.force_N, pushed.moved_mm);
  } else {
    std::printf("added up to %.2f N (%.2f %.2f %.2f); the device got up to %.2f N, and the hand moved by %.1f mm\n",
                glm::length(added_N), added_N.x, added_N.y, added_N.z, pushed.force_N, pushed.moved_mm);
  }
}

}  // namespace

int push(const CommonOptions& common, const PushOptions& options) {
  Connection connection(common, {.telemetryRate_Hz = kRate_Hz});
  const auto view = connection.open();
  if (!view) return fail(kNoConnection, view.error());
  if (!(*view)->mayEdit)
    return fail(kRefused, {"push", "the server takes a force from an editor alone (--credentials)"});
  Push run(connection.link(), options);
  run.run();
  const auto now = connection.link().latest();
  if (now->link != LinkState::kLive) return fail(kNoConnection, connection.noConnection(*now).value());
  const Pushed& pushed = run.pushed();
  print(pushed, common.json);
  if (pushed.fault != Fault::kNone) return fail(kRefused, {"push", faultInWords(pushed.fault, pushed.deviceFault)});
  if (pushed.added_N == Vec3(0) && !(options.wrench.force_N == Vec3(0)))
    return fail(kRefused, {"push", "nothing was added: another client adds a force, or there is no such hand"});
  return run.wasInterrupted() ? kInterrupted : kDone;
}

}  // namespace haptics
