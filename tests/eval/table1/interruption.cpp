#include "tests/eval/table1/interruption.h"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <thread>

namespace haptics::eval {
namespace {

volatile std::sig_atomic_t interrupted = 0;

void remember(int /*signal*/) { interrupted = 1; }

}  // namespace

Interruption::Interruption() {
  interrupted = 0;
  onInterrupt_ = std::signal(SIGINT, remember);
  onTerminate_ = std::signal(SIGTERM, remember);
}

Interruption::~Interruption() {
  std::signal(SIGINT, onInterrupt_);
  std::signal(SIGTERM, onTerminate_);
}

bool Interruption::came() const noexcept { return interrupted != 0; }

void Interruption::sleep(double seconds) const {
  using Clock = std::chrono::steady_clock;
  using Seconds = std::chrono::duration<double>;
  constexpr Seconds kSlice(0.05);
  const auto end = Clock::now() + std::chrono::duration_cast<Clock::duration>(Seconds(seconds));
  while (!came() && Clock::now() < end) {
    std::this_thread::sleep_for(
        std::min<Clock::duration>(std::chrono::duration_cast<Clock::duration>(kSlice), end - Clock::now()));
  }
}

}  // namespace haptics::eval
