#include "haptic_server/servo/allocation_tripwire.h"

#include <atomic>

namespace haptics {
namespace {

constinit thread_local bool armed = false;
constinit std::atomic<std::uint64_t> touches{0};

}  // namespace

AllocationTripwire::AllocationTripwire() noexcept { armed = true; }
AllocationTripwire::~AllocationTripwire() { armed = false; }
std::uint64_t AllocationTripwire::count() noexcept { return touches.load(std::memory_order_relaxed); }
void AllocationTripwire::heapTouched() noexcept {
  if (armed) touches.fetch_add(1, std::memory_order_relaxed);
}

}  // namespace haptics
