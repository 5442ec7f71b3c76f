#include "graphics_client/script/interrupt.h"

#include <csignal>

namespace haptics {
namespace {

volatile std::sig_atomic_t pressed = 0;

void press(int) { pressed = 1; }

}  // namespace

Interrupt::Interrupt() {
  struct sigaction action {};
  action.sa_handler = press;
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
  sigaction(SIGINT, &action, nullptr);
}

Interrupt::~Interrupt() { std::signal(SIGINT, SIG_DFL); }

bool Interrupt::interrupted() noexcept { return pressed != 0; }

}  // namespace haptics
