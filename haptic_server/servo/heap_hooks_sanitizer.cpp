// Under a sanitizer, which owns the heap, the tripwire is called by the sanitizer's own hooks.
#include <sanitizer/allocator_interface.h>

#include "haptic_server/servo/allocation_tripwire.h"

namespace {

const int installed = __sanitizer_install_malloc_and_free_hooks(
    [](const volatile void*, std::size_t) { haptics::AllocationTripwire::heapTouched(); },
    [](const volatile void*) { haptics::AllocationTripwire::heapTouched(); });

}  // namespace
