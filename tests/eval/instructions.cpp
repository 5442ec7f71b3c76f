#include "tests/eval/instructions.h"

#include <x86intrin.h>

#include <csignal>
#include <cstdint>

namespace haptics::eval {
namespace {

constexpr unsigned long long kTrapFlag = 0x100;
volatile std::uint64_t steps = 0;

void onTrap(int /*signal*/) { steps = steps + 1; }

std::uint64_t stepsOf(const std::function<void()>& work) {
  steps = 0;
  __writeeflags(__readeflags() | kTrapFlag);
  work();
  __writeeflags(__readeflags() & ~kTrapFlag);
  return steps;
}

}  // namespace

double countInstructions(const std::function<void()>& work) {
  struct sigaction count = {};
  count.sa_handler = onTrap;
  struct sigaction before = {};
  sigaction(SIGTRAP, &count, &before);
  const std::uint64_t all = stepsOf(work);
  const std::uint64_t calling = stepsOf([] {});
  sigaction(SIGTRAP, &before, nullptr);
  return static_cast<double>(all - calling);
}

}  // namespace haptics::eval
