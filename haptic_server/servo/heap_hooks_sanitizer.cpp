// Under a sanitizer, which owns the heap, the tripwire is called by the sanitizer's own hooks.
#include <cstddef>

#include "haptic_server/servo/allocation_tripwire.h"

// From sanitizer/allocator_interface.h, which g++ does not ship.
extern "C" int __sanitizer_install_malloc_and_free_hooks(void (*onMalloc)(const volatile void*, std::size_t),
                                                         void (*onFree)(const volatile void*));

namespace {

const int installed = __sanitizer_install_malloc_and_free_hooks(
    [](const volatile void*, std::size_t) { haptics::AllocationTripwire::heapTouched(); },
    [](const volatile void*) { haptics::AllocationTripwire::heapTouched(); });

}  // namespace
