#include "graphics_client/application/watchdog_words.h"

#include <atomic>
#include <cstdint>
#include <utility>

#include "common/log/log.h"
#include "haptics/v1/envelope.pb.h"

namespace haptics {
namespace {

constexpr std::chrono::seconds kEvery{2};

}  // namespace

/// Written on the link's thread, also after the window has gone.
struct WatchdogWords::Said {
  std::atomic<bool> missing = false;
  std::atomic<std::uint64_t> started = 0;
};

WatchdogWords::WatchdogWords(ServerLink& link) : link_(link), said_(std::make_shared<Said>()) {}

QString WatchdogWords::words(const MirrorView& view) {
  if (view.link != LinkState::kLive || view.isReplay) return {};
  if (const auto now = std::chrono::steady_clock::now(); now - asked_ >= kEvery) {
    asked_ = now;
    link_.requestStatus([said = said_](const v1::Status& status) {
      said->missing = status.has_watchdog() && !status.watchdog().alive();
      said->started = status.watchdog().started();
    });
  }
  QString now;
  if (said_->missing) {
    now = "the watchdog is missing: nobody takes the force away should the server hang";
  } else if (said_->started > 1) {
    now = QString("the watchdog ended, and was started again %1 times").arg(said_->started - 1);
  }
  if (std::exchange(logged_, now) != now && !now.isEmpty()) logWarning(now.toStdString());
  return now;
}

}  // namespace haptics
