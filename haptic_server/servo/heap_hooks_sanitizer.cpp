// Under a sanitizer, which owns the heap, the tripwire and the meter of work are called by the sanitizer's own hooks.
#include <cstddef>
#include <cstdint>

#include "common/interruption/work_meter.h"
#include "haptic_server/servo/allocation_tripwire.h"

// From sanitizer/allocator_interface.h, which g++ does not ship.
extern "C" int __sanitizer_install_malloc_and_free_hooks(void (*onMalloc)(const volatile void*, std::size_t),
                                                         void (*onFree)(const volatile void*));
extern "C" std::size_t __sanitizer_get_allocated_size(const volatile void* block);

namespace {

const int installed = __sanitizer_install_malloc_and_free_hooks(
    [](const volatile void*, std::size_t size) {
      haptics::AllocationTripwire::heapTouched();
      haptics::WorkMeter::heapGrew(static_cast<std::int64_t>(size));
    },
    [](const volatile void* block) {
      haptics::AllocationTripwire::heapTouched();
      if (haptics::WorkMeter::current() != nullptr)
        haptics::WorkMeter::heapGrew(-static_cast<std::int64_t>(__sanitizer_get_allocated_size(block)));
    });

}  // namespace
